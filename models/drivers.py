"""Shared numerical drivers: each is compiled once and takes a model's generated function as a pointer.

Arrays are C-contiguous float64.  N+1 samples, n states, nu inputs, m sensitivity columns.
"""

from __future__ import annotations

import numpy as np
from numba import types

from .compilation import A1, A2, A3, BORROWED, I1, JIT, b1, f8, i8, njit
from .rudder_chain import STATE, advance, begin, felt, steer

RHS = types.FunctionType(types.void(A1, A1, A1, A1))
TANGENT = types.FunctionType(types.void(A1, A1, A1, A1, i8, A1, A1, A1, A1))
REGRESS = types.FunctionType(types.void(A1, A1, A1, A1, A1, A1))
SERIES, _, HEADING = range(3)
FADED = 1e-150
"""Sensitivity below which it is set to zero.  That to an initial state decays with the time, and arithmetic with the
smallest numbers that a processor knows takes several times as long."""


@njit(types.void(RHS, A1, A2, A1, f8, A2), **JIT)
def euler(rhs, x0, inputs, theta, dt, states):
    """Explicit Euler with the input held over the sample; states (N+1, n) is filled."""
    x, rate = x0.copy(), np.empty(x0.size)
    states[0] = x
    for k in range(inputs.shape[0] - 1):
        rhs(x, inputs[k], theta, rate)
        for i in range(x.size):
            x[i] += dt * rate[i]
        states[k + 1] = x


@njit(types.void(RHS, A1, A1, A1, A1, f8, i8, A1), **JIT, **BORROWED)
def rk4_sample(rhs, x, u0, u1, theta, dt, substeps, work):
    """Advance x (n,) in place over one sample, the input linear from u0 to u1; work has 3 n + nu elements."""
    n, nu, h = x.size, u0.size, dt / substeps
    rate, total, probe, u = work[:n], work[n : 2 * n], work[2 * n : 3 * n], work[3 * n : 3 * n + nu]
    for s in range(substeps):
        for stage in range(4):
            moved = 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)
            part = (s + moved) / substeps
            for i in range(nu):
                u[i] = u0[i] + part * (u1[i] - u0[i])
            for i in range(n):
                probe[i] = x[i] if stage == 0 else x[i] + moved * h * rate[i]
            rhs(probe, u, theta, rate)
            weight = h / 6.0 if (stage == 0 or stage == 3) else h / 3.0
            for i in range(n):
                total[i] = x[i] + weight * rate[i] if stage == 0 else total[i] + weight * rate[i]
        for i in range(n):
            x[i] = total[i]


@njit(inline="always")
def share_inside(gate, rudder, u, v, r, time):
    """Smooth indicator of a regime: see `regimes.Regime.inside`.

    gate = place of the variable in `regimes.VARIABLES`, sign, threshold, width.
    """
    kind = gate[0]
    if kind == 0.0:
        value = abs(rudder)
    elif kind == 1.0:
        value = abs(r)
    elif kind == 2.0:
        value = abs(np.arctan2(v, u))
    elif kind == 3.0:
        value = np.sqrt(u**2 + v**2)
    else:
        value = r if kind == 4.0 else time
    z = gate[1] * (value - gate[2]) / gate[3]
    return 0.5 * (1.0 + z / np.sqrt(1.0 + z * z))


@njit(types.void(RHS, A2, A1, f8, i8, A1, A2), **JIT, **BORROWED)
def _row_by_row(rhs, inputs, theta, dt, substeps, work, ahead):
    """Advance every row of ahead (N, n) by one sample."""
    for k in range(ahead.shape[0]):
        rk4_sample(rhs, ahead[k], inputs[k], inputs[k + 1], theta, dt, substeps, work)


@njit(types.void(RHS, A2, A2, A1, f8, i8, A2), **JIT)
def one_step(rhs, states, inputs, theta, dt, substeps, ahead):
    """ahead[k] (N, n) = the state one sample after states[k], from each row on its own."""
    ahead[:] = states
    _row_by_row(rhs, inputs, theta, dt, substeps, np.empty(3 * states.shape[1] + inputs.shape[1]), ahead)


