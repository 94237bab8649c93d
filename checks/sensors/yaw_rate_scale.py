"""Sensor error `yaw_rate_scale`."""

from __future__ import annotations

from ..base import SensorError
from ..comparison.series import TurnEffect, half_a_percent


class YawRateScale(SensorError):
    """Scale error of the rate gyro: recorded yaw rate = (1 + s) true."""

    id = "yaw_rate_scale"
    unit = "1"
    separate_by = "a heading channel of another instrument over a full turn"
    farthest = 1.0
    turn = (TurnEffect("s", "1", ("yaw_rate_scale",), lambda turn: -turn.turned[None], half_a_percent),)
