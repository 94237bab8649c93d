"""Sensor error `sway_offset`."""

from __future__ import annotations

from ..base import SensorError
from ..comparison.series import TrackEffect


class SwayOffset(SensorError):
    """Zero error of the log's athwartships axis: recorded sway = true + b, b in m/s."""

    id = "sway_offset"
    unit = "m/s"
    separate_by = "a straight run with positions"
    track = (TrackEffect("b", "m/s", ("sway_bias",), lambda path: path.of_sway, lambda path: path.sway_floor),)
