"""The water is shallow: its depth is `depth_ratio` times the draught."""

from __future__ import annotations

import numpy as np

from ..ships import Ship
from .base import ScalarKind

COEFFICIENTS = {"mariner": ("Yv", "Nv", "Nr"), "s175": ("Yuv", "Nuv", "Nur"), "kvlcc2-l7": ("Y_v", "N_v", "N_r")}
"""What stands for Y_v, N_v and N_r in each ship's equations."""


class ShallowWater(ScalarKind):
    """The water is shallow: its depth is `depth_ratio` times the draught."""

    id = "shallow_water"
    rank = 32
    parameter, unit = "depth_ratio", "1"
    negative = 0.0
    cap = 1.15
    inverse = True

    def size(self, ship: Ship) -> float:
        return 12.0

    def changed_ship(self, ship: Ship, p) -> Ship:
        factors = zip(COEFFICIENTS[ship.id], shallow_factors(ship, p["depth_ratio"]), strict=True)
        return ship.with_coefficients(**{name: ship.coefficient(name) * factor for name, factor in factors})

    def truths(self, p, ship: Ship, details) -> dict[str, float]:
        return super().truths(p, ship, details) | {"draught_over_depth": 1.0 / p["depth_ratio"]}


def shallow_factors(ship: Ship, depth_ratio: float) -> tuple[float, float, float]:
    """Y_v, N_v and N_r in water of depth h over those in deep water (Hirano et al. 1985 in Inoue's formulas).

    k_e = k/(d k/(2 h) + (x cot x)^q) with k = 2 d/L, x = pi d/(2 h) and q = 2.3, 1.7, .7 for Y_v, N_v, N_r;
    Y_v ~ pi k_e/2 + 1.4 C_b B/L, N_v ~ k_e, N_r ~ .54 k_e - k_e^2.
    """
    d = {k: ship.facts["particulars"][k]["value"] for k in ("L", "B", "d", "nabla")}
    k = 2.0 * d["d"] / d["L"]
    x = 0.5 * np.pi / depth_ratio
    ke = [k / (0.5 * k / depth_ratio + (x / np.tan(x)) ** q) for q in (2.3, 1.7, 0.7)]
    block = 1.4 * d["nabla"] / (d["L"] ** 2 * d["d"])
    sway = (0.5 * np.pi * ke[0] + block) / (0.5 * np.pi * k + block)
    return sway, ke[1] / k, (0.54 * ke[2] - ke[2] ** 2) / (0.54 * k - k**2)
