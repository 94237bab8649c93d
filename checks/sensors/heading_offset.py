"""Sensor error `heading_offset`."""

from __future__ import annotations

from ..base import SensorError
from ..comparison.series import TrackEffect, half_a_degree


class HeadingOffset(SensorError):
    """Misread heading: recorded = true + b, b in rad; the track shows it."""

    id = "heading_offset"
    unit = "rad"
    separate_by = "positions on two opposite straight courses"
    track = (TrackEffect("b", "rad", ("heading_bias",), lambda path: path.turned_way, half_a_degree),)
    track_rivals = ("axis_misalignment",)
