"""Hysteresis: the flow depends on the side to which the ship last turned."""

from __future__ import annotations

from math import fabs, tanh

from ._unforeseen import Chances, UnforeseenForce
from .base import Setting


class B3(UnforeseenForce):
    """Hysteresis: the flow depends on the side to which the ship last turned."""

    id = "B3"
    rank = 42
    response = True

    @staticmethod
    def force(a, t, x, d, length, speed, out):
        r = x[2] * length / speed / 0.3
        dd = d / 0.1745
        h = tanh(3.0 * r + 2.0 * x[6])
        out[2] += a[0] * x[6] * (1.0 + 0.5 * fabs(dd))
        out[3] += (h - x[6]) / a[1]

    def constants(self, s: Setting, c: Chances) -> list[float]:
        return [s.ship.clock * c.between(3, 15.0, 60.0)]
