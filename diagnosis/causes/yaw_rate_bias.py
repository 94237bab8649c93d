"""Cause `yaw_rate_bias`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..kinematics.series import TurnEffect
from ..searches.score import ByScore
from .base import DEGREE, Cause, one, require_channels

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..state import Variant


class YawRateBias(Cause):
    """Zero error of the rate gyro: recorded yaw rate = true + b, b in rad/s."""

    id = "yaw_rate_bias"
    where = "sensor"
    unit = "rad/s"
    search = ByScore()
    power_size = 0.003 * DEGREE
    separate_by = "a gyro zero reading at rest"
    drifts = True
    turn = (TurnEffect("b", "rad/s", ("yaw_rate_bias",), lambda turn: -turn.time[None], lambda turn: turn.rate_floor),)

    def variants(self, est: Estimator) -> Sequence[Variant]:
        require_channels(est, "r")
        return [one(est, "b", "rad/s", "yaw_rate_bias", scale=0.002 * DEGREE)]
