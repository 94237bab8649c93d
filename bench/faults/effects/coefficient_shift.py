"""One hull coefficient is larger by a fraction of itself."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from ..ships import Ship
from .base import EffectKind, Setting, random_sign

HULL = {
    "mariner": ("Yv", "Yr", "Nv", "Nr", "Nvvr", "Yvvr", "Xvv"),
    "s175": ("Yuv", "Yur", "Nuv", "Nur", "Nvvr", "Yvvv", "Xvr"),
    "kvlcc2-l7": ("Y_v", "Y_r", "N_v", "N_r", "N_vvr", "Y_vvv", "R_0"),
    "response-1": ("T", "alpha"),
    "response-2": ("g", "h", "alpha"),
    "cargo": ("T1", "T2", "T3"),
}


class CoefficientShift(EffectKind):
    """One hull coefficient is larger by a fraction of itself."""

    id = "coefficient_shift"
    rank = 33
    units: ClassVar = {"name": "", "fraction": "1"}
    sized = ("fraction",)
    cap = 0.9
    response = True

    def draw(self, s: Setting, rng: np.random.Generator) -> dict[str, Any]:
        return {"name": str(rng.choice(HULL[s.ship.id])), "fraction": 0.02 * random_sign(rng) * rng.uniform(0.7, 1.4)}

    def changed_ship(self, ship: Ship, p) -> Ship:
        name, factor = p["name"], 1.0 + p["fraction"]
        if ship.id == "cargo" and name in ("T1", "T2"):
            published = ship.facts["parameters"]
            t1, t2 = (published[k]["value"] * (factor if k == name else 1.0) for k in ("T1", "T2"))
            return ship.with_coefficients(h=t1 * t2, g=t1 + t2)
        return ship.with_coefficients(**{name: ship.coefficient(name) * factor})

    def truths(self, p, ship: Ship, details) -> dict[str, float]:
        """A finding states the fraction of the coefficient that it names."""
        found = {f"fraction:{p['name']}": p["fraction"]}
        return found | ({"fraction": p["fraction"]} if details.get("coefficient", p["name"]) == p["name"] else {})
