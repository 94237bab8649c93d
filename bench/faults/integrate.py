"""The truth simulator's integrator: RK4 with the rudder moving inside the step (numba).

The rudder gear is solved exactly on a grid of half steps (rate limit, then first-order lag), so that every stage of
RK4 sees the rudder of its own instant; positions and heading are integrated together with the velocities.
"""

from __future__ import annotations

from collections import namedtuple
from math import cos, exp, fabs, sin

import numpy as np

from ...models.compilation import njit
from .equations import JIT, derivative

#: Rudder chain between the recorded angle and the hull; what is not given is sound.
Chain = namedtuple(
    "Chain",
    "rate_limit saturation delay play effectiveness offset fault fault_time",
    defaults=[1e9, 1e9, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
)
#: Closed loop: zigzag (1) or not (0), rudder order to starboard, heading change, execute time, first side.
STATES = 8


@njit(**JIT)
def gear(angle, order, dt, lag, rate):
    """Angle after dt of d' = clip((order - d)/lag, +-rate), exactly."""
    error = order - angle
    knee = rate * lag
    if fabs(error) > knee:
        ramp = min((fabs(error) - knee) / rate, dt)
        angle += ramp * rate * (1.0 if error > 0 else -1.0)
        dt -= ramp
        error = order - angle
    return order - error * exp(-dt / lag)


@njit(**JIT)
def clip(value, limit):
    """value within +-limit."""
    return min(max(value, -limit), limit)


@njit(**JIT)
def at_hull(chain, half, j, recorded, limited, played):
    """Rudder angle at the hull at half step j: fills limited[j], played[j] from recorded[:j + 1]."""
    limited[j] = recorded[j]
    if chain.rate_limit < 1e8 and j > 0:
        limited[j] = limited[j - 1] + clip(recorded[j] - limited[j - 1], chain.rate_limit * half)
    if chain.saturation < 1e8:
        limited[j] = clip(limited[j], chain.saturation)
    place = max(j - chain.delay / half, 0.0)
    k = min(int(place), j)
    late = limited[k] if k == j else limited[k] + (place - k) * (limited[k + 1] - limited[k])
    before = played[j - 1] if j > 0 else late
    played[j] = late
    if chain.play > 0.0:
        played[j] = min(max(before, late - chain.play), late + chain.play)
    gain = 1.0 + chain.effectiveness + (chain.fault if j * half >= chain.fault_time else 0.0)
    return gain * played[j] + chain.offset


@njit(**JIT)
def rk4(kind, c, s, p, extra, functions, t, h, x, d, f, slopes, work, mid):
    """One step in place; d (3,) rudder and f (3, 3) further X, Y, N at its start, middle and end."""
    derivative(kind, c, s, p, extra, functions, t, x, d[0], f[0, 0], f[0, 1], f[0, 2], work, slopes[0])
    for stage in range(1, 4):
        part, at = (0.5 * h, 1) if stage < 3 else (h, 2)
        for i in range(x.size):
            mid[i] = x[i] + part * slopes[stage - 1, i]
        fx, fy, fn = f[at, 0], f[at, 1], f[at, 2]
        derivative(kind, c, s, p, extra, functions, t + part, mid, d[at], fx, fy, fn, work, slopes[stage])
    for i in range(x.size):
        x[i] += h / 6.0 * (slopes[0, i] + 2.0 * (slopes[1, i] + slopes[2, i]) + slopes[3, i])


@njit(**JIT)
def turned(gust, heading, fixed_to_earth):
    """A gust's north and east force in body axes (its moment is the same)."""
    if not fixed_to_earth:
        return gust[0], gust[1], gust[2]
    co, si = cos(heading), sin(heading)
    return gust[0] * co + gust[1] * si, -gust[0] * si + gust[1] * co, gust[2]


@njit(**JIT)
def run(
    kind, c, s, p, extra, functions, chain, x0, h, orders, loop, seen, limits, prescribed, gusts, earth, states, rudder,
    hull,
):  # fmt: skip
    """Integrate one record.

    orders (n,) rudder order of each step; loop (5,) see above; seen (n,) error of the heading that the helmsman sees;
    limits: lag, rate, largest angle; prescribed (2n + 1,) rudder on half steps, or empty; gusts (n + 1, 3) X, Y, N.
    Fills states (n + 1, 8), rudder and hull (2n + 1,): the recorded angle and that at the hull.
    """
    n = states.shape[0] - 1
    x = x0.copy()
    limited, played = np.zeros(2 * n + 1), np.zeros(2 * n + 1)
    slopes, work, mid, f = np.zeros((4, x.size)), np.zeros(5), np.zeros(x.size), np.zeros((3, 3))
    side = loop[4]
    given = prescribed.size > 0
    rudder[0] = prescribed[0] if given else 0.0
    hull[0] = at_hull(chain, 0.5 * h, 0, rudder, limited, played)
    states[0] = x
    for k in range(n):
        order = orders[k]
        if loop[0] == 1.0 and k * h >= loop[3] - 1e-9:
            if side * (x[5] - x0[5] + seen[k]) >= loop[2]:
                side = -side
            order = side * loop[1]
        order = clip(order, limits[2])
        for j in range(2 * k + 1, 2 * k + 3):
            rudder[j] = prescribed[j] if given else gear(rudder[j - 1], order, 0.5 * h, limits[0], limits[1])
            hull[j] = at_hull(chain, 0.5 * h, j, rudder, limited, played)
        for i in range(3):
            at = 0.5 * i
            g = (1.0 - at) * gusts[k] + at * gusts[k + 1]
            f[i, 0], f[i, 1], f[i, 2] = turned(g, x[5] + at * h * x[2], earth)
        rk4(kind, c, s, p, extra, functions, k * h, h, x, hull[2 * k : 2 * k + 3], f, slopes, work, mid)
        states[k + 1] = x
