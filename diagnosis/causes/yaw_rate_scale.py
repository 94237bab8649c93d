"""Cause `yaw_rate_scale`."""

from __future__ import annotations

from ...checks.sensors import yaw_rate_scale
from ..searches.score import ByScore
from .base import Cause, Number


class YawRateScale(yaw_rate_scale.YawRateScale, Cause):
    search = ByScore()
    smallest = 0.005
    power_size = 0.01
    number = Number("s", ("yaw_rate_scale",), scale=0.005, low=-0.8, high=2.0)
    channels = ("r",)
