"""A force at a fixed frequency."""

from __future__ import annotations

from collections.abc import Mapping
from math import cos
from typing import Any

import numpy as np

from ._forces import AnticipatedForce
from .base import Setting


class Periodic(AnticipatedForce):
    """A force at a fixed frequency."""

    id = "periodic"
    rank = 38

    @staticmethod
    def force(a, t, x, d, length, speed, out):
        out[int(a[2])] += a[0] * cos(a[1] * t + a[3])

    def constants(self, s: Setting, axis: int, rng: np.random.Generator) -> list[float]:
        return [rng.uniform(0.12, 0.4) / s.ship.clock, axis, rng.uniform(-np.pi, np.pi)]

    def variables(self, p: Mapping[str, Any]) -> frozenset[str]:
        return frozenset({"time"})
