"""Squat over a shoal: resistance and damping change with the place, not with time."""

from __future__ import annotations

from math import exp

from ._unforeseen import Chances, UnforeseenForce
from .base import Setting


class B13(UnforeseenForce):
    """Squat over a shoal: resistance and damping change with the place, not with time."""

    id = "B13"
    rank = 52

    @staticmethod
    def force(a, t, x, d, length, speed, out):
        u, r = x[0] / speed, x[2] * length / speed / 0.3
        at = ((x[3] - a[1] * length) ** 2 + (x[4] - a[2] * length) ** 2) / (3.0 * length) ** 2
        out[0] -= a[0] * 2.0 * exp(-at) * u * u
        out[2] -= a[0] * 3.0 * exp(-at) * r

    def constants(self, s: Setting, c: Chances) -> list[float]:
        return [c.north + c.between(12, -2.0, 2.0), c.east + c.between(13, -2.0, 2.0)]
