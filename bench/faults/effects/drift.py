"""A force that follows a motion of the ship, or is constant, and grows in time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ._forces import AnticipatedForce, motion, motions
from .base import Setting


class Drift(AnticipatedForce):
    """A force that follows a motion of the ship, or is constant, and grows in time."""

    id = "drift"
    rank = 35

    @staticmethod
    def force(a, t, x, d, length, speed, out):
        out[int(a[2])] += a[0] * t / a[3] * motion(int(a[1]), x, d, length, speed)

    def constants(self, s: Setting, axis: int, rng: np.random.Generator) -> list[float]:
        return [rng.choice([*motions(s), 3]), axis, s.duration_s]

    def variables(self, p: Mapping[str, Any]) -> frozenset[str]:
        return frozenset({"time"})
