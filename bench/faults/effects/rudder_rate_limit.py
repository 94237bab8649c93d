"""The rudder moves no faster than a rate; records hold its command."""

from __future__ import annotations

from ..ships import DEGREE, Ship
from .base import ScalarKind


class RudderRateLimit(ScalarKind):
    """The rudder moves no faster than a rate; records hold its command."""

    id = "rudder_rate_limit"
    rank = 5
    parameter, unit = "rate", "rad/s"
    negative = 0.0
    cap = 1e-4
    inverse = True
    command = True
    response = True

    def size(self, ship: Ship) -> float:
        return min(ship.rate_rad_s, 20 * DEGREE / ship.lag_s)

    def rudder(self, p) -> dict[str, float]:
        return {"rate_limit": p["rate"]}
