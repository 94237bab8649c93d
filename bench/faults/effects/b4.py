"""Yaw damping that acts to one side only."""

from __future__ import annotations

from math import fabs

from ._unforeseen import Chances, UnforeseenForce
from .base import Setting


class B4(UnforeseenForce):
    """Yaw damping that acts to one side only."""

    id = "B4"
    rank = 43
    response = True

    @staticmethod
    def force(a, t, x, d, length, speed, out):
        r = x[2] * length / speed / 0.3
        out[2] -= a[0] * a[2] * (max(a[1] * r, 0.0) * a[1]) * (1.0 + fabs(r))

    def constants(self, s: Setting, c: Chances) -> list[float]:
        return [c.side, c.other_side[0]]
