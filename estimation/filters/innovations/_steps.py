"""The steps of one sample of the filter's kernel, compiled into it."""

from __future__ import annotations

import numpy as np

from ....models.compilation import JIT, njit
from ....models.rudder_chain import run_chain
from .vector import (
    BIAS,
    CHANNELS,
    CURRENT,
    DELAY,
    DRIFT,
    EARTH,
    FORCE,
    MISALIGNMENT,
    N_CHAIN,
    OMEGA,
    RMS,
    SCALE,
    SPEED,
    ZETA,
)

DRIFT_COEFFICIENTS = (0.010, 0.020, 0.002)
"""Mean wave drift force coefficients in surge, sway and yaw (those of datasets.disturbances)."""
CORNER = 12.0
"""Second difference of the rudder, in its sensor's sd, from which a corner lies between samples."""
PSI, R, U, V = 0, 1, 2, 3
"""Channels that are treated each in their own way."""


@njit(**JIT)
def felt_rudder(recorded, q, shape, noise):
    """The rudder that the hull feels, at every half RK4 step, with the chain's numbers in q."""
    parts = 2 * shape.substeps
    rudder = np.empty((recorded.time.size - 1) * parts + 1)
    run_chain(recorded.time, recorded.rudder, recorded.quiet, q[:N_CHAIN], noise, parts, rudder)
    return rudder


@njit(**JIT)
def live_states(channel, n):
    """(n,) whether a state is filtered: positions that nothing measures are left out of the covariance."""
    live = np.ones(n, np.bool_)
    for c in range(CHANNELS):
        if channel[c] <= -2:
            live[-2 - channel[c]] = False
    return live


@njit(inline="always")
def between(series, x):
    """Linear interpolation of samples at position x, held at the ends."""
    if x <= 0.0:
        return series[0]
    k = int(x)
    if k >= series.size - 1:
        return series[series.size - 1]
    return series[k] + (x - k) * (series[k + 1] - series[k])


@njit(inline="always")
def hold_inputs(u, k, other, environment, q, shape, unit, force):
    """The inputs that stay over a step: the record's other ones, current and wind, forces in N and N m."""
    for i in range(other.shape[1]):
        u[1 + i] = other[k, i]
    if shape.first_current >= 0:
        for i in range(4):
            u[shape.first_current + i] = q[CURRENT + i] + environment[k, i]
    for i in range(unit.size):
        u[shape.first_force + i] = unit[i] * force[i] + (q[FORCE + i] if unit.size == 3 else 0.0)


@njit(inline="always")
def set_inputs(u, rudder, psi, q, shape, unit, force):
    """The inputs that change within a step: the rudder, and the wave drift, which turns with the ship."""
    u[0] = rudder
    size = np.sqrt(q[DRIFT] * q[DRIFT] + q[DRIFT + 1] * q[DRIFT + 1]) if unit.size == 3 else 0.0
    if size > 0.0:
        first, length = shape.first_force, unit[2] / unit[0]
        along = q[DRIFT] * np.cos(psi) + q[DRIFT + 1] * np.sin(psi)
        across = -q[DRIFT] * np.sin(psi) + q[DRIFT + 1] * np.cos(psi)
        surge = -DRIFT_COEFFICIENTS[0] * along * (1.0 if along > 0.0 else 0.3)
        sway = -DRIFT_COEFFICIENTS[1] * across * abs(across) / size
        yaw = -DRIFT_COEFFICIENTS[2] * length * 2.0 * across * along / size
        u[first] = unit[0] * force[0] + q[FORCE] + surge
        u[first + 1] = unit[1] * force[1] + q[FORCE + 1] + sway
        u[first + 2] = unit[2] * force[2] + q[FORCE + 2] + yaw


