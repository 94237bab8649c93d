"""A bank to one side: suction and bow cushion that decrease with the distance from it."""

from __future__ import annotations

from math import exp, fabs

from ._unforeseen import Chances, UnforeseenForce
from .base import Setting


class B1(UnforeseenForce):
    """A bank to one side: suction and bow cushion that decrease with the distance from it."""

    id = "B1"
    rank = 40

    @staticmethod
    def force(a, t, x, d, length, speed, out):
        u = x[0] / speed
        near = exp(-fabs(x[4] - a[1] * length) / (a[2] * length))
        out[1] += a[0] * u * u * near
        out[2] -= 0.6 * a[0] * u * u * near

    def constants(self, s: Setting, c: Chances) -> list[float]:
        return [c.east + c.between(0, -2.0, 2.0), c.between(1, 2.0, 5.0)]
