"""Cause `heading_delay`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...checks.sensors import heading_delay
from ..searches.score import ByScore
from .base import Cause, one, require_channels

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..candidate import Variant


class HeadingDelay(heading_delay.HeadingDelay, Cause):
    search = ByScore((0.1, 0.4, 1.0, 2.0))
    smallest = 0.05
    largest = 4.0
    power_size = 0.2

    def variants(self, est: Estimator) -> Sequence[Variant]:
        require_channels(est, "psi")
        return [one(est, "tau", "s", "heading_delay", scale=0.05, low=0.0, high=5.0)]
