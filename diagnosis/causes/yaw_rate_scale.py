"""Cause `yaw_rate_scale`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..kinematics.series import TurnEffect, half_a_percent
from ..searches.score import ByScore
from .base import Cause, one, require_channels

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..state import Variant


class YawRateScale(Cause):
    """Scale error of the rate gyro: recorded yaw rate = (1 + s) true."""

    id = "yaw_rate_scale"
    where = "sensor"
    unit = "1"
    search = ByScore()
    smallest = 0.005
    largest = 0.3
    power_size = 0.01
    separate_by = "a heading channel of another instrument over a full turn"
    turn = (TurnEffect("s", "1", ("yaw_rate_scale",), lambda turn: -turn.turned[None], half_a_percent),)

    def variants(self, est: Estimator) -> Sequence[Variant]:
        require_channels(est, "r")
        return [one(est, "s", "1", "yaw_rate_scale", scale=0.005, low=-0.8, high=2.0)]
