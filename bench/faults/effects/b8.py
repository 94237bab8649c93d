"""From a time on the ship tows something on one side: drag, and the moment of its lever."""

from __future__ import annotations

from ._unforeseen import Chances, UnforeseenForce
from .base import Setting


class B8(UnforeseenForce):
    """From a time on the ship tows something on one side: drag, and the moment of its lever."""

    id = "B8"
    rank = 47

    @staticmethod
    def force(a, t, x, d, length, speed, out):
        u = x[0] / speed
        if t > a[1]:
            out[0] -= a[0] * 2.0 * u * u
            out[2] += a[0] * a[2] * 0.5 * u * u

    def constants(self, s: Setting, c: Chances) -> list[float]:
        return [c.between(5, 0.25, 0.6) * s.duration_s, c.side]
