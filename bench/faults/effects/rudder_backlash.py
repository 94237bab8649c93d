"""The rudder has play: it follows only when the recorded angle has moved by b."""

from __future__ import annotations

from ..ships import DEGREE, Ship
from .base import ScalarKind


class RudderBacklash(ScalarKind):
    """The rudder has play: it follows only when the recorded angle has moved by b."""

    id = "rudder_backlash"
    rank = 4
    parameter, unit = "b", "rad"
    negative = 0.0
    cap = 10 * DEGREE
    response = True

    def size(self, ship: Ship) -> float:
        return 0.3 * DEGREE

    def rudder(self, p) -> dict[str, float]:
        return {"play": p["b"]}
