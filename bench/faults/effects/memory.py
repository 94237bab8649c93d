"""A force that follows a motion of the ship with a time lag."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ._forces import MOTIONS, AnticipatedForce, motion, motions
from .base import Setting


class Memory(AnticipatedForce):
    """A force that follows a motion of the ship with a time lag."""

    id = "memory"
    rank = 34

    @staticmethod
    def force(a, t, x, d, length, speed, out):
        out[int(a[2])] += a[0] * x[6]
        out[3] += (motion(int(a[1]), x, d, length, speed) - x[6]) / a[3]

    def constants(self, s: Setting, axis: int, rng: np.random.Generator) -> list[float]:
        return [rng.choice(motions(s)), axis, s.ship.clock * np.exp(rng.uniform(np.log(10.0), np.log(80.0)))]

    def variables(self, p: Mapping[str, Any]) -> frozenset[str]:
        return frozenset({f"past of the {MOTIONS[int(p['constants'][1])]}"})