@njit(inline="always")
def earlier(rhs, x, u, rate, probe, rudder, k, dt, tau, theta, q, shape, unit, force, i_psi, out):
    """State (n,) a time tau before sample k, and its rate: midpoint steps of the model run backwards."""
    n, parts = shape.n, 2 * shape.substeps
    count = int(tau / (2.0 * dt)) + 1
    h = tau / count
    for i in range(n):
        out[i] = x[i]
    for j in range(count):
        position = max(k - (j + 0.5) * h / dt, 0.0) * parts
        set_inputs(u, between(rudder, position), out[i_psi], q, shape, unit, force)
        rhs(out, u, theta, rate)
        for i in range(n):
            probe[i] = out[i] - 0.5 * h * rate[i]
        rhs(probe, u, theta, rate)
        for i in range(n):
            out[i] -= h * rate[i]
    set_inputs(u, between(rudder, max(k - tau / dt, 0.0) * parts), out[i_psi], q, shape, unit, force)
    rhs(out, u, theta, rate)


@njit(inline="always")
def begin(x, cov, channel, start, variance, measured, sensor_sd, force_sd, q, shape):
    """Fill the first state and covariance: from the channels' first samples, else as the record suggests."""
    n, nf, na = shape.n, shape.n_forces, shape.n + shape.n_forces
    for i in range(n):
        x[i], cov[i, i] = start[i], variance[i]
    for c in range(CHANNELS):
        i = channel[c]
        if i <= -2:
            cov[-2 - i, -2 - i] = 0.0
        if i < 0 or (q[EARTH] > 0.0 and U <= c <= V) or (c == U and q[SPEED] > 0.0):
            continue  # a speed loss starts from the straight course that its reference speed stands for
        for k in range(min(measured.shape[0], 6)):
            y = measured[k, c]
            if not np.isnan(y):
                x[i] = (y - q[BIAS + c]) / (1.0 + q[SCALE + c])
                cov[i, i] = 100.0 * sensor_sd[c] ** 2
                break
    for i in range(nf):
        cov[n + i, n + i] = force_sd[i] ** 2
    if q[RMS] > 0.0:
        cov[na, na] = q[RMS] ** 2
        cov[na + 1, na + 1] = (q[RMS] * q[OMEGA]) ** 2


@njit(inline="always")
def of_velocity(x, h, c, channel, value, other, q, i_psi):
    """Expected surge or sway of a log whose axes are turned, and its slopes in h."""
    gain = 1.0 + q[SCALE + c]
    along, across = (value, other) if c == U else (other, value)
    angle = -x[i_psi] if q[EARTH] > 0.0 else q[MISALIGNMENT]
    cosine, sine = np.cos(angle), np.sin(angle)
    if c == U:  # axes turned by `angle`: the sensor's surge is u cos + v sin
        expected = gain * (along * cosine + across * sine)
        h[channel[U]], h[channel[V]] = gain * cosine, gain * sine
        slope = -along * sine + across * cosine
    else:
        expected = gain * (-along * sine + across * cosine)
        h[channel[U]], h[channel[V]] = -gain * sine, gain * cosine
        slope = -along * cosine - across * sine
    if q[EARTH] > 0.0:
        h[i_psi] = -gain * slope
    return expected


@njit(inline="always")
def expected(x, h, late, c, channel, q, na):
    """What the sensor of channel c should show, without added shifts, and its slopes by the states in h."""
    i, is_late = channel[c], q[DELAY + c] > 0.0
    for j in range(h.size):
        h[j] = 0.0
    value = late[c, i] + x[i] if is_late else x[i]
    gain = 1.0 + q[SCALE + c]
    if U <= c <= V and channel[U + V - c] >= 0:
        j = channel[U + V - c]
        expected = of_velocity(x, h, c, channel, value, x[j] + late[c, j] if is_late else x[j], q, channel[PSI])
    elif c == U and q[SPEED] > 0.0:
        expected = gain * q[SPEED] * (1.0 - value)
        h[i] = -gain * q[SPEED]
    else:
        expected = gain * value
        h[i] = gain
    if c == PSI and is_late and channel[R] >= 0:
        h[channel[R]] = -gain * q[DELAY]
    if q[RMS] > 0.0 and c <= R:
        expected += x[na + c]
        h[na + c] = 1.0
    return expected + q[BIAS + c]


