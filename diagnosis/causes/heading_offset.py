"""Cause `heading_offset`."""

from __future__ import annotations

from ...checks.sensors import heading_offset
from ..searches.score import ByScore
from .base import DEGREE, Cause, Number


class HeadingOffset(heading_offset.HeadingOffset, Cause):
    search = ByScore()
    smallest = 0.1 * DEGREE
    power_size = 0.1 * DEGREE
    number = Number("b", ("heading_bias",), scale=0.05 * DEGREE)
    channels = ("psi", "x", "y")
