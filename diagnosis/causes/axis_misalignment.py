"""Cause `axis_misalignment`."""

from __future__ import annotations

from ..searches.score import ByScore
from .base import DEGREE, Cause, Number


class AxisMisalignment(Cause):
    """Speed log turned on its mount: recorded surge = u cos a + v sin a, sway = -u sin a + v cos a, a in rad."""

    id = "axis_misalignment"
    where = "sensor"
    unit = "rad"
    search = ByScore()
    smallest = 0.1 * DEGREE
    power_size = 0.1 * DEGREE
    separate_by = "positions on a straight course: the track's direction against heading and log"
    number = Number("angle", ("axis_misalignment",), scale=0.05 * DEGREE, low=-0.8, high=0.8)
    channels = ("u", "v")
