"""The rudder loses a share of its force beyond an angle."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from ..regimes import Regime
from ..ships import Ship
from ._regime import RegimeKind
from .base import Setting


class RudderForceLoss(RegimeKind):
    """The rudder loses a share of its force beyond an angle."""

    id = "rudder_force_loss"
    rank = 60
    units: ClassVar = {"loss": "1", "angle": "rad"}
    sized = ("loss",)
    cap = 0.8
    response = True
    right = ("rudder_force", "rudder_large_angle", "rudder_effectiveness", "turning_gain")

    def draw(self, s: Setting, rng: np.random.Generator) -> dict[str, Any]:
        return {
            "loss": 0.1 * float(np.exp(rng.uniform(-0.4, 0.4))),
            "angle": float(np.deg2rad(rng.uniform(11.0, 18.0))),
        }

    def forces(self, p) -> dict[str, float]:
        return {"rudder_loss": p["loss"], "rudder_angle": p["angle"]}

    def regime(self, p, ship: Ship) -> Regime:
        return Regime("rudder", "above", p["angle"])