@njit(inline="always")
def measure(x, cov, h, ph, innovation, variance, update):
    """Whitened innovation and 1 / sqrt S of one measured value; states and covariance updated by it."""
    nx = x.size
    if update:
        for j in range(nx):
            ph[j] = 0.0
        for j in range(nx):
            weight = h[j]
            if weight != 0.0:
                for i in range(nx):
                    ph[i] += weight * cov[j, i]
        for j in range(nx):
            variance += h[j] * ph[j]
    root = 1.0 / np.sqrt(variance)
    if update:
        inverse = 1.0 / variance
        for i in range(nx):
            weight = ph[i] * inverse
            x[i] += weight * innovation
            if weight != 0.0:
                for j in range(nx):
                    cov[i, j] -= weight * ph[j]
    return innovation * root, root


@njit(inline="always")
def propagate(rhs, x, u, rate, probe, total, rudder, at, dt, theta, q, shape, unit, force, i_psi, has_rate):
    """The model's states to the next sample by RK4; `rate` holds the first slope where `has_rate`."""
    n, step = shape.n, dt / shape.substeps
    own = x[:n]
    for part in range(shape.substeps):
        if part > 0 or not has_rate:
            set_inputs(u, rudder[at], x[i_psi], q, shape, unit, force)
            rhs(own, u, theta, rate)
        for i in range(n):
            total[i] = x[i] + step / 6.0 * rate[i]
            probe[i] = x[i] + 0.5 * step * rate[i]
        set_inputs(u, rudder[at + 1], probe[i_psi], q, shape, unit, force)
        rhs(probe, u, theta, rate)
        for i in range(n):
            total[i] += step / 3.0 * rate[i]
            probe[i] = x[i] + 0.5 * step * rate[i]
        rhs(probe, u, theta, rate)
        for i in range(n):
            total[i] += step / 3.0 * rate[i]
            probe[i] = x[i] + step * rate[i]
        set_inputs(u, rudder[at + 2], probe[i_psi], q, shape, unit, force)
        rhs(probe, u, theta, rate)
        for i in range(n):
            x[i] = total[i] + step / 6.0 * rate[i]
        at += 2


@njit(inline="always")
def waves(x, wave, dt, q, na):
    """Wave motion to the next sample; wave = transition (11, 12, 21, 22) and added covariance (11, 12, 22)."""
    omega, zeta = q[OMEGA], q[ZETA]
    damped = omega * np.sqrt(1.0 - zeta * zeta)
    fade, cosine, sine = np.exp(-zeta * omega * dt), np.cos(damped * dt), np.sin(damped * dt)
    f11, f12 = fade * (cosine + zeta * omega / damped * sine), fade * sine / damped
    f21, f22 = -fade * omega * omega / damped * sine, fade * (cosine - zeta * omega / damped * sine)
    s11 = q[RMS] ** 2
    s22 = s11 * omega * omega
    wave[0], wave[1], wave[2], wave[3] = f11, f12, f21, f22
    wave[4] = s11 - (f11 * f11 * s11 + f12 * f12 * s22)
    wave[5] = -(f11 * f21 * s11 + f12 * f22 * s22)
    wave[6] = s22 - (f21 * f21 * s11 + f22 * f22 * s22)
    before = x[na]
    x[na] = f11 * before + f12 * x[na + 1]
    x[na + 1] = f21 * before + f22 * x[na + 1]


