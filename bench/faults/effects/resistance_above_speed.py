"""The hull resists more above a speed."""

from __future__ import annotations

import numpy as np

from ..regimes import Regime
from ..ships import Ship
from ._forces import ForceKind
from ._regime import RegimeKind
from .base import REGIME, Setting


class ResistanceAboveSpeed(ForceKind, RegimeKind):
    """The hull resists more above a speed (constants[1]: speed over the ship's own)."""

    id = "resistance_above_speed"
    rank = 64
    group = REGIME
    right = ("resistance", "constant_force", "propeller_thrust")

    @staticmethod
    def force(a, t, x, d, length, speed, out):
        if x[0] * x[0] + x[1] * x[1] > (a[1] * speed) ** 2:
            out[0] -= a[0]

    def draw_constants(self, s: Setting, rng: np.random.Generator) -> list[float]:
        return [1.0, float(rng.uniform(0.85, 0.93))]

    def regime(self, p, ship: Ship) -> Regime:
        return Regime("speed", "above", p["constants"][1] * ship.speed_m_s)
