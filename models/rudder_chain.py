"""The rudder chain: from the recorded rudder angle (or command) to the angle that the hull feels.

    recorded -> delay -> rate limit -> stop -> play -> effectiveness (and fault) and offset

This is the order of the parts in a ship: the order reaches the steering gear late, the pump limits how fast the
gear turns, the gear ends at its stops, the linkage behind the gear has play, and what the blade does with the angle
(its effectiveness and its neutral angle) comes last.  A gear at its stop turns back as soon as the order does: it
follows the order within the stops, so these may as well stand before the rate limit.  Play before the limits would be
another mechanism.  Delay, rate limit, stop and play do not depend on time, so the place of the delay is free.

Between samples the recorded angle is linear.  Every part is solved exactly on a linear piece, so that the result at a
given time does not depend on how many points lie between: simulator and filter agree whatever their steps.  The
numbers are those of `instruments.RUDDER`, 0 where a part is ideal.
"""

from __future__ import annotations

import numpy as np
from numba import types

from .compilation import A1, JIT, f8, i8, njit
from .instruments import RUDDER

EFFECTIVENESS, OFFSET, DELAY, PLAY, FAULT, FAULT_TIME, RATE, STOP, REVERSED = range(len(RUDDER))
STATE = 4
"""Numbers that the chain remembers: recorded time reached (s), angle behind the rate limit, angle behind the play
(rad), index of the sample before the recorded time."""
QUIET_TURNS, QUIET_REACH = 11, 16
"""Times that a rudder series' noise is averaged out, over so many samples to either side."""


@njit(f8(f8, f8, f8, f8, f8, f8), **JIT)
def steer(angle, command, dt, lag, rate, limit):
    """Rudder angle one sample later: first-order lag with a rate limit, solved exactly for a held command."""
    command = min(max(command, -limit), limit)
    gap = command - angle
    side = 1.0 if gap > 0.0 else -1.0
    slewing = max(abs(gap) / rate - lag, 0.0)
    if slewing >= dt:
        return angle + side * rate * dt
    if slewing > 0.0:
        angle += side * rate * slewing
    if lag <= 0.0:
        return command
    return command + (angle - command) * np.exp(-(dt - slewing) / lag)


@njit(inline="always")
def _inside(angle, limit):
    """The angle within +- limit; 0 means no limit."""
    return min(max(angle, -limit), limit) if limit > 0.0 else angle


@njit(inline="always")
def _behind_play(played, angle, play):
    """Output of a play of +- play whose input has moved monotonically to `angle`."""
    return min(max(played, angle - play), angle + play)


@njit(inline="always")
def _along_line(start, end, duration, chain, state):
    """Move the limited and the played angle along a linear piece of the delayed angle within the stops: exact."""
    limited, rate = state[1], chain[RATE]
    if rate > 0.0 and duration > 0.0:
        slope, gap = (end - start) / duration, start - limited
        side = 1.0 if gap > 0.0 else -1.0
        closing = side * (side * rate - slope)  # speed at which the gap closes
        meeting = 0.0 if gap == 0.0 else (side * gap / closing if closing > 0.0 else duration)
        if meeting >= duration:
            limited += side * rate * duration
        else:
            met = start + slope * meeting
            state[2] = _behind_play(state[2], met, chain[PLAY])  # the angle may turn here
            left = rate * (duration - meeting)
            limited = min(max(end, met - left), met + left)
    else:
        limited = end
    state[1] = limited
    state[2] = _behind_play(state[2], limited, chain[PLAY])


@njit(inline="always")
def _along_piece(start, end, duration, chain, state):
    """The same along a piece that may go beyond the stops: up to where it comes within them, and from where it leaves
    them on, the angle stays at a stop."""
    first, last = _inside(start, chain[STOP]), _inside(end, chain[STOP])
    if (first == start and last == end) or duration <= 0.0 or start == end:
        _along_line(first, last, duration, chain, state)
        return
    slope = (end - start) / duration
    within = min(max((first - start) / slope, 0.0), duration)
    beyond = min(max((last - start) / slope, within), duration)
    if within > 0.0:
        _along_line(first, first, within, chain, state)
    if beyond > within:
        _along_line(first, last, beyond - within, chain, state)
    if duration > beyond:
        _along_line(last, last, duration - beyond, chain, state)


@njit(inline="always")
def _gain(now, step, first, chain):
    """Effectiveness at the time `now`: a fault sets in within one sampling step around its time."""
    gain = 1.0 + chain[EFFECTIVENESS]
    if chain[FAULT] != 0.0:
        gain += chain[FAULT] * min(max((now - first - chain[FAULT_TIME]) / step + 0.5, 0.0), 1.0)
    return gain


@njit(types.void(A1, A1, A1, A1), **JIT)
def begin(time, series, chain, state):
    """Fill the state (4,) for the start of a series (N,) at times (N,): at rest at the first angle."""
    sign = -1.0 if chain[REVERSED] > 0.0 else 1.0
    state[0], state[3] = time[0] - chain[DELAY], 0.0
    state[1] = state[2] = _inside(sign * series[0], chain[STOP])


