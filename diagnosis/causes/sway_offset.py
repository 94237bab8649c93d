"""Cause `sway_offset`."""

from __future__ import annotations

from ...checks.sensors import sway_offset
from ..searches.score import ByScore
from .base import Cause, Number


class SwayOffset(sway_offset.SwayOffset, Cause):
    search = ByScore()
    smallest = 0.005
    power_size = 0.005
    number = Number("b", ("sway_bias",), scale=0.005)
    channels = ("v",)
