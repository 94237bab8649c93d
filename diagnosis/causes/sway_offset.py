"""Cause `sway_offset`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..kinematics.series import TrackEffect
from ..searches.score import ByScore
from .base import Cause, one, require_channels

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..state import Variant


class SwayOffset(Cause):
    """Zero error of the log's athwartships axis: recorded sway = true + b, b in m/s."""

    id = "sway_offset"
    where = "sensor"
    unit = "m/s"
    search = ByScore()
    smallest = 0.005
    largest = 1.0
    power_size = 0.005
    separate_by = "a straight run with positions"
    track = (TrackEffect("b", "m/s", ("sway_bias",), lambda path: path.of_sway, lambda path: path.sway_floor),)

    def variants(self, est: Estimator) -> Sequence[Variant]:
        require_channels(est, "v")
        return [one(est, "b", "m/s", "sway_bias", scale=0.005)]
