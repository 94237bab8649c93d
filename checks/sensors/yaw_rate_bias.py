"""Sensor error `yaw_rate_bias`."""

from __future__ import annotations

from ..base import SensorError
from ..comparison.series import TurnEffect


class YawRateBias(SensorError):
    """Zero error of the rate gyro: recorded yaw rate = true + b, b in rad/s."""

    id = "yaw_rate_bias"
    unit = "rad/s"
    separate_by = "a gyro zero reading at rest"
    drifts = True
    turn = (TurnEffect("b", "rad/s", ("yaw_rate_bias",), lambda turn: -turn.time[None], lambda turn: turn.rate_floor),)
