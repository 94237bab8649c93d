"""Cause `rudder_offset`."""

from __future__ import annotations

from ..searches.score import ByScore
from .base import DEGREE, Cause, Number


class RudderOffset(Cause):
    """The rudder's neutral angle: delta_hull = delta_recorded + delta0, delta0 in rad."""

    id = "rudder_offset"
    where = "rudder"
    unit = "rad"
    search = ByScore()
    smallest = 0.1 * DEGREE
    extension = "rudder_offset"
    power_size = 0.1 * DEGREE
    separate_by = "straight runs at two speeds: what an offset does grows with the speed squared"
    number = Number("delta0", ("rudder_offset",), scale=0.05 * DEGREE)
