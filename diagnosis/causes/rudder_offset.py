"""Cause `rudder_offset`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..searches.score import ByScore
from .base import DEGREE, Cause, one

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..candidate import Variant


class RudderOffset(Cause):
    """The rudder's neutral angle: delta_hull = delta_recorded + delta0, delta0 in rad."""

    id = "rudder_offset"
    where = "rudder"
    unit = "rad"
    search = ByScore()
    smallest = 0.1 * DEGREE
    largest = 7.0 * DEGREE
    extension = "rudder_offset"
    power_size = 0.1 * DEGREE
    separate_by = "straight runs at two speeds: what an offset does grows with the speed squared"

    def variants(self, est: Estimator) -> Sequence[Variant]:
        return [one(est, "delta0", "rad", "rudder_offset", scale=0.05 * DEGREE)]
