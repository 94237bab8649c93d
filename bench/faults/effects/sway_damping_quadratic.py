"""A further sway force Yvv v|v|."""

from __future__ import annotations

from ..ships import Ship
from .base import ScalarKind, damping_size


class SwayDampingQuadratic(ScalarKind):
    """A further sway force Yvv v|v|."""

    id = "sway_damping_quadratic"
    rank = 27
    parameter, unit = "Yvv", "1"
    negative = 0.75

    def size(self, ship: Ship) -> float:
        return 10 * damping_size(ship)

    def forces(self, p) -> dict[str, float]:
        return dict(p)
