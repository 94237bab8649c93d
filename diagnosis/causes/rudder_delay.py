"""Cause `rudder_delay`."""

from __future__ import annotations

from ..searches.score import ByScore
from .base import Cause, Number


class RudderDelay(Cause):
    """The hull feels the rudder late: delta_hull(t) = delta_recorded(t - tau), tau in s."""

    id = "rudder_delay"
    where = "rudder"
    unit = "s"
    search = ByScore((0.3, 1.0, 2.0, 3.5))
    smallest = 0.05
    power_size = 0.2
    separate_by = "rudder steps with the rudder angle recorded at the stock and on the bridge at once"
    number = Number("tau", ("rudder_delay",), scale=0.05, low=0.0, high=8.0)
