"""A further yaw moment Nrr r|r|; of a response ship, alpha r|r| in s/rad."""

from __future__ import annotations

from ..ships import Ship
from .base import ScalarKind, damping_size


class YawDampingQuadratic(ScalarKind):
    """A further yaw moment Nrr r|r|; of a response ship, alpha r|r| in s/rad."""

    id = "yaw_damping_quadratic"
    rank = 25
    parameter, unit = "Nrr", "1"
    negative = 0.75

    def carried_by(self, ship: Ship) -> bool:
        return ship.is_3dof or ship.id in ("response-1", "response-2", "cargo")

    def size(self, ship: Ship) -> float:
        return damping_size(ship)

    def forces(self, p) -> dict[str, float]:
        return {"Nrr": p["Nrr"], "r_quadratic": p["Nrr"]}
