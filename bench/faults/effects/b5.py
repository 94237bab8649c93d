"""Sway force and yaw moment of a deflected rudder, the same to both sides."""

from __future__ import annotations

from math import fabs

from ._unforeseen import Chances, UnforeseenForce
from .base import Setting


class B5(UnforeseenForce):
    """Sway force and yaw moment of a deflected rudder, the same to both sides."""

    id = "B5"
    rank = 44

    @staticmethod
    def force(a, t, x, d, length, speed, out):
        u = x[0] / speed
        dd = d / 0.1745
        out[1] += a[0] * fabs(dd) * u
        out[2] += 0.3 * a[0] * fabs(dd) * u

    def constants(self, s: Setting, c: Chances) -> list[float]:
        return [0.0]
