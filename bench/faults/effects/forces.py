"""Effects whose force is no term of the equations: each brings its own force function.

A force function is compiled by itself (a numba C function) and handed to the integrator, so that a new kind needs no
edit of the equations.  Its forces are in units of the rudder's sway force and yaw moment at 10 deg, so that a size is
comparable between ships.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import cos, exp, sin
from typing import Any, ClassVar

import numpy as np

from ....models.compilation import njit
from ..regimes import TrueRegime
from ..simulator import CONSTANTS
from .base import ANTICIPATED, REGIME, EffectKind, RegimeKind, Setting

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
    def force(a, t, x, d, length, speed, out):
        """Add X, Y, N and the rates of two hidden states to out (5,).

        a (6,): size and constants; t s; x (8,): u, v, r, north, east, heading and the two hidden states; d: rudder at
        the hull, rad; length m and speed m/s of the ship.  Compiled by numba.
        """
        raise NotImplementedError

    def draw_constants(self, s: Setting, rng: np.random.Generator) -> list[float]:
        """Sign of the size, then up to five constants."""
        raise NotImplementedError(f"{self.id} has no constants")

    def draw(self, s: Setting, rng: np.random.Generator) -> dict[str, Any]:
        values = [float(value) for value in self.draw_constants(s, rng)]
        return {"constants": tuple(values + [0.0] * (CONSTANTS - len(values))), "size": 0.005}

    def vector(self, p: Mapping[str, Any]) -> np.ndarray:
        """What the force function gets as `a` (6,)."""
        a = np.array(p["constants"])
        a[0] *= p["size"]
        return a


MOTIONS = ("rudder angle", "yaw rate", "drift")
"""What a diagnosis calls the motions of `motion`."""


def motions(s: Setting) -> list[int]:
    """Motions of the ship that a force may follow."""
    return [0, 1, 2] if s.ship.is_3dof else [0, 1]


class AnticipatedForce(ForceKind):
    """An unknown force of a kind that a diagnosis may have a test for: on sway or on yaw.

    A row has `force`, `variables` and `constants(s, axis, rng)`, which gives three constants of a force on the axis (1
    sway, 2 yaw).
    """

    group = ANTICIPATED
    response = True
    constants: Callable[[Setting, int, np.random.Generator], list[float]]

    def draw_constants(self, s: Setting, rng: np.random.Generator) -> list[float]:
        axis = AXES["N" if not s.ship.is_3dof else rng.choice(["Y", "N"], p=[0.3, 0.7])]
        values = self.constants(s, axis, rng)
        return [rng.choice([-1.0, 1.0]), *values]


def memory(a, t, x, d, length, speed, out):
    """Follows a motion of the ship with a time lag."""
    out[int(a[2])] += a[0] * x[6]
    out[3] += (motion(int(a[1]), x, d, length, speed) - x[6]) / a[3]


def drift(a, t, x, d, length, speed, out):
    """Follows a motion of the ship, or is constant, and grows in time."""
    out[int(a[2])] += a[0] * t / a[3] * motion(int(a[1]), x, d, length, speed)


def harmonic(a, t, x, d, length, speed, out):
    """Follows two or three times the heading."""
    out[int(a[2])] += a[0] * cos(a[1] * x[5] + a[3])


def pulse(a, t, x, d, length, speed, out):
    """Constant for a part of the record, such as a tug's."""
    out[int(a[2])] += a[0] if a[1] <= t < a[1] + a[3] else 0.0


def periodic(a, t, x, d, length, speed, out):
    """At a fixed frequency."""
    out[int(a[2])] += a[0] * cos(a[1] * t + a[3])


def step(a, t, x, d, length, speed, out):
    """Begins at a time of the record, and stays."""
    out[int(a[2])] += a[0] if t >= a[1] else 0.0


def lee(a, t, x, d, length, speed, out):
    """A wind, whose force goes with the heading, until the ship comes into the lee of land south of the start."""
    if x[3] > a[1]:
        out[int(a[2])] += a[0] * sin(x[5] - a[3])


