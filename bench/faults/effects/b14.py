"""Drift deflects the propeller race: a cross term of sway and rudder to one side."""

from __future__ import annotations

from ._unforeseen import Chances, UnforeseenForce
from .base import Setting


class B14(UnforeseenForce):
    """Drift deflects the propeller race: a cross term of sway and rudder to one side."""

    id = "B14"
    rank = 53

    @staticmethod
    def force(a, t, x, d, length, speed, out):
        v = x[1] / speed / 0.1
        dd = d / 0.1745
        out[1] += a[0] * max(a[1] * v, 0.0) * dd
        out[2] += 0.5 * a[0] * a[2] * max(a[1] * v, 0.0) * dd

    def constants(self, s: Setting, c: Chances) -> list[float]:
        return [c.side, c.other_side[1]]