@njit(types.void(A1, A1, i8, A1, A1, f8), **JIT)
def advance(time, series, known, chain, state, now):
    """Move the state on to the time `now`; the first `known` samples of the series are given."""
    sign = -1.0 if chain[REVERSED] > 0.0 else 1.0
    until, i = now - chain[DELAY], int(state[3])
    state[0] = max(state[0], min(time[0], until))  # before the record the angle was the first one
    while state[0] < until:
        while i < known - 2 and time[i + 1] <= state[0]:
            i += 1
        if state[0] >= time[known - 1]:  # behind the last sample the angle stays
            _along_piece(sign * series[known - 1], sign * series[known - 1], until - state[0], chain, state)
            state[0] = until
            break
        end, step = min(until, time[i + 1]), time[i + 1] - time[i]
        slope = sign * (series[i + 1] - series[i]) / step
        start = sign * series[i] + slope * (state[0] - time[i])
        last = sign * series[i + 1] if end == time[i + 1] else sign * series[i] + slope * (end - time[i])
        _along_piece(start, last, end - state[0], chain, state)
        state[0] = end
    state[3] = i


@njit(f8(f8, f8, f8, A1, A1), **JIT)
def felt(now, step, first, chain, state):
    """Angle that the hull feels at the time `now` that the state has reached; `first`: time of the first sample."""
    return _gain(now, step, first, chain) * state[2] + chain[OFFSET]


@njit(types.void(A1, A1, A1, i8, A1), **JIT)
def _scaled(time, recorded, chain, parts, out):
    """The chain of a rudder without delay, limits and play."""
    n, sign = recorded.size, -1.0 if chain[REVERSED] > 0.0 else 1.0
    for k in range(n):
        step = time[min(k + 1, n - 1)] - time[min(k, n - 2)]
        rise = recorded[min(k + 1, n - 1)] - recorded[k]
        for j in range(parts if k < n - 1 else 1):
            part = j / parts
            angle = sign * (recorded[k] + part * rise)
            out[k * parts + j] = _gain(time[k] + part * step, step, time[0], chain) * angle + chain[OFFSET]


@njit(types.void(A1, A1, A1, A1, f8, i8, A1), **JIT)
def run_chain(time, recorded, quiet, chain, noise, parts, out):
    """Angles ((N - 1) * parts + 1,) that the hull feels, at `parts` points a sample.

    recorded, quiet : (N,) the series as recorded and freed of its sensor's noise of sd `noise`.  Play counts every
    reversal, that of noise too: it is given the quiet series, and the noise is added behind it, less the more of it
    the play takes up.
    """
    n, state, plain = recorded.size, np.empty(STATE), np.empty(STATE)
    played = chain[PLAY] > 0.0
    if not (played or chain[RATE] > 0.0 or chain[STOP] > 0.0 or chain[DELAY] > 0.0):
        _scaled(time, recorded, chain, parts, out)
        return
    share = np.exp(-chain[PLAY] / noise) if played and noise > 0.0 else 0.0
    exact = np.zeros(chain.size)
    exact[DELAY], exact[REVERSED] = chain[DELAY], chain[REVERSED]
    series = quiet if played else recorded
    begin(time, series, chain, state)
    begin(time, recorded, exact, plain)
    rest = plain.copy()
    begin(time, quiet, exact, rest)
    for i in range(out.size):
        k = min(i // parts, n - 1)
        step = time[min(k + 1, n - 1)] - time[min(k, n - 2)]
        now = time[k] + step * (i - k * parts) / parts
        advance(time, series, n, chain, state, now)
        out[i] = felt(now, step, time[0], chain, state)
        if share > 0.0:
            advance(time, recorded, n, exact, plain, now)
            advance(time, quiet, n, exact, rest, now)
            out[i] += _gain(now, step, time[0], chain) * share * (plain[1] - rest[1])


@njit(types.void(A1, f8, A1), **JIT)
def follow(angle, play, out):
    """Fill `out` with an angle (N,) behind play of +- play, at rest in its middle at first."""
    out[0] = angle[0]
    for k in range(1, angle.size):
        out[k] = _behind_play(out[k - 1], angle[k], play)


@njit(types.void(A1, f8, A1), **JIT)
def quieten(series, sd, out):
    """Fill `out` with a rudder series (N,) freed of its sensor's noise: play counts every reversal, that of noise too.

    Each sample is replaced by the mean of its neighbours of nearly the same angle, several times, until the plateaus of
    the command are flat: the largest noise on them would be taken for play.  Before each time, an isolated outlier
    between four neighbours that agree is replaced by their mean; it has no neighbours of nearly the same angle.
    """
    n = series.size
    before = np.empty(n)
    out[:] = series
    for turn in range(QUIET_TURNS):
        near = 4.0 * sd if turn == 0 else 2.0 * sd
        before[:] = out
        for k in range(2, n - 2):
            a, b, c, d = out[k - 2], out[k - 1], out[k + 1], out[k + 2]
            middle = 0.25 * (a + b + c + d)
            if max(max(a, b), max(c, d)) - min(min(a, b), min(c, d)) < near and abs(out[k] - middle) > 0.75 * near:
                before[k] = middle
        for k in range(n):
            total, count = 0.0, 0
            for j in range(max(0, k - QUIET_REACH), min(n, k + QUIET_REACH + 1)):
                if abs(before[j] - before[k]) < near:
                    total += before[j]
                    count += 1
            out[k] = total / count
