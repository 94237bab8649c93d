"""Cause `sway_offset`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...checks.sensors import sway_offset
from ..searches.score import ByScore
from .base import Cause, one, require_channels

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..candidate import Variant


class SwayOffset(sway_offset.SwayOffset, Cause):
    search = ByScore()
    smallest = 0.005
    largest = 1.0
    power_size = 0.005

    def variants(self, est: Estimator) -> Sequence[Variant]:
        require_channels(est, "v")
        return [one(est, "b", "m/s", "sway_bias", scale=0.005)]
