"""Numerical drivers for blocks of W runs at once, held as structure of arrays: element `index * W + lane`.

Each takes a model's `rhs_lanes` as a pointer.  Flat arrays let the compiler work on several runs in one instruction.
N+1 samples, n states, nu inputs; `numbers` is what the model's `prepare_lanes` makes of its parameters.
"""

from __future__ import annotations

import numpy as np
from numba import types

from .compilation import A1, A2, A3, BORROWED, I1, JIT, b1, f8, i8, njit
from .drivers import RHS, helm, share_inside
from .rudder_chain import steer


@njit(inline="always")
def _between(u0, u1, part, u):
    for i in range(u.size):
        u[i] = u0[i] + part * (u1[i] - u0[i])


@njit(inline="always")
def _ahead(x, h, rate, probe):
    for i in range(x.size):
        probe[i] = x[i] + h * rate[i]


@njit(types.void(RHS, A1, A1, A1, A1, f8, i8, A1), **JIT, **BORROWED)
def rk4_sample(rhs_lanes, x, u0, u1, numbers, dt, substeps, work):
    """Advance x (n*W,) in place over one sample, the inputs (nu*W,) linear from u0 to u1; work has 5 n*W + nu*W
    elements."""
    n, nu, h = x.size, u0.size, dt / substeps
    first, second, third, last = work[:n], work[n : 2 * n], work[2 * n : 3 * n], work[3 * n : 4 * n]
    probe, u = work[4 * n : 5 * n], work[5 * n : 5 * n + nu]
    for i in range(nu):
        u[i] = u0[i]
    for s in range(substeps):
        rhs_lanes(x, u, numbers, first)
        _ahead(x, 0.5 * h, first, probe)
        _between(u0, u1, (s + 0.5) / substeps, u)
        rhs_lanes(probe, u, numbers, second)
        _ahead(x, 0.5 * h, second, probe)
        rhs_lanes(probe, u, numbers, third)
        _ahead(x, h, third, probe)
        _between(u0, u1, (s + 1.0) / substeps, u)
        rhs_lanes(probe, u, numbers, last)
        for i in range(n):
            x[i] += h / 6.0 * (first[i] + 2.0 * (second[i] + third[i]) + last[i])


@njit(inline="always")
def _keep(x, k, width, states):
    """The states x (n*W,) of the first R of W runs as sample k of states (R, N+1, n)."""
    runs, samples, n = states.shape
    flat = states.reshape(states.size)
    for j in range(runs):
        first = (j * samples + k) * n
        for i in range(n):
            flat[np.uint64(first + i)] = x[np.uint64(i * width + j)]


@njit(types.void(RHS, A1, A2, A1, f8, i8, A1, A3), **JIT)
def open_loop(rhs_lanes, x0, inputs, numbers, dt, substeps, work, states):
    """RK4 along given inputs (N+1, nu*W) from x0 (n*W,); the states (R, N+1, n) of the first R runs are filled.

    work has 6 n*W + nu*W elements.
    """
    x, rest = work[: x0.size], work[x0.size :]
    x[:] = x0
    width = x.size // states.shape[2]
    _keep(x, 0, width, states)
    for k in range(1, states.shape[1]):
        rk4_sample(rhs_lanes, x, inputs[k - 1], inputs[k], numbers, dt, substeps, rest)
        _keep(x, k, width, states)


@njit(types.void(RHS, A1, A2, A1, A1, A2, I1, f8, i8, A3), **JIT)
def in_regimes(rhs_lanes, x0, inputs, numbers, inside, gates, place, dt, substeps, states):
    """`open_loop` with numbers `inside` in a regime of each lane, gates (W, 4), and `numbers` outside."""
    size, x = x0.size, x0.copy()
    samples, n = states.shape[1:]
    width, h = size // n, dt / substeps
    rate, other, total, probe = np.empty(size), np.empty(size), np.empty(size), np.empty(size)
    u = np.empty(inputs.shape[1])
    for k in range(samples):
        for s in range(substeps if k else 0):
            for stage in range(4):
                moved = 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)
                part = (s + moved) / substeps
                _between(inputs[k - 1], inputs[k], part, u)
                for i in range(size):
                    probe[i] = x[i] if stage == 0 else x[i] + moved * h * rate[i]
                rhs_lanes(probe, u, numbers, rate)
                rhs_lanes(probe, u, inside, other)
                time = (k - 1 + part) * dt
                for j in range(width):
                    surge, sway, turn = (
                        probe[place[0] * width + j],
                        probe[place[1] * width + j],
                        probe[place[2] * width + j],
                    )
                    share = share_inside(gates[j], u[j], surge, sway, turn, time)
                    for i in range(j, size, width):
                        rate[i] += share * (other[i] - rate[i])
                weight = h / 6.0 if (stage == 0 or stage == 3) else h / 3.0
                for i in range(size):
                    total[i] = x[i] + weight * rate[i] if stage == 0 else total[i] + weight * rate[i]
            for i in range(size):
                x[i] = total[i]
        _keep(x, k, width, states)


@njit(types.void(RHS, A1, A2, A1, f8, i8, b1, I1, A2, A2, i8, i8, A1, A2, A2, A2), **JIT)
def closed_loop(
    rhs_lanes, x0, inputs, numbers, dt, substeps, explicit, kind, reference, setting, i_psi, i_r, work, states, order,
    rudder,
):  # fmt: skip
    """`drivers.closed_loop` for W runs with ideal linkages, each with a helmsman of its own.

    kind (W,), reference (N+1, W), setting (10, W) as there; states (N+1, n*W), order and rudder (N+1, W) and the
    rudder's columns of inputs (N+1, nu*W) are filled.  work has 6 n*W + nu*W elements.
    """
    width, last = kind.size, states.shape[0] - 1
    n, x, rest = x0.size, work[: x0.size], work[x0.size :]
    x[:] = x0
    command, side, running = np.zeros(width), setting[3].copy(), np.zeros(width, np.bool_)
    start = x0[i_psi * width : (i_psi + 1) * width].copy()
    execute, amplitude, check, lag, rates = setting[0], setting[1], setting[2], setting[4], setting[5]
    limit, kp, kd = setting[6], setting[7], setting[8]
    states[0] = x
    rudder[0] = setting[9]
    inputs[0, :width] = setting[9]
    for k in range(last + 1):
        for j in range(width):
            due = k * dt >= execute[j] - 1e-9 * dt
            command[j], side[j], running[j] = helm(
                kind[j], due, reference[k, j], start[j], x[i_psi * width + j], x[i_r * width + j],
                amplitude[j], check[j], kp[j], kd[j], command[j], side[j], running[j],
            )  # fmt: skip
            order[k, j] = min(max(command[j], -limit[j]), limit[j])
        if k == last:
            break
        for j in range(width):
            rudder[k + 1, j] = steer(rudder[k, j], command[j], dt, lag[j], rates[j], limit[j])
            inputs[k + 1, j] = rudder[k + 1, j]
        if explicit:
            rhs_lanes(x, inputs[k], numbers, rest[:n])
            for i in range(n):
                x[i] += dt * rest[i]
        else:
            rk4_sample(rhs_lanes, x, inputs[k], inputs[k + 1], numbers, dt, substeps, rest)
        states[k + 1] = x
