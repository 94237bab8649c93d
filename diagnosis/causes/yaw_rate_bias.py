"""Cause `yaw_rate_bias`."""

from __future__ import annotations

from ...checks.sensors import yaw_rate_bias
from ..searches.score import ByScore
from .base import DEGREE, Cause, Number


class YawRateBias(yaw_rate_bias.YawRateBias, Cause):
    search = ByScore()
    power_size = 0.003 * DEGREE
    number = Number("b", ("yaw_rate_bias",), scale=0.002 * DEGREE)
    channels = ("r",)
