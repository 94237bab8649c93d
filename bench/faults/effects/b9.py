"""The rudder's effect depends on how long it has been held over."""

from __future__ import annotations

from math import fabs

from ._unforeseen import Chances, UnforeseenForce
from .base import Setting


class B9(UnforeseenForce):
    """The rudder's effect depends on how long it has been held over."""

    id = "B9"
    rank = 48
    signed = False
    response = True

    @staticmethod
    def force(a, t, x, d, length, speed, out):
        dd = d / 0.1745
        out[2] -= a[0] * a[2] * (dd - x[6]) * fabs(x[6])
        out[3] += (dd - x[6]) / a[1]

    def constants(self, s: Setting, c: Chances) -> list[float]:
        return [s.ship.clock * c.between(6, 15.0, 60.0), s.ship.starboard]
