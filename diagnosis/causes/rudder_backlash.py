"""Cause `rudder_backlash`."""

from __future__ import annotations

from ..searches.score import ByScore
from .base import DEGREE, Cause, Number


class RudderBacklash(Cause):
    """Play of +- b rad between the recorded and the acting rudder (linkage wear): the hull's rudder follows only
    once the recorded one has moved through it."""

    id = "rudder_backlash"
    where = "rudder"
    unit = "rad"
    search = ByScore((0.15 * DEGREE, 0.4 * DEGREE, DEGREE, 2.0 * DEGREE))
    smallest = 0.1 * DEGREE
    power_size = 0.3 * DEGREE
    separate_by = "slow small-angle rudder sweeps in both directions"
    number = Number("b", ("rudder_backlash",), scale=0.1 * DEGREE, low=0.0, high=12.0 * DEGREE)
