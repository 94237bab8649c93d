"""Extended Kalman filter of any model's bank variant, compiled.

States: the model's n, then random forces (one first-order Gauss-Markov process per force input), then two of
wave-frequency motion where that is switched on.  Measurements enter one by one, so that what comes out are whitened
innovations e and log S / 2; their likelihood is exact for a linear model.  The rudder sensor's noise and the rudder's
corners between samples are process noise.  What derivatives need of a run is stored as it goes (`_derivatives`
carries them along it).

The steps of one sample are `_measure` (channel by channel), `_propagate` (states), `_transition` and `_covariance`.
"""

from __future__ import annotations

import numpy as np

from ....models.compilation import BORROWED, JIT, njit
from ._arguments import Work, signatures
from ._steps import (
    PSI,
    begin,
    covariance,
    earlier,
    expected,
    felt_rudder,
    hold_inputs,
    live_states,
    measure,
    propagate,
    rudder_noise,
    set_inputs,
    transition,
    waves,
)
from .vector import CHANNELS, DELAY, JITTER, RMS


@njit(**JIT, **BORROWED)
def _samples(rhs, jacobian, shape, channel, recorded, values, free, rudder, w, run, trace):
    """Sample after sample: measurements in turn, then states and covariance on to the next one."""
    theta, q, live, x, cov, phi, product, wave = w.theta, w.q, w.live, w.x, w.cov, w.phi, w.product, w.wave
    slope, power, next_power, by_state, by_input = w.slope, w.power, w.next_power, w.by_state, w.by_input
    u, rate, probe, total, h, ph, force, late, back = w.u, w.rate, w.probe, w.total, w.h, w.ph, w.force, w.late, w.back
    n, nf, parts, i_psi = shape.n, shape.n_forces, 2 * shape.substeps, channel[PSI]
    na, nx = n + nf, x.size
    time, measured, added, unit = recorded.time, recorded.measured, values.added, values.force_unit
    other, environment, sensor_sd, force_sd = recorded.other, recorded.environment, values.sensor_sd, values.force_sd
    e, log_s, states, predicted, rates = run.e, run.log_s, run.states, run.predicted, trace.rates
    size, kept, jitter, own = time.size, rates.shape[0] > 0, q[JITTER] > 0.0, x[:n]
    begin(x, cov, channel, recorded.start, recorded.variance, measured, sensor_sd, force_sd, q, shape)
    for k in range(size):
        dt = time[min(k + 1, size - 1)] - time[min(k, size - 2)]
        for i in range(nf):
            if k == free:
                x[n + i] = 0.0
            force[i] = x[n + i] + added[k, i]
        hold_inputs(u, k, other, environment, q, shape, unit, force)
        if kept or jitter:
            set_inputs(u, rudder[k * parts], x[i_psi], q, shape, unit, force)
            rhs(own, u, theta, rate)
        for c in range(CHANNELS):
            i = channel[c]
            if kept and i >= 0:
                rates[k, c] = rate[i]
            if q[DELAY + c] > 0.0 and i >= 0:
                earlier(
                    rhs, x, u, back, probe, rudder, k, dt, q[DELAY + c], theta, q, shape, unit, force, i_psi, late[c]
                )
                if kept:
                    rates[k, c] = back[i]
                for j in range(n):  # the sample's channels move the late state as they move the present one
                    late[c, j] -= x[j]
        for c in range(CHANNELS):
            i, y = channel[c], measured[k, c]
            e[k, c], log_s[k, c], predicted[k, c] = 0.0, 0.0, np.nan
            if i >= 0:
                predicted[k, c] = expected(x, h, late, c, channel, q, na) + added[k, nf + c]
            if i < 0 or np.isnan(y):
                continue
            innovation = y - predicted[k, c]
            if c == PSI:
                innovation -= 2.0 * np.pi * np.round(innovation / (2.0 * np.pi))
            variance = sensor_sd[c] ** 2 + ((q[JITTER] * rate[i]) ** 2 if jitter else 0.0)
            e[k, c], root = measure(x, cov, h, ph, innovation, variance, k < free)
            log_s[k, c] = -np.log(root)
            if kept:
                trace.roots[k, c] = root
                for j in range(nx):
                    trace.slopes[k, c, j], trace.gains[k, c, j] = h[j], ph[j] if k < free else 0.0
        for i in range(nx):
            states[k, i] = x[i]
        if k == size - 1:
            break
        # ---- to the next sample
        for i in range(nf):
            force[i] = x[n + i] + added[k, i]
        hold_inputs(u, k, other, environment, q, shape, unit, force)
        if k < free or kept:
            set_inputs(u, rudder[k * parts], x[i_psi], q, shape, unit, force)
            jacobian(own, u, theta, rate, by_state, by_input)
        propagate(rhs, x, u, rate, probe, total, rudder, k * parts, dt, theta, q, shape, unit, force, i_psi, k < free)
        decay = np.exp(-dt / values.correlation_time[0])
        for i in range(nf):
            x[n + i] *= decay
        if nx > na:
            waves(x, wave, dt, q, na)
        if k >= free and not kept:
            continue
        transition(phi, slope, power, next_power, by_state, by_input, wave, dt, decay, live, shape, unit)
        if kept:
            for i in range(nx):
                known = live[i] if i < n else (k + 1 != free or i >= na)  # random forces end at the release
                for j in range(nx):
                    trace.transition[k, i, j] = phi[i, j] if known else 0.0
        if k >= free:
            continue
        if kept:
            for i in range(nf):
                for j in range(nx):
                    trace.spreads[k, i, j] = cov[n + i, j]
        covariance(cov, phi, product, wave, decay, live, shape, force_sd)
        rudder_noise(cov, by_input, k, dt, live, shape, recorded.rudder, values.rudder_error, q)


@njit(signatures()[0], **JIT)
def run_filter(rhs, jacobian, shape, channel, recorded, values, free, run, trace):
    """Filter one segment of a record; `run` and `trace` are filled.

    channel : (6,) the state of each channel, -1 without one, -2 - state for a position that nothing measures (left out
        of the covariance).
    free : sample from which nothing is updated any more; random forces are zero from there.
    """
    n, na, nu = shape.n, shape.n + shape.n_forces, shape.n_inputs
    theta, q = values.vector[: shape.n_theta].copy(), values.vector[shape.n_theta :].copy()
    nx = na + (2 if q[RMS] > 0.0 else 0)
    rudder = felt_rudder(recorded, q, shape, values.rudder_error[0])
    w = Work(
        theta, q, live_states(channel, n), np.zeros(nx), np.zeros((nx, nx)), np.zeros((nx, nx)), np.zeros((nx, nx)),
        np.zeros(7), np.zeros((na, na)), np.zeros((na, na)), np.zeros((na, na)), np.zeros(n * n), np.zeros(n * nu),
        np.zeros(nu), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(nx), np.zeros(nx), np.zeros(shape.n_forces),
        np.zeros((CHANNELS, n)), np.zeros(n),
    )  # fmt: skip
    _samples(rhs, jacobian, shape, channel, recorded, values, free, rudder, w, run, trace)
