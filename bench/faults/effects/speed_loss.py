"""A response ship loses speed in a turn."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from ..ships import FIRST, Ship
from .base import EffectKind, Setting


class SpeedLoss(EffectKind):
    """A response ship loses speed in a turn."""

    id = "speed_loss"
    rank = 29
    units: ClassVar = {"drop": "1", "recovery": "s"}
    sized = ("drop",)
    three_dof, response = False, True

    def draw(self, s: Setting, rng: np.random.Generator) -> dict[str, float]:
        time = s.ship.coefficient("T") if s.ship.kind == FIRST else s.ship.coefficient("g")
        return {"drop": 0.03, "recovery": float(time * rng.uniform(1.0, 3.0))}

    def forces(self, p) -> dict[str, float]:
        return dict(p)

    def truths(self, p, ship: Ship, details) -> dict[str, float]:
        return super().truths(p, ship, details) | {"loss_gain": p["drop"] * (ship.length_m / ship.speed_m_s) ** 2}
