"""Forces that no test of any diagnosis was written for: whoever builds a diagnosis does not read this file.

Their ids B1, B2, ... say nothing.
"""

from __future__ import annotations

from math import cos, exp, fabs, sin, tanh

import numpy as np

from .base import any_ship
from .forces import unforeseen


def b1(a, t, x, d, length, speed, out):
    """A bank to one side: suction and bow cushion that decrease with the distance from it."""
    u = x[0] / speed
    near = exp(-fabs(x[4] - a[1] * length) / (a[2] * length))
    out[1] += a[0] * u * u * near
    out[2] -= 0.6 * a[0] * u * u * near


def b2(a, t, x, d, length, speed, out):
    """The rudder stalls above an angle."""
    over = max(fabs(d) - a[1], 0.0) / 0.1745
    out[2] -= a[0] * over * (1.0 if d * a[2] > 0 else -1.0)


def b3(a, t, x, d, length, speed, out):
    """Hysteresis: the flow depends on the side to which the ship last turned."""
    r = x[2] * length / speed / 0.3
    dd = d / 0.1745
    h = tanh(3.0 * r + 2.0 * x[6])
    out[2] += a[0] * x[6] * (1.0 + 0.5 * fabs(dd))
    out[3] += (h - x[6]) / a[1]


def b4(a, t, x, d, length, speed, out):
    """Yaw damping that acts to one side only."""
    r = x[2] * length / speed / 0.3
    out[2] -= a[0] * a[2] * (max(a[1] * r, 0.0) * a[1]) * (1.0 + fabs(r))


def b5(a, t, x, d, length, speed, out):
    """Sway force and yaw moment of a deflected rudder, the same to both sides."""
    u = x[0] / speed
    dd = d / 0.1745
    out[1] += a[0] * fabs(dd) * u
    out[2] += 0.3 * a[0] * fabs(dd) * u


def b6(a, t, x, d, length, speed, out):
    """The rudder moves again with the yaw acceleration of a moment ago: a loose quadrant."""
    r = x[2] * length / speed / 0.3
    dd = d / 0.1745
    out[2] += a[0] * 2.0 * (r - x[6]) * fabs(dd)
    out[3] += (r - x[6]) / a[1]


def b7(a, t, x, d, length, speed, out):
    """Further resistance of a turning ship with deflected rudder."""
    r = x[2] * length / speed / 0.3
    dd = d / 0.1745
    out[0] -= a[0] * 3.0 * r * r * fabs(dd)


def b8(a, t, x, d, length, speed, out):
    """From a time on the ship tows something on one side: drag, and the moment of its lever."""
    u = x[0] / speed
    if t > a[1]:
        out[0] -= a[0] * 2.0 * u * u
        out[2] += a[0] * a[2] * 0.5 * u * u


def b9(a, t, x, d, length, speed, out):
    """The rudder's effect depends on how long it has been held over."""
    dd = d / 0.1745
    out[2] -= a[0] * a[2] * (dd - x[6]) * fabs(x[6])
    out[3] += (dd - x[6]) / a[1]


def b10(a, t, x, d, length, speed, out):
    """Water that sloshes athwartships."""
    v, r = x[1] / speed / 0.1, x[2] * length / speed / 0.3
    w, force = a[1], v + 2.0 * r
    out[1] += a[0] * 2.0 * x[6]
    out[2] += a[0] * 0.3 * x[6]
    out[3] += w * x[7]
    out[4] += w * (force - x[6] - 0.12 * x[7])


def b11(a, t, x, d, length, speed, out):
    """A shear line: the stream pushes only north of a latitude."""
    side = 0.5 * (1.0 + tanh((x[3] - a[1] * length) / (0.5 * length)))
    out[0] += a[0] * side * cos(a[2] - x[5])
    out[1] += a[0] * 2.0 * side * sin(a[2] - x[5])


def b12(a, t, x, d, length, speed, out):
    """The rudder's effect varies in a slow cycle, the more the larger its angle."""
    dd = d / 0.1745
    out[2] += a[0] * dd * fabs(dd) * sin(a[1] * t + a[2])


def b13(a, t, x, d, length, speed, out):
    """Squat over a shoal: resistance and damping change with the place, not with time."""
    u, r = x[0] / speed, x[2] * length / speed / 0.3
    at = ((x[3] - a[1] * length) ** 2 + (x[4] - a[2] * length) ** 2) / (3.0 * length) ** 2
    out[0] -= a[0] * 2.0 * exp(-at) * u * u
    out[2] -= a[0] * 3.0 * exp(-at) * r


def b14(a, t, x, d, length, speed, out):
    """Drift deflects the propeller race: a cross term of sway and rudder to one side."""
    v = x[1] / speed / 0.1
    dd = d / 0.1745
    out[1] += a[0] * max(a[1] * v, 0.0) * dd
    out[2] += 0.5 * a[0] * a[2] * max(a[1] * v, 0.0) * dd


ROWS = (
    unforeseen(
        id="B1", rank=40, force=b1,
        constants=lambda s, c: [c.east + c.between(0, -2.0, 2.0), c.between(1, 2.0, 5.0)],
    ),
    unforeseen(
        id="B2", rank=41, force=b2, signed=False, carried_by=any_ship,
        constants=lambda s, c: [np.deg2rad(c.between(2, 5.0, 12.0)), s.ship.starboard],
    ),
    unforeseen(
        id="B3", rank=42, force=b3, carried_by=any_ship,
        constants=lambda s, c: [s.ship.clock * c.between(3, 15.0, 60.0)],
    ),
    unforeseen(id="B4", rank=43, force=b4, carried_by=any_ship, constants=lambda s, c: [c.side, c.other_side[0]]),
    unforeseen(id="B5", rank=44, force=b5, constants=lambda s, c: [0.0]),
    unforeseen(
        id="B6", rank=45, force=b6, carried_by=any_ship,
        constants=lambda s, c: [s.ship.clock * c.between(4, 8.0, 25.0)],
    ),
    unforeseen(id="B7", rank=46, force=b7, signed=False, constants=lambda s, c: [0.0]),
    unforeseen(id="B8", rank=47, force=b8, constants=lambda s, c: [c.between(5, 0.25, 0.6) * s.duration_s, c.side]),
    unforeseen(
        id="B9", rank=48, force=b9, signed=False, carried_by=any_ship,
        constants=lambda s, c: [s.ship.clock * c.between(6, 15.0, 60.0), s.ship.starboard],
    ),
    unforeseen(id="B10", rank=49, force=b10, constants=lambda s, c: [c.between(7, 0.15, 0.6) / s.ship.clock]),
    unforeseen(
        id="B11", rank=50, force=b11,
        constants=lambda s, c: [c.north + c.between(8, -2.0, 2.0), c.between(9, -np.pi, np.pi)],
    ),
    unforeseen(
        id="B12", rank=51, force=b12, carried_by=any_ship,
        constants=lambda s, c: [c.between(10, 0.03, 0.1) / s.ship.clock, c.between(11, -np.pi, np.pi)],
    ),
    unforeseen(
        id="B13", rank=52, force=b13,
        constants=lambda s, c: [c.north + c.between(12, -2.0, 2.0), c.east + c.between(13, -2.0, 2.0)],
    ),
    unforeseen(id="B14", rank=53, force=b14, constants=lambda s, c: [c.side, c.other_side[1]]),
)  # fmt: skip
