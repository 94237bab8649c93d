"""A force that follows two or three times the heading."""

from __future__ import annotations

from collections.abc import Mapping
from math import cos
from typing import Any

import numpy as np

from ._forces import AnticipatedForce
from .base import Setting


class Harmonic(AnticipatedForce):
    """A force that follows two or three times the heading."""

    id = "harmonic"
    rank = 36

    @staticmethod
    def force(a, t, x, d, length, speed, out):
        out[int(a[2])] += a[0] * cos(a[1] * x[5] + a[3])

    def constants(self, s: Setting, axis: int, rng: np.random.Generator) -> list[float]:
        return [rng.choice([2, 3]), axis, rng.uniform(-np.pi, np.pi)]

    def variables(self, p: Mapping[str, Any]) -> frozenset[str]:
        return frozenset({"heading"})
