"""How entries of the parameter vector push the states along a run of the filter, by differences of its right-hand side.

The run is stored: its states are propagated once more from each sample, as the filter did.
"""

from __future__ import annotations

import numpy as np

from ....models.compilation import BORROWED, JIT, njit
from ._arguments import signatures
from ._steps import PSI, felt_rudder, hold_inputs, live_states, propagate, set_inputs
from .vector import N_CHAIN


@njit(**JIT)
def _nudged(recorded, q, shape, noise, varied, probes):
    """The rudder that the hull feels with each varied number of its chain changed."""
    places = varied - shape.n_theta
    own = np.flatnonzero((places >= 0) & (places < N_CHAIN))
    nudged = np.empty((own.size, (recorded.time.size - 1) * 2 * shape.substeps + 1))
    for row in range(own.size):
        chain = q.copy()
        chain[places[own[row]]] += probes[own[row]]
        nudged[row] = felt_rudder(recorded, chain, shape, noise)
    return nudged


@njit(**JIT, **BORROWED)
def _push(rhs, k, dt, probe, u, rate, total, force, slope, nudged, varied, probes, fixed, q, theta, shape, pushes):
    """pushes[k]: change of the states over the step by each varied entry, by the midpoint rule.

    probe : the state at the middle; fixed = (rudder there, psi's place, force units, recorded inputs, which states are
        filtered).
    """
    middle, i_psi, unit, other, environment, live = fixed
    n, row = shape.n, 0
    set_inputs(u, middle, probe[i_psi], q, shape, unit, force)
    rhs(probe, u, theta, rate)
    for column in range(varied.size):
        entry, h = varied[column], probes[column]
        if entry < shape.n_theta:
            before = theta[entry]
            theta[entry] = before + h
            rhs(probe, u, theta, total)
            theta[entry] = before
        elif entry < shape.n_theta + N_CHAIN:
            set_inputs(u, nudged[row, (2 * k + 1) * shape.substeps], probe[i_psi], q, shape, unit, force)
            row += 1
            rhs(probe, u, theta, total)
            set_inputs(u, middle, probe[i_psi], q, shape, unit, force)
        else:
            before = q[entry - shape.n_theta]
            q[entry - shape.n_theta] = before + h
            hold_inputs(u, k, other, environment, q, shape, unit, force)
            set_inputs(u, middle, probe[i_psi], q, shape, unit, force)
            rhs(probe, u, theta, total)
            q[entry - shape.n_theta] = before
            hold_inputs(u, k, other, environment, q, shape, unit, force)
            set_inputs(u, middle, probe[i_psi], q, shape, unit, force)
        for i in range(n):
            total[i] = (total[i] - rate[i]) * dt / h
        for i in range(n):
            if live[i]:
                value = total[i]
                for j in range(n):
                    value += 0.5 * slope[i, j] * total[j]
                pushes[k, column, i] = value


@njit(**JIT, **BORROWED)
def _along(
    rhs, jacobian, shape, i_psi, recorded, values, varied, probes, states, pushes, theta, q, rudder, nudged, live, x,
    rate, probe, total, u, slope, by_state, by_input, force,
):  # fmt: skip
    """Sample after sample of `run_pushes`; the last arrays are working space."""
    n, nf, parts = shape.n, shape.n_forces, 2 * shape.substeps
    unit, other, environment = values.force_unit, recorded.other, recorded.environment
    for k in range(recorded.time.size - 1):
        dt = recorded.time[k + 1] - recorded.time[k]
        for i in range(n):
            x[i] = states[k, i]
        for i in range(nf):
            force[i] = states[k, n + i] + values.added[k, i]
        hold_inputs(u, k, other, environment, q, shape, unit, force)
        set_inputs(u, rudder[k * parts], x[i_psi], q, shape, unit, force)
        jacobian(x, u, theta, rate, by_state, by_input)
        for i in range(n):
            for j in range(n):
                slope[i, j] = by_state[i * n + j] * dt
        propagate(rhs, x, u, rate, probe, total, rudder, k * parts, dt, theta, q, shape, unit, force, i_psi, True)
        for i in range(n):
            probe[i] = 0.5 * (states[k, i] + x[i])
        fixed = (rudder[(2 * k + 1) * shape.substeps], i_psi, unit, other, environment, live)
        _push(
            rhs, k, dt, probe, u, rate, total, force, slope, nudged, varied, probes, fixed, q, theta, shape, pushes,
        )  # fmt: skip


@njit(signatures()[1], **JIT)
def run_pushes(rhs, jacobian, shape, channel, recorded, values, varied, probes, states, pushes):
    """Fill pushes (T, m, n): change of the states over the next step by each varied entry (midpoint rule).

    channel : see `_kernel.run_filter`.
    varied : (m,) entries of the vector (model, rudder chain or environment), differenced over `probes` (m,).
    states : (T, nx) of the run.
    """
    n, nu = shape.n, shape.n_inputs
    theta, q = values.vector[: shape.n_theta].copy(), values.vector[shape.n_theta :].copy()
    noise = values.rudder_error[0]
    rudder, nudged = felt_rudder(recorded, q, shape, noise), _nudged(recorded, q, shape, noise, varied, probes)
    live = live_states(channel, n)
    x, rate, probe, total, u = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(nu)
    slope, by_state, by_input, force = np.zeros((n, n)), np.zeros(n * n), np.zeros(n * nu), np.zeros(shape.n_forces)
    _along(
        rhs, jacobian, shape, channel[PSI], recorded, values, varied, probes, states, pushes, theta, q, rudder, nudged,
        live, x, rate, probe, total, u, slope, by_state, by_input, force,
    )  # fmt: skip
