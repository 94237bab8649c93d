"""Cause `heading_delay`."""

from __future__ import annotations

from ...checks.sensors import heading_delay
from ..searches.score import ByScore
from .base import Cause, Number


class HeadingDelay(heading_delay.HeadingDelay, Cause):
    search = ByScore((0.1, 0.4, 1.0, 2.0))
    smallest = 0.05
    power_size = 0.2
    number = Number("tau", ("heading_delay",), scale=0.05, low=0.0, high=5.0)
    channels = ("psi",)
