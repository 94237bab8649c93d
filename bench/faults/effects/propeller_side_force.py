"""The propeller pushes the stern sideways while the ship turns to one side."""

from __future__ import annotations

import numpy as np

from ..regimes import Regime
from ..ships import Ship
from ._forces import ForceKind
from ._regime import RegimeKind
from .base import REGIME, Setting


class PropellerSideForce(ForceKind, RegimeKind):
    """The propeller pushes the stern sideways while the ship turns to one side (constants[1]: -1 port, 1 starboard)."""

    id = "propeller_side_force"
    rank = 61
    group = REGIME
    response = True
    right = ("asymmetry", "neutral_rudder_angle", "rudder_offset", "constant_force")

    @staticmethod
    def force(a, t, x, d, length, speed, out):
        if a[1] * x[2] > 0.0:
            out[1] += a[0]
            out[2] -= a[0]

    def draw_constants(self, s: Setting, rng: np.random.Generator) -> list[float]:
        return [float(rng.choice([-1.0, 1.0])), float(rng.choice([-1.0, 1.0]))]

    def regime(self, p, ship: Ship) -> Regime:
        return Regime("side", "port" if p["constants"][1] < 0.0 else "starboard")
