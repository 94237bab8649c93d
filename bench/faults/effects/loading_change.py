"""The ship is heavier by a fraction of her mass, with the same radius of gyration."""

from __future__ import annotations

from ..ships import Ship
from .base import ScalarKind


class LoadingChange(ScalarKind):
    """The ship is heavier by a fraction of her mass, with the same radius of gyration."""

    id = "loading_change"
    rank = 31
    parameter, unit = "fraction", "1"
    cap = 0.6

    def size(self, ship: Ship) -> float:
        return 0.01

    def forces(self, p) -> dict[str, float]:
        return {"mass_fraction": p["fraction"]}