@njit(types.void(A3, A3, I1, A2, A3), **JIT)
def responses(by_state, by_input, place, inputs, states):
    """states (N+1, n, q) = small changes by q small inputs (N+1, q), linear between samples, from none on.

    by_state (N, n, n), by_input (N, n, m) : slopes of the state a sample ahead;  place (q,) : of each among the m.
    """
    states[0] = 0.0
    for k in range(by_state.shape[0]):
        for i in range(by_state.shape[1]):
            for j in range(place.size):
                states[k + 1, i, j] = by_input[k, i, place[j]] * 0.5 * (inputs[k, j] + inputs[k + 1, j])
            for other in range(by_state.shape[2]):
                slope = by_state[k, i, other]
                for j in range(place.size):
                    states[k + 1, i, j] += slope * states[k, other, j]


@njit(types.void(TANGENT, A1, A1, A1, A1, A1, f8, i8, b1, I1, I1, A1), **JIT, **BORROWED)
def tangent_sample(tangent, x, columns, u0, u1, theta, dt, substeps, hold, source, target, work):
    """Advance x (n,) and its sensitivity columns (n*m,) in place over one sample (RK4 on both).

    `source`, `target` say which sparse values of df/dc enter which element of `columns`.
    `work` has 4 n + 3 n m + nu (1 + n) + len(Jt) elements.
    """
    n, size, nu = x.size, columns.size, u0.size
    m, h = size // n, dt / substeps
    rate, probe, total = work[:n], work[n : 2 * n], work[2 * n : 3 * n]
    u = work[3 * n : 3 * n + nu]
    at = 3 * n + nu
    slope, moved, summed = work[at : at + size], work[at + size : at + 2 * size], work[at + 2 * size : at + 3 * size]
    at += 3 * size
    by_input, by_coefficient = work[at : at + n * nu], work[at + n * nu :]
    for s in range(substeps):
        for i in range(size):
            moved[i] = columns[i]
        for i in range(n):
            probe[i] = x[i]
        for stage in range(4):
            part = 0.0 if hold else (s + (0.0 if stage == 0 else (1.0 if stage == 3 else 0.5))) / substeps
            for i in range(nu):
                u[i] = u0[i] + part * (u1[i] - u0[i])
            tangent(probe, u, theta, moved, m, rate, slope, by_input, by_coefficient)
            for k in range(source.size):
                slope[target[k]] += by_coefficient[source[k]]
            weight = h / 6.0 if (stage == 0 or stage == 3) else h / 3.0
            ahead = h if stage == 2 else 0.5 * h
            if stage == 0:
                for i in range(n):
                    total[i] = x[i] + weight * rate[i]
                    probe[i] = x[i] + ahead * rate[i]
                for i in range(size):
                    summed[i] = columns[i] + weight * slope[i]
                    moved[i] = columns[i] + ahead * slope[i]
            elif stage < 3:
                for i in range(n):
                    total[i] += weight * rate[i]
                    probe[i] = x[i] + ahead * rate[i]
                for i in range(size):
                    summed[i] += weight * slope[i]
                    moved[i] = columns[i] + ahead * slope[i]
            else:
                for i in range(n):
                    x[i] = total[i] + weight * rate[i]
                for i in range(size):
                    columns[i] = summed[i] + weight * slope[i]


@njit(types.void(TANGENT, A1, A2, A1, f8, i8, b1, I1, I1, i8, A1, A2, A2), **JIT)
def sensitivities(tangent, x0, inputs, theta, dt, substeps, hold, source, target, sparse, start, states, columns):
    """RK4 of the states and of m sensitivity columns; states (N+1, n) and columns (N+1, n*m) are filled.

    Sensitivities smaller than FADED become zero.
    """
    x, s = x0.copy(), start.copy()
    work = np.empty(4 * x.size + 3 * s.size + inputs.shape[1] * (1 + x.size) + sparse)
    states[0] = x
    columns[0] = s
    for k in range(inputs.shape[0] - 1):
        tangent_sample(tangent, x, s, inputs[k], inputs[k + 1], theta, dt, substeps, hold, source, target, work)
        for i in range(s.size):
            s[i] = 0.0 if abs(s[i]) < FADED else s[i]
        states[k + 1] = x
        columns[k + 1] = s


