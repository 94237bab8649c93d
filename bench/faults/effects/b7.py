"""Further resistance of a turning ship with deflected rudder."""

from __future__ import annotations

from math import fabs

from ._unforeseen import Chances, UnforeseenForce
from .base import Setting


class B7(UnforeseenForce):
    """Further resistance of a turning ship with deflected rudder."""

    id = "B7"
    rank = 46
    signed = False

    @staticmethod
    def force(a, t, x, d, length, speed, out):
        r = x[2] * length / speed / 0.3
        dd = d / 0.1745
        out[0] -= a[0] * 3.0 * r * r * fabs(dd)

    def constants(self, s: Setting, c: Chances) -> list[float]:
        return [0.0]
