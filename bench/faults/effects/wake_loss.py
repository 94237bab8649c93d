"""The water reaches the propeller more slowly than the wake law says beyond an angle of drift."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from ..regimes import Regime
from ..ships import KVLCC2, S175, Ship
from ._regime import RegimeKind
from .base import Setting


class WakeLoss(RegimeKind):
    """The water reaches the propeller more slowly than the wake law says beyond an angle of drift."""

    id = "wake_loss"
    rank = 62
    units: ClassVar = {"loss": "1", "drift": "rad"}
    sized = ("loss",)
    cap = 0.6
    right = ("wake_in_turns", "wake_and_thrust_deduction", "rudder_inflow")

    def carried_by(self, ship: Ship) -> bool:
        """Ships whose equations hold a propeller."""
        return ship.kind in (S175, KVLCC2)

    def draw(self, s: Setting, rng: np.random.Generator) -> dict[str, Any]:
        return {"loss": 0.08 * float(np.exp(rng.uniform(-0.4, 0.4))), "drift": float(np.deg2rad(rng.uniform(3.0, 7.0)))}

    def forces(self, p) -> dict[str, float]:
        return {"wake_loss": p["loss"], "wake_drift": p["drift"]}

    def regime(self, p, ship: Ship) -> Regime:
        return Regime("drift", "above", p["drift"])
