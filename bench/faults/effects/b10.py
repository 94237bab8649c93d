"""Water that sloshes athwartships."""

from __future__ import annotations

from ._unforeseen import Chances, UnforeseenForce
from .base import Setting


class B10(UnforeseenForce):
    """Water that sloshes athwartships."""

    id = "B10"
    rank = 49

    @staticmethod
    def force(a, t, x, d, length, speed, out):
        v, r = x[1] / speed / 0.1, x[2] * length / speed / 0.3
        w, force = a[1], v + 2.0 * r
        out[1] += a[0] * 2.0 * x[6]
        out[2] += a[0] * 0.3 * x[6]
        out[3] += w * x[7]
        out[4] += w * (force - x[6] - 0.12 * x[7])

    def constants(self, s: Setting, c: Chances) -> list[float]:
        return [c.between(7, 0.15, 0.6) / s.ship.clock]
