"""The rudder turns no further than an angle; records hold its command."""

from __future__ import annotations

from ..ships import DEGREE, Ship
from .base import ScalarKind


class RudderSaturation(ScalarKind):
    """The rudder turns no further than an angle; records hold its command."""

    id = "rudder_saturation"
    rank = 6
    parameter, unit = "limit", "rad"
    negative = 0.0
    cap = 0.02
    inverse = True
    command = True
    response = True

    def size(self, ship: Ship) -> float:
        return 24 * DEGREE

    def rudder(self, p) -> dict[str, float]:
        return {"saturation": p["limit"]}
