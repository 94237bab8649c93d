"""The rudder stalls above an angle."""

from __future__ import annotations

from math import fabs

import numpy as np

from ._unforeseen import Chances, UnforeseenForce
from .base import Setting


class B2(UnforeseenForce):
    """The rudder stalls above an angle."""

    id = "B2"
    rank = 41
    signed = False
    response = True

    @staticmethod
    def force(a, t, x, d, length, speed, out):
        over = max(fabs(d) - a[1], 0.0) / 0.1745
        out[2] -= a[0] * over * (1.0 if d * a[2] > 0 else -1.0)

    def constants(self, s: Setting, c: Chances) -> list[float]:
        return [np.deg2rad(c.between(2, 5.0, 12.0)), s.ship.starboard]
