"""Cause `current`."""

from __future__ import annotations

from ..searches.score import ByRings
from ._pairs import PairCause


class Current(PairCause):
    """Steady uniform current, earth-fixed and per record: the hull's forces depend on velocities through the water;
    speed m/s and the direction (rad) it flows towards."""

    id = "current"
    where = "environment"
    unit = "m/s, rad"
    search = ByRings((0.02, 0.1, 0.4))
    smallest = 0.01
    largest = 4.0
    extension = "current"
    power_size = 0.05
    separate_by = "the same manoeuvre on two headings, or a log that measures speed through the water"
    entries = ("current_towards_north", "current_towards_east")
    size_name, direction_name, coming_from = "speed", "towards", False
    scale = 0.01
