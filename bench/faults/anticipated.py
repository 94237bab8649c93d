"""Effects outside the taxonomy of kinds that a diagnosis has a family for ("unexplained" is the right verdict).

Codes of `anticipated_force`: memory (a lagged rudder, yaw rate or sway velocity feeds a force), drift (an effect that
grows in time), harmonic (a force that goes with a multiple of the heading), pulse (a tug for a while), periodic (a
force at a fixed frequency).  `sensor_ramp` acts on a channel instead (`sensing`).
"""

from __future__ import annotations

from math import cos

import numpy as np
from numba import njit

MEMORY, DRIFT, HARMONIC, PULSE, PERIODIC = range(5)
AXES = {"Y": 1, "N": 2}
KINDS = ("memory", "drift", "harmonic", "pulse", "periodic", "sensor_ramp")
RAMPED = ("yaw_rate_rad_s", "heading_rad")


@njit(cache=True)
def signal(which, x, d, length, speed):
    """A motion as a number of order one: rudder, yaw rate, sway velocity, or 1."""
    if which == 0:
        return d / 0.1745
    if which == 1:
        return x[2] * length / speed / 0.3
    return x[1] / speed / 0.1 if which == 2 else 1.0


@njit(cache=True)
def anticipated_force(a, t, x, d, length, speed, out):
    """Adds X, Y, N in units of the rudder's force at 10 deg and two hidden rates to out (5,).

    a: code, size, and what the code needs (`draw`): a[2] signal, order or time, a[3] axis, a[4] time or phase.
    """
    code, size, axis = int(a[0]), a[1], int(a[3])
    if code == MEMORY:
        out[axis] += size * x[6]
        out[3] += (signal(int(a[2]), x, d, length, speed) - x[6]) / a[4]
    elif code == DRIFT:
        out[axis] += size * t / a[4] * signal(int(a[2]), x, d, length, speed)
    elif code == HARMONIC:
        out[axis] += size * cos(a[2] * x[5] + a[4])
    elif code == PULSE:
        out[axis] += size if a[2] <= t < a[2] + a[4] else 0.0
    elif code == PERIODIC:
        out[axis] += size * cos(a[2] * t + a[4])


def draw(kind: str, is_3dof: bool, clock: float, duration_s: float, rng: np.random.Generator) -> np.ndarray:
    """Row [code, 1 (size), parameters...] (7,) of a kind with forces; times scaled by the ship's `clock`."""
    code = KINDS.index(kind)
    axis = AXES["N" if not is_3dof else rng.choice(["Y", "N"], p=[0.3, 0.7])]
    signals = [0, 1, 2] if is_3dof else [0, 1]
    if kind == "memory":
        values = [rng.choice(signals), axis, clock * np.exp(rng.uniform(np.log(10.0), np.log(80.0)))]
    elif kind == "drift":
        values = [rng.choice([*signals, 3]), axis, duration_s]
    elif kind == "harmonic":
        values = [rng.choice([2, 3]), axis, rng.uniform(-np.pi, np.pi)]
    elif kind == "pulse":
        values = [rng.uniform(0.2, 0.7) * duration_s, axis, clock * rng.uniform(20.0, 60.0)]
    else:
        values = [rng.uniform(0.12, 0.4) / clock, axis, rng.uniform(-np.pi, np.pi)]
    return np.array([code, rng.choice([-1.0, 1.0]), *values, 0.0, 0.0], float)