@njit(types.void(REGRESS, A2, A2, A2, A1, A2, A2), **JIT, **BORROWED)
def regressors(regress, states, accelerations, inputs, theta, left, right):
    """left (N, k) and right (N, k*p) of the regression, row by row."""
    for i in range(states.shape[0]):
        regress(states[i], accelerations[i], inputs[i], theta, left[i], right[i])


@njit(inline="always")
def helm(kind, due, reference, start, heading, yaw_rate, amplitude, check, kp, kd, command, side, running):
    """The order at a sample, the side of a zigzag's next order, and whether the zigzag has begun.

    kind : SERIES (`reference` is the order), HEADING (it is the heading to follow), else a zigzag, which begins at the
        first sample that is `due` and reverses where the heading is `check` off the one at the start.
    """
    if kind == SERIES:
        command = reference
    elif kind == HEADING:
        command = kp * (reference - heading) - kd * yaw_rate
    elif not running:
        running = due
        command = side * amplitude if running else 0.0
    elif side * (heading - start) >= check:
        side = -side
        command = side * amplitude
    return command, side, running


@njit(types.void(RHS, A1, A2, A1, f8, i8, b1, i8, A1, A1, i8, i8, A1, A2, A1, A1), **JIT)
def closed_loop(
    rhs, x0, inputs, theta, dt, substeps, explicit, kind, reference, setting, i_psi, i_r, linkage, states, order, rudder
):  # fmt: skip
    """Hull, linkage, rudder gear and helmsman together; states, order (command), rudder (recorded) and inputs[:, 0]
    (the angle that the hull feels) are filled.

    setting = execute time, rudder and heading angle of the zigzag, first side, lag, rate, limit, kp, kd,
    rudder angle at the start.  Commands change at samples; the rudder is linear between them.
    """
    time = dt * np.arange(states.shape[0])
    chain = np.empty(STATE)
    execute, amplitude, check, side = setting[0], setting[1], setting[2], setting[3]
    lag, rate, limit, kp, kd = setting[4], setting[5], setting[6], setting[7], setting[8]
    x, n = x0.copy(), x0.size
    work = np.empty(3 * n + inputs.shape[1])
    start = x[i_psi]
    states[0] = x
    rudder[0] = setting[9]
    ideal = not np.any(linkage != 0.0)
    before, after = np.empty(inputs.shape[1]), np.empty(inputs.shape[1])
    begin(time, rudder, linkage, chain)
    inputs[0, 0] = felt(time[0], dt, time[0], linkage, chain)
    command, running = 0.0, False
    for k in range(states.shape[0]):
        due = k * dt >= execute - 1e-9 * dt
        command, side, running = helm(
            kind, due, reference[k], start, x[i_psi], x[i_r], amplitude, check, kp, kd, command, side, running
        )
        order[k] = min(max(command, -limit), limit)
        if k == states.shape[0] - 1:
            break
        rudder[k + 1] = steer(rudder[k], command, dt, lag, rate, limit)
        if explicit:
            rhs(x, inputs[k], theta, work)
            for i in range(n):
                x[i] += dt * work[i]
            advance(time, rudder, k + 2, linkage, chain, time[k + 1])
            inputs[k + 1, 0] = felt(time[k + 1], dt, time[0], linkage, chain)
        elif ideal:
            inputs[k + 1, 0] = rudder[k + 1]
            rk4_sample(rhs, x, inputs[k], inputs[k + 1], theta, dt, substeps, work)
        else:  # the chain may turn, stop or start between the samples
            before[:] = inputs[k]
            for s in range(1, substeps + 1):
                now = time[k] + dt * s / substeps
                for i in range(1, before.size):
                    after[i] = inputs[k, i] + (inputs[k + 1, i] - inputs[k, i]) * s / substeps
                advance(time, rudder, k + 2, linkage, chain, now)
                after[0] = felt(now, dt, time[0], linkage, chain)
                rk4_sample(rhs, x, before, after, theta, dt / substeps, 1, work)
                before[:] = after
            inputs[k + 1, 0] = before[0]
        states[k + 1] = x
