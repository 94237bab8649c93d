"""Cause `speed_scale`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...checks.sensors import speed_scale
from ..searches.score import ByScore
from .base import Cause, one, require_channels

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..candidate import Variant


class SpeedScale(speed_scale.SpeedScale, Cause):
    search = ByScore()
    smallest = 0.005
    largest = 0.3
    power_size = 0.002

    def variants(self, est: Estimator) -> Sequence[Variant]:
        require_channels(est, "u", "v")
        return [one(est, "s", "1", "surge_scale", "sway_scale", scale=0.002, low=-0.8, high=2.0)]
