"""Cause `speed_scale`."""

from __future__ import annotations

from ...checks.sensors import speed_scale
from ..searches.score import ByScore
from .base import Cause, Number


class SpeedScale(speed_scale.SpeedScale, Cause):
    search = ByScore()
    smallest = 0.005
    power_size = 0.002
    number = Number("s", ("surge_scale", "sway_scale"), scale=0.002, low=-0.8, high=2.0)
    channels = ("u", "v")
