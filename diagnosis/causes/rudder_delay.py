"""Cause `rudder_delay`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..searches.score import ByScore
from .base import Cause, one

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..candidate import Variant


class RudderDelay(Cause):
    """The hull feels the rudder late: delta_hull(t) = delta_recorded(t - tau), tau in s."""

    id = "rudder_delay"
    where = "rudder"
    unit = "s"
    search = ByScore((0.3, 1.0, 2.0, 3.5))
    smallest = 0.05
    largest = 6.0
    power_size = 0.2
    separate_by = "rudder steps with the rudder angle recorded at the stock and on the bridge at once"

    def variants(self, est: Estimator) -> Sequence[Variant]:
        return [one(est, "tau", "s", "rudder_delay", scale=0.05, low=0.0, high=8.0)]
