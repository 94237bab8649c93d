"""A constant force for a part of the record, such as a tug's."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ._forces import AnticipatedForce
from .base import Setting


class Pulse(AnticipatedForce):
    """A constant force for a part of the record, such as a tug's."""

    id = "pulse"
    rank = 37

    @staticmethod
    def force(a, t, x, d, length, speed, out):
        out[int(a[2])] += a[0] if a[1] <= t < a[1] + a[3] else 0.0

    def constants(self, s: Setting, axis: int, rng: np.random.Generator) -> list[float]:
        return [rng.uniform(0.2, 0.7) * s.duration_s, axis, s.ship.clock * rng.uniform(20.0, 60.0)]

    def variables(self, p: Mapping[str, Any]) -> frozenset[str]:
        return frozenset({"time"})
