"""A constant force on the hull, in body axes."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from ..simulator import rudder_force
from .base import EffectKind, Setting


class ConstantForce(EffectKind):
    """A constant force on the hull, in body axes."""

    id = "constant_force"
    rank = 24
    units: ClassVar = {"X": "N", "Y": "N", "N": "N m"}
    sized = ("X", "Y", "N")

    def draw(self, s: Setting, rng: np.random.Generator) -> dict[str, float]:
        side, yaw = rudder_force(s.ship)
        direction = rng.standard_normal(3)
        direction /= np.linalg.norm(direction)
        return dict(zip("XYN", map(float, 0.005 * direction * np.array([side, side, yaw])), strict=True))

    def forces(self, p) -> dict[str, float]:
        return dict(p)
