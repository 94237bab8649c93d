"""Effects that no family of any diagnosis was written for: whoever builds a diagnosis does not read this file.

Ids B1, B2, ... name them from outside; a size is scaled like that of any planted effect.  All are forces, as in
`anticipated`: X, Y, N in units of the rudder's force and moment at 10 deg, and two hidden states.
"""

from __future__ import annotations

from math import cos, exp, fabs, sin, tanh

import numpy as np
from numba import njit

COUNT_3DOF = 14
#: ids that a response ship can carry (yaw only, no sway, no speed)
RESPONSE = ("B2", "B3", "B4", "B6", "B9", "B12")
IDS = tuple(f"B{i + 1}" for i in range(COUNT_3DOF))


@njit(cache=True)
def unforeseen_force(a, t, x, d, length, speed, out):
    """Adds X, Y, N and two hidden rates to out (5,); a: code, size, parameters."""
    code, size = int(a[0]), a[1]
    u, v, r = x[0] / speed, x[1] / speed / 0.1, x[2] * length / speed / 0.3
    dd = d / 0.1745
    h1, h2 = x[6], x[7]
    if code == 1:  # a bank to one side: suction and bow cushion that fall off with the distance from it
        near = exp(-fabs(x[4] - a[2] * length) / (a[3] * length))
        out[1] += size * u * u * near
        out[2] -= 0.6 * size * u * u * near
    elif code == 2:  # the rudder stalls above an angle
        over = max(fabs(d) - a[2], 0.0) / 0.1745
        out[2] -= size * over * (1.0 if d * a[3] > 0 else -1.0)
    elif code == 3:  # hysteresis: the flow remembers to which side the ship last turned
        h = tanh(3.0 * r + 2.0 * h1)
        out[2] += size * h1 * (1.0 + 0.5 * fabs(dd))
        out[3] += (h - h1) / a[2]
    elif code == 4:  # yaw damping that acts to one side only
        out[2] -= size * a[3] * (max(a[2] * r, 0.0) * a[2]) * (1.0 + fabs(r))
    elif code == 5:  # sway force and trim moment of a deflected rudder whatever its side
        out[1] += size * fabs(dd) * u
        out[2] += 0.3 * size * fabs(dd) * u
    elif code == 6:  # the rudder moves again with the yaw acceleration of a moment ago (loose quadrant, hidden rate)
        out[2] += size * 2.0 * (r - h1) * fabs(dd)
        out[3] += (r - h1) / a[2]
    elif code == 7:  # surge resistance of a turning ship with deflected rudder
        out[0] -= size * 3.0 * r * r * fabs(dd)
    elif code == 8:  # something caught on one side at a time: drag, and the moment of its lever
        if t > a[2]:
            out[0] -= size * 2.0 * u * u
            out[2] += size * a[3] * 0.5 * u * u
    elif code == 9:  # rudder whose grip depends on how long it has been held over
        out[2] -= size * a[3] * (dd - h1) * fabs(h1)
        out[3] += (dd - h1) / a[2]
    elif code == 10:  # water that sloshes athwartships
        w, force = a[2], v + 2.0 * r
        out[1] += size * 2.0 * h1
        out[2] += size * 0.3 * h1
        out[3] += w * h2
        out[4] += w * (force - h1 - 0.12 * h2)
    elif code == 11:  # a shear line: the stream pushes on one side of a northing only
        side = 0.5 * (1.0 + tanh((x[3] - a[2] * length) / (0.5 * length)))
        out[0] += size * side * cos(a[3] - x[5])
        out[1] += size * 2.0 * side * sin(a[3] - x[5])
    elif code == 12:  # the rudder's grip pulses with a slow cycle that grows with rudder angle
        out[2] += size * dd * fabs(dd) * sin(a[2] * t + a[3])
    elif code == 13:  # squat over a shoal: the damping changes where the ship is, not when
        at = ((x[3] - a[2] * length) ** 2 + (x[4] - a[3] * length) ** 2) / (3.0 * length) ** 2
        out[0] -= size * 2.0 * exp(-at) * u * u
        out[2] -= size * 3.0 * exp(-at) * r
    elif code == 14:  # the propeller race is drawn off by drift: cross term of sway and rudder of one sign
        out[1] += size * max(a[2] * v, 0.0) * dd
        out[2] += 0.5 * size * a[3] * max(a[2] * v, 0.0) * dd


def draw(kind: str, starboard: int, clock: float, duration_s: float, track: tuple, rng: np.random.Generator):
    """Row [code, 1 (size), parameters...] (7,); `track` is (north, east) in lengths half way through a record."""
    side = rng.choice([-1.0, 1.0])
    north, east = track
    values = {
        "B1": [east + rng.uniform(-2.0, 2.0), rng.uniform(2.0, 5.0)],
        "B2": [np.deg2rad(rng.uniform(5.0, 12.0)), starboard],
        "B3": [clock * rng.uniform(15.0, 60.0)],
        "B4": [side, rng.choice([-1.0, 1.0])],
        "B5": [0.0],
        "B6": [clock * rng.uniform(8.0, 25.0)],
        "B7": [0.0],
        "B8": [rng.uniform(0.25, 0.6) * duration_s, side],
        "B9": [clock * rng.uniform(15.0, 60.0), starboard],
        "B10": [rng.uniform(0.15, 0.6) / clock],
        "B11": [north + rng.uniform(-2.0, 2.0), rng.uniform(-np.pi, np.pi)],
        "B12": [rng.uniform(0.03, 0.1) / clock, rng.uniform(-np.pi, np.pi)],
        "B13": [north + rng.uniform(-2.0, 2.0), east + rng.uniform(-2.0, 2.0)],
        "B14": [side, rng.choice([-1.0, 1.0])],
    }[kind]
    signed = 1.0 if kind in ("B7", "B2", "B9") else side
    return np.array([int(kind[1:]), signed, *values, *[0.0] * (5 - len(values))], float)
