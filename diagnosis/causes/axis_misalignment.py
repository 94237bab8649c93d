"""Cause `axis_misalignment`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..searches.score import ByScore
from .base import DEGREE, Cause, one, require_channels

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..candidate import Variant


class AxisMisalignment(Cause):
    """Speed log turned on its mount: recorded surge = u cos a + v sin a, sway = -u sin a + v cos a, a in rad."""

    id = "axis_misalignment"
    where = "sensor"
    unit = "rad"
    search = ByScore()
    smallest = 0.1 * DEGREE
    largest = 12.0 * DEGREE
    power_size = 0.1 * DEGREE
    separate_by = "positions on a straight course: the track's direction against heading and log"

    def variants(self, est: Estimator) -> Sequence[Variant]:
        require_channels(est, "u", "v")
        return [one(est, "angle", "rad", "axis_misalignment", scale=0.05 * DEGREE, low=-0.8, high=0.8)]
