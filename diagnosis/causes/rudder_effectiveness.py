"""Cause `rudder_effectiveness`."""

from __future__ import annotations

from ..searches.score import ByScore
from .base import Cause, Number


class RudderEffectiveness(Cause):
    """Rudder force over what is modelled, as a share more: delta_hull = (1 + e) delta_recorded (-0.2: 20 % lost)."""

    gains = ("b", "b1")  # turning gains of response models, which it is nothing else than

    id = "rudder_effectiveness"
    where = "rudder"
    unit = "1"
    search = ByScore()
    smallest = 0.01
    extension = "rudder_effectiveness"
    power_size = 0.02
    separate_by = "a bollard or captive rudder-force test, or rudder angles from small to hard over"
    number = Number("e", ("rudder_effectiveness",), scale=0.01, low=-0.95, high=2.0)

    def stands_beside_numbers(self, is_3dof: bool) -> bool:
        return is_3dof  # else it is the turning gain
