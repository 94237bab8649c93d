"""A first-order response ship has a second time constant T2 and a lead T3."""

from __future__ import annotations

from dataclasses import replace
from math import inf
from typing import ClassVar

import numpy as np

from ..ships import FIRST, SECOND, SECOND_NAMES, Ship
from .base import EffectKind, Setting


class SecondOrderLead(EffectKind):
    """A first-order response ship has a second time constant T2 and a lead T3."""

    id = "second_order_lead"
    rank = 30
    units: ClassVar = {"T2": "s", "T3": "s"}
    sized = ("T2", "T3")

    def carried_by(self, ship: Ship) -> bool:
        return ship.kind == FIRST

    def draw(self, s: Setting, rng: np.random.Generator) -> dict[str, float]:
        t2 = 0.02 * s.ship.coefficient("T") * rng.uniform(0.7, 1.4)
        return {"T2": float(t2), "T3": float(t2 * rng.uniform(0.1, 0.6))}

    def changed_ship(self, ship: Ship, p) -> Ship:
        """(1 + T s)(1 + T2 s) r + alpha r^3 = K (1 + T3 s) delta for the first-order ship's own T.

        Both times are increased where T2 is too short to be integrated, which leaves their effect as it is.
        """
        t, short = ship.coefficient("T"), max(0.02 - p["T2"], 0.0)
        t2, t3 = p["T2"] + short, p["T3"] + short
        values = {"h": t * t2, "g": t + t2, "K": ship.coefficient("K"), "T3": t3, "alpha": ship.coefficient("alpha")}
        numbers = np.array([values[name] for name in SECOND_NAMES])
        return replace(ship, kind=SECOND, names=tuple(SECOND_NAMES), coefficients=numbers)

    def truths(self, p, ship: Ship, details) -> dict[str, float]:
        lead = 1.0 - p["T3"] / p["T2"] if p["T2"] else inf
        return super().truths(p, ship, details) | {"lead": lead}
