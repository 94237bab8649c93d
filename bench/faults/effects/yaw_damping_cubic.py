"""A further yaw moment Nrrr r^3; of a response ship without that term, alpha r^3 in s2/rad2."""

from __future__ import annotations

from ..ships import Ship
from .base import ScalarKind, damping_size


class YawDampingCubic(ScalarKind):
    """A further yaw moment Nrrr r^3; of a response ship without that term, alpha r^3 in s2/rad2."""

    id = "yaw_damping_cubic"
    rank = 26
    parameter, unit = "Nrrr", "1"
    negative = 0.75

    def carried_by(self, ship: Ship) -> bool:
        return ship.is_3dof or ship.id in ("cargo",)

    def size(self, ship: Ship) -> float:
        return damping_size(ship)

    def forces(self, p) -> dict[str, float]:
        return {"Nrrr": p["Nrrr"], "r_cubic": p["Nrrr"]}
