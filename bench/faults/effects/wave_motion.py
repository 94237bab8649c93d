"""First-order wave motion of heading and yaw rate, narrow-band, different in each record."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from ..ships import DEGREE
from .base import EffectKind, Setting


class WaveMotion(EffectKind):
    """First-order wave motion of heading and yaw rate, narrow-band, different in each record."""

    id = "wave_motion"
    rank = 22
    units: ClassVar = {"rms": "rad", "omega": "rad/s", "damping": "1"}
    sized = ("rms",)
    variance_only = True
    response = True

    def draw(self, s: Setting, rng: np.random.Generator) -> dict[str, tuple]:
        def around(value, spread):
            return tuple(float(value * x) for x in rng.uniform(1 - spread, 1 + spread, s.records))

        omega = rng.uniform(0.5, 0.9) / s.ship.clock
        return {
            "rms": around(0.1 * DEGREE, 0.2),
            "omega": around(omega, 0.05),
            "damping": around(rng.uniform(0.05, 0.15), 0.1),
        }

    def wave(self, p) -> tuple[float, float, float]:
        return p["rms"], p["omega"], p["damping"]
