"""Sensor error `current`."""

from __future__ import annotations

from ..base import SensorError


class Current(SensorError):
    """Steady uniform current, earth-fixed and per record: the hull's forces depend on velocities through the water;
    speed m/s and the direction (rad) it flows towards."""

    id = "current"
    where = "environment"
    unit = "m/s, rad"
    farthest = 12.0  # m/s: more than the fastest tidal streams
    separate_by = "the same manoeuvre on two headings, or a log that measures speed through the water"
