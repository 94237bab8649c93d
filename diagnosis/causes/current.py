"""Cause `current`."""

from __future__ import annotations

from ...checks.sensors import current
from ..searches.score import ByRings
from ._pairs import PairCause


class Current(current.Current, PairCause):
    search = ByRings((0.02, 0.1, 0.4))
    smallest = 0.01
    extension = "current"
    power_size = 0.05
    entries = ("current_towards_north", "current_towards_east")
    size_name, direction_name, coming_from = "speed", "towards", False
    scale = 0.01
