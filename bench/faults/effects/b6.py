"""The rudder moves again with the yaw acceleration of a moment ago: a loose quadrant."""

from __future__ import annotations

from math import fabs

from ._unforeseen import Chances, UnforeseenForce
from .base import Setting


class B6(UnforeseenForce):
    """The rudder moves again with the yaw acceleration of a moment ago: a loose quadrant."""

    id = "B6"
    rank = 45
    response = True

    @staticmethod
    def force(a, t, x, d, length, speed, out):
        r = x[2] * length / speed / 0.3
        dd = d / 0.1745
        out[2] += a[0] * 2.0 * (r - x[6]) * fabs(dd)
        out[3] += (r - x[6]) / a[1]

    def constants(self, s: Setting, c: Chances) -> list[float]:
        return [s.ship.clock * c.between(4, 8.0, 25.0)]
