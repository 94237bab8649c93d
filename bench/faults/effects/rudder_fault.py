"""The rudder loses a share of its effect at a time t0."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from .base import EffectKind, Setting


class RudderFault(EffectKind):
    """The rudder loses a share of its effect at a time t0."""

    id = "rudder_fault"
    rank = 3
    units: ClassVar = {"e": "1", "t0": "s"}
    sized = ("e",)
    cap = 0.95
    response = True

    def draw(self, s: Setting, rng: np.random.Generator) -> dict[str, float]:
        return {"e": -0.03 * float(rng.uniform(0.6, 1.4)), "t0": float(rng.uniform(0.25, 0.65) * s.duration_s)}

    def rudder(self, p) -> dict[str, float]:
        return {"fault": p["e"], "fault_time": p["t0"]}
