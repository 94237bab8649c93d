"""Effects whose force is no term of the equations: each brings its own force function.

A force function is compiled by itself (a numba C function) and handed to the integrator, so that a new kind needs no
edit of the equations.  Its forces are in units of the rudder's sway force and yaw moment at 10 deg, so that a size is
comparable between ships.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from ....models.compilation import njit
from ..simulator import CONSTANTS
from .base import ANTICIPATED, EffectKind, Setting

AXES = {"Y": 1, "N": 2}


@njit(cache=True)
def motion(which, x, d, length, speed):
    """A motion as a number of order one: rudder (0), yaw rate (1), sway velocity (2), or 1 (3)."""
    if which == 0:
        return d / 0.1745
    if which == 1:
        return x[2] * length / speed / 0.3
    return x[1] / speed / 0.1 if which == 2 else 1.0


class ForceKind(EffectKind):
    """A kind with a force function of its own."""

    units: ClassVar[Mapping[str, str]] = {"size": "rudder force at 10 deg"}
    sized = ("size",)
    whole = ("constants",)

    @staticmethod
    @abstractmethod
    def force(a, t, x, d, length, speed, out):
        """Add X, Y, N and the rates of two hidden states to out (5,).

        a (6,): size and constants; t s; x (8,): u, v, r, north, east, heading and the two hidden states; d: rudder at
        the hull, rad; length m and speed m/s of the ship.  Compiled by numba.
        """

    @abstractmethod
    def draw_constants(self, s: Setting, rng: np.random.Generator) -> list[float]:
        """Sign of the size, then up to five constants."""

    def draw(self, s: Setting, rng: np.random.Generator) -> dict[str, Any]:
        values = [float(value) for value in self.draw_constants(s, rng)]
        return {"constants": tuple(values + [0.0] * (CONSTANTS - len(values))), "size": 0.005}

    def vector(self, p: Mapping[str, Any]) -> np.ndarray:
        """What the force function gets as `a` (6,)."""
        a = np.array(p["constants"])
        a[0] *= p["size"]
        return a


class AnticipatedForce(ForceKind):
    """An unknown force of a kind that a diagnosis may have a test for: on sway or on yaw."""

    group = ANTICIPATED
    response = True

    @abstractmethod
    def constants(self, s: Setting, axis: int, rng: np.random.Generator) -> list[float]:
        """Three constants of a force on the axis (1 sway, 2 yaw)."""

    def draw_constants(self, s: Setting, rng: np.random.Generator) -> list[float]:
        axis = AXES["N" if not s.ship.is_3dof else rng.choice(["Y", "N"], p=[0.3, 0.7])]
        values = self.constants(s, axis, rng)
        return [rng.choice([-1.0, 1.0]), *values]


MOTIONS = ("rudder angle", "yaw rate", "drift")
"""What a diagnosis calls the motions of `motion`."""


def motions(s: Setting) -> list[int]:
    """Motions of the ship that a force may follow."""
    return [0, 1, 2] if s.ship.is_3dof else [0, 1]
