"""A shear line: the stream pushes only north of a latitude."""

from __future__ import annotations

from math import cos, sin, tanh

import numpy as np

from ._unforeseen import Chances, UnforeseenForce
from .base import Setting


class B11(UnforeseenForce):
    """A shear line: the stream pushes only north of a latitude."""

    id = "B11"
    rank = 50

    @staticmethod
    def force(a, t, x, d, length, speed, out):
        side = 0.5 * (1.0 + tanh((x[3] - a[1] * length) / (0.5 * length)))
        out[0] += a[0] * side * cos(a[2] - x[5])
        out[1] += a[0] * 2.0 * side * sin(a[2] - x[5])

    def constants(self, s: Setting, c: Chances) -> list[float]:
        return [c.north + c.between(8, -2.0, 2.0), c.between(9, -np.pi, np.pi)]
