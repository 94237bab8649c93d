"""Effects whose force is no term of the equations: each brings its own force function.

A force function is compiled by itself (a numba C function) and handed to the integrator, so that a new kind needs no
edit of the equations.  Its forces are in units of the rudder's sway force and yaw moment at 10 deg, so that a size is
comparable between ships.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import cos, exp, sin
from typing import Any

import numpy as np

from ....models.compilation import njit
from ..regimes import TrueRegime
from ..ships import TrueShip
from ..simulator import CONSTANTS
from .base import ANTICIPATED, REGIME, UNFORESEEN, EffectKind, Setting, any_ship, three_dof

AXES = {"Y": 1, "N": 2}


@njit(cache=True)
def motion(which, x, d, length, speed):
    """A motion as a number of order one: rudder (0), yaw rate (1), sway velocity (2), or 1 (3)."""
    if which == 0:
        return d / 0.1745
    if which == 1:
        return x[2] * length / speed / 0.3
    return x[1] / speed / 0.1 if which == 2 else 1.0


def force_kind(
    force: Callable[..., None], constants: Callable[[Setting, np.random.Generator], list[float]], **row: Any
) -> EffectKind:
    """A kind with a force function of its own.

    force(a, t, x, d, length, speed, out) adds X, Y, N and the rates of two hidden states to out (5,); a (6,): size and
    constants; t s; x (8,): u, v, r, north, east, heading and the two hidden states; d: rudder at the hull, rad; length
    m and speed m/s of the ship.  It is compiled by numba.  constants : draws the sign of the size, then up to five
    constants.
    """

    def draw(s: Setting, rng: np.random.Generator) -> dict[str, Any]:
        values = [float(value) for value in constants(s, rng)]
        return {"constants": tuple(values + [0.0] * (CONSTANTS - len(values))), "size": 0.005}

    units = {"size": "rudder force at 10 deg"}
    return EffectKind(units=units, sized=("size",), whole=("constants",), force=force, draw=draw, **row)


def force_vector(p: Mapping[str, Any]) -> np.ndarray:
    """What a force function gets as `a` (6,)."""
    a = np.array(p["constants"])
    a[0] *= p["size"]
    return a


MOTIONS = ("rudder angle", "yaw rate", "drift")
"""What a diagnosis calls the motions of `motion`."""


def motions(s: Setting) -> list[int]:
    """Motions of the ship that a force may follow."""
    return [0, 1, 2] if s.ship.is_3dof else [0, 1]


def anticipated(
    constants: Callable[[Setting, int, np.random.Generator], list[float]],
    carried_by: Callable[[TrueShip], bool] = any_ship,
    **row: Any,
) -> EffectKind:
    """An unknown force of a kind that a diagnosis may have a test for: on sway or on yaw.

    constants : draws three constants of a force on an axis (1 sway, 2 yaw).
    """

    def signed(s: Setting, rng: np.random.Generator) -> list[float]:
        axis = AXES["N" if not s.ship.is_3dof else rng.choice(["Y", "N"], p=[0.3, 0.7])]
        values = constants(s, axis, rng)
        return [rng.choice([-1.0, 1.0]), *values]

    return force_kind(constants=signed, group=ANTICIPATED, carried_by=carried_by, **row)


@dataclass(frozen=True, eq=False)
class Chances:
    """Random numbers that every unforeseen kind draws, whichever of them it uses.

    side and other_side are -1 or 1; north, east: a place that the ship passes, in lengths; uniform (14,) in 0 .. 1.
    Kinds use different ones, so that the same seed gives each kind a different case.
    """

    side: float
    other_side: tuple[float, float]
    north: float
    east: float
    uniform: np.ndarray

    @classmethod
    def draw(cls, s: Setting, rng: np.random.Generator) -> Chances:
        """Draw them all."""
        north, east = s.place()
        side = rng.choice([-1.0, 1.0])
        first = rng.random(4)
        one = rng.choice([-1.0, 1.0])
        rest = rng.random(10)
        return cls(side, (one, rng.choice([-1.0, 1.0])), north, east, np.concatenate([first, rest]))

    def between(self, i: int, low: float, high: float) -> float:
        """Number i, uniform in low .. high."""
        return low + (high - low) * float(self.uniform[i])


def unforeseen(constants: Callable[[Setting, Chances], list[float]], signed: bool = True, **row: Any) -> EffectKind:
    """An unknown force that no test of any diagnosis was written for; `signed` where its size may also be negative.

    constants : up to five constants.
    """

    def drawn(s: Setting, rng: np.random.Generator) -> list[float]:
        chances = Chances.draw(s, rng)
        return [chances.side if signed else 1.0, *constants(s, chances)]

    return force_kind(constants=drawn, group=UNFORESEEN, **row)


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
    anticipated(
        id="memory", rank=34, force=memory,
        constants=lambda s, axis, rng: [
            rng.choice(motions(s)), axis, s.ship.clock * np.exp(rng.uniform(np.log(10.0), np.log(80.0))),
        ],
        variables=lambda p: frozenset({f"past of the {MOTIONS[int(p['constants'][1])]}"}),
    ),
    anticipated(
        id="drift", rank=35, force=drift, variables=_in_time,
        constants=lambda s, axis, rng: [rng.choice([*motions(s), 3]), axis, s.duration_s],
    ),
    anticipated(
        id="harmonic", rank=36, force=harmonic, variables=lambda p: frozenset({"heading"}),
        constants=lambda s, axis, rng: [rng.choice([2, 3]), axis, rng.uniform(-np.pi, np.pi)],
    ),
    anticipated(
        id="pulse", rank=37, force=pulse, variables=_in_time,
        constants=lambda s, axis, rng: [
            rng.uniform(0.2, 0.7) * s.duration_s, axis, s.ship.clock * rng.uniform(20.0, 60.0),
        ],
    ),
    anticipated(
        id="periodic", rank=38, force=periodic, variables=_in_time,
        constants=lambda s, axis, rng: [rng.uniform(0.12, 0.4) / s.ship.clock, axis, rng.uniform(-np.pi, np.pi)],
    ),
    anticipated(
        id="step", rank=65, force=step, variables=_in_time,
        constants=lambda s, axis, rng: [rng.uniform(0.3, 0.7) * s.duration_s, axis, 0.0],
    ),
    anticipated(
        id="lee", rank=66, force=lee, carried_by=three_dof,
        variables=lambda p: frozenset({"place to the north", "heading"}),
        constants=lambda s, axis, rng: [
            -rng.uniform(0.05, 0.2) * s.ship.speed_m_s * s.duration_s, axis, rng.uniform(-np.pi, np.pi),
        ],
    ),
    anticipated(
        id="bank", rank=67, force=bank, carried_by=three_dof, variables=lambda p: frozenset({"place to the east"}),
        constants=lambda s, axis, rng: [rng.uniform(1.0, 4.0), axis, 0.0],
    ),
    force_kind(
        id="propeller_side_force", group=REGIME, rank=61, carried_by=any_ship, force=propeller_push,
        right=("asymmetry", "neutral_rudder_angle", "rudder_offset", "constant_force"),
        constants=lambda s, rng: [float(rng.choice([-1.0, 1.0])), float(rng.choice([-1.0, 1.0]))],
        regime=lambda p, ship: TrueRegime("side", "port" if p["constants"][1] < 0.0 else "starboard"),
    ),
    force_kind(
        id="resistance_above_speed", group=REGIME, rank=64, force=resistance,
        right=("resistance", "constant_force", "propeller_thrust"),
        constants=lambda s, rng: [1.0, float(rng.uniform(0.85, 0.93))],
        regime=lambda p, ship: TrueRegime("speed", "above", p["constants"][1] * ship.speed_m_s),
    ),
)  # fmt: skip