@njit(inline="always")
def transition(phi, slope, power, next_power, by_state, by_input, wave, dt, decay, live, shape, unit):
    """phi: third-order expansion of the transition of states and held forces; slope: the generator times dt."""
    n, nf, nu, na, nx = shape.n, shape.n_forces, shape.n_inputs, shape.n + shape.n_forces, phi.shape[0]
    for i in range(n):
        for j in range(n):
            slope[i, j] = by_state[i * n + j] * dt
        for j in range(nf):
            slope[i, n + j] = by_input[i * nu + shape.first_force + j] * unit[j] * dt
    for i in range(nx):
        for j in range(nx):
            phi[i, j] = 1.0 if i == j else 0.0
    for i in range(n):
        for j in range(na):
            power[i, j] = slope[i, j]
            phi[i, j] += slope[i, j]
    for order in range(2, 4):
        for i in range(n):
            if not live[i]:
                continue
            for j in range(na):
                next_power[i, j] = 0.0
            for j2 in range(n):
                weight = power[i, j2] / order
                if weight != 0.0:
                    for j in range(na):
                        next_power[i, j] += weight * slope[j2, j]
        for i in range(n):
            if not live[i]:
                continue
            for j in range(na):
                power[i, j] = next_power[i, j]
                phi[i, j] += power[i, j]
    for i in range(nf):
        phi[n + i, n + i] = decay
    if nx > na:
        phi[na, na], phi[na, na + 1], phi[na + 1, na], phi[na + 1, na + 1] = wave[0], wave[1], wave[2], wave[3]


@njit(inline="always")
def covariance(cov, phi, product, wave, decay, live, shape, force_sd):
    """The covariance to the next sample: Phi P Phi' and the noise of forces and waves."""
    n, nf, na, nx = shape.n, shape.n_forces, shape.n + shape.n_forces, cov.shape[0]
    for i in range(nx):
        if i < n and not live[i]:
            continue
        for j in range(nx):
            product[i, j] = 0.0
        for j2 in range(nx):
            weight = phi[i, j2]
            if weight != 0.0:
                for j in range(nx):
                    product[i, j] += weight * cov[j2, j]
    for i in range(nx):
        if i < n and not live[i]:
            continue
        for j in range(min(i + 1, n)):
            if live[j]:
                value = 0.0
                for j2 in range(na):
                    value += product[i, j2] * phi[j, j2]
                cov[i, j] = value
                cov[j, i] = value
        for j in range(n, min(i + 1, na)):
            cov[i, j] = product[i, j] * decay
            cov[j, i] = cov[i, j]
        for j in range(na, i + 1):
            cov[i, j] = product[i, na] * phi[j, na] + product[i, na + 1] * phi[j, na + 1]
            cov[j, i] = cov[i, j]
    for i in range(nf):
        cov[n + i, n + i] += force_sd[i] ** 2 * (1.0 - decay * decay)
    if nx > na:
        cov[na, na] += wave[4]
        cov[na, na + 1] += wave[5]
        cov[na + 1, na] += wave[5]
        cov[na + 1, na + 1] += wave[6]


@njit(inline="always")
def rudder_noise(cov, by_input, k, dt, live, shape, rudder, rudder_error, q):
    """Process noise of the rudder's sensor and of its corners between samples."""
    n, nu, size = shape.n, shape.n_inputs, rudder.size
    corner = 0.0
    for o in range(2):
        if k + o >= 1 and k + o < size - 1:
            corner = max(corner, abs(rudder[k + o + 1] - 2.0 * rudder[k + o] + rudder[k + o - 1]))
    variance = rudder_error[0] ** 2
    if corner > CORNER * rudder_error[0]:
        variance += (rudder_error[1] * corner) ** 2
    variance *= dt * dt * (1.0 + q[0]) ** 2
    for i in range(n):
        if not live[i]:
            continue
        weight = by_input[i * nu] * variance
        if weight != 0.0:
            for j in range(n):
                if live[j]:
                    cov[i, j] += weight * by_input[j * nu]
        cov[i, i] += 1e-14
