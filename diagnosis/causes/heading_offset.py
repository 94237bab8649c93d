"""Cause `heading_offset`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...checks.sensors import heading_offset
from ..searches.score import ByScore
from .base import DEGREE, Cause, one, require_channels

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..candidate import Variant


class HeadingOffset(heading_offset.HeadingOffset, Cause):
    search = ByScore()
    smallest = 0.1 * DEGREE
    largest = 17.0 * DEGREE
    power_size = 0.1 * DEGREE

    def variants(self, est: Estimator) -> Sequence[Variant]:
        require_channels(est, "psi", "x", "y")
        return [one(est, "b", "rad", "heading_bias", scale=0.05 * DEGREE)]
