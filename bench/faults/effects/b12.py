"""The rudder's effect varies in a slow cycle, the more the larger its angle."""

from __future__ import annotations

from math import fabs, sin

import numpy as np

from ._unforeseen import Chances, UnforeseenForce
from .base import Setting


class B12(UnforeseenForce):
    """The rudder's effect varies in a slow cycle, the more the larger its angle."""

    id = "B12"
    rank = 51
    response = True

    @staticmethod
    def force(a, t, x, d, length, speed, out):
        dd = d / 0.1745
        out[2] += a[0] * dd * fabs(dd) * sin(a[1] * t + a[2])

    def constants(self, s: Setting, c: Chances) -> list[float]:
        return [c.between(10, 0.03, 0.1) / s.ship.clock, c.between(11, -np.pi, np.pi)]