def bank(a, t, x, d, length, speed, out):
    """Acts along a bank to the east of the start, and dies away within ship lengths to the west of it."""
    out[int(a[2])] += a[0] * exp(min(x[4] / length, 0.0) / a[1])


def _in_time(p: Mapping[str, Any]) -> frozenset[str]:
    return frozenset({"time"})


class ForceRegime(ForceKind, RegimeKind):
    """A force that acts in a part of the run only."""

    group = REGIME


def propeller_push(a, t, x, d, length, speed, out):
    """Pushes the stern sideways while the ship turns to one side (a[1]: -1 port, 1 starboard)."""
    if a[1] * x[2] > 0.0:
        out[1] += a[0]
        out[2] -= a[0]


def resistance(a, t, x, d, length, speed, out):
    """Resists more above a speed (a[1]: speed over the ship's own)."""
    if x[0] * x[0] + x[1] * x[1] > (a[1] * speed) ** 2:
        out[0] -= a[0]


ROWS = (
    AnticipatedForce(
        id="memory", rank=34, force=memory,
        constants=lambda s, axis, rng: [
            rng.choice(motions(s)), axis, s.ship.clock * np.exp(rng.uniform(np.log(10.0), np.log(80.0))),
        ],
        variables=lambda p: frozenset({f"past of the {MOTIONS[int(p['constants'][1])]}"}),
    ),
    AnticipatedForce(
        id="drift", rank=35, force=drift, variables=_in_time,
        constants=lambda s, axis, rng: [rng.choice([*motions(s), 3]), axis, s.duration_s],
    ),
    AnticipatedForce(
        id="harmonic", rank=36, force=harmonic, variables=lambda p: frozenset({"heading"}),
        constants=lambda s, axis, rng: [rng.choice([2, 3]), axis, rng.uniform(-np.pi, np.pi)],
    ),
    AnticipatedForce(
        id="pulse", rank=37, force=pulse, variables=_in_time,
        constants=lambda s, axis, rng: [
            rng.uniform(0.2, 0.7) * s.duration_s, axis, s.ship.clock * rng.uniform(20.0, 60.0),
        ],
    ),
    AnticipatedForce(
        id="periodic", rank=38, force=periodic, variables=_in_time,
        constants=lambda s, axis, rng: [rng.uniform(0.12, 0.4) / s.ship.clock, axis, rng.uniform(-np.pi, np.pi)],
    ),
    AnticipatedForce(
        id="step", rank=65, force=step, variables=_in_time,
        constants=lambda s, axis, rng: [rng.uniform(0.3, 0.7) * s.duration_s, axis, 0.0],
    ),
    AnticipatedForce(
        id="lee", rank=66, force=lee, response=False, variables=lambda p: frozenset({"place to the north", "heading"}),
        constants=lambda s, axis, rng: [
            -rng.uniform(0.05, 0.2) * s.ship.speed_m_s * s.duration_s, axis, rng.uniform(-np.pi, np.pi),
        ],
    ),
    AnticipatedForce(
        id="bank", rank=67, force=bank, response=False, variables=lambda p: frozenset({"place to the east"}),
        constants=lambda s, axis, rng: [rng.uniform(1.0, 4.0), axis, 0.0],
    ),
    ForceRegime(
        id="propeller_side_force", rank=61, response=True, force=propeller_push,
        right=("asymmetry", "neutral_rudder_angle", "rudder_offset", "constant_force"),
        draw_constants=lambda s, rng: [float(rng.choice([-1.0, 1.0])), float(rng.choice([-1.0, 1.0]))],
        regime=lambda p, ship: TrueRegime("side", "port" if p["constants"][1] < 0.0 else "starboard"),
    ),
    ForceRegime(
        id="resistance_above_speed", rank=64, force=resistance,
        right=("resistance", "constant_force", "propeller_thrust"),
        draw_constants=lambda s, rng: [1.0, float(rng.uniform(0.85, 0.93))],
        regime=lambda p, ship: TrueRegime("speed", "above", p["constants"][1] * ship.speed_m_s),
    ),
)  # fmt: skip
