"""Cause `wind`."""

from __future__ import annotations

from ..searches.score import ByRings
from ._pairs import PairCause


class Wind(PairCause):
    """Mean wind, earth-fixed and per record, on the vessel's windage; speed m/s and direction (rad) it blows from."""

    id = "wind"
    where = "environment"
    unit = "m/s, rad"
    search = ByRings((3.0, 7.0, 13.0))
    smallest = 0.5
    extension = "wind"
    power_size = 3.0
    separate_by = "an anemometer, or the same manoeuvre on two headings and at two speeds"
    entries = ("wind_towards_north", "wind_towards_east")
    size_name, direction_name, coming_from = "speed", "from", True
    scale = 1.0
