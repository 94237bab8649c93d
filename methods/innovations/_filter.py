"""The estimator's kernel: an extended Kalman filter of any model's bank variant.

States: the model's n, then Ornstein-Uhlenbeck forces (one per force input), then two of wave-frequency motion where
that is switched on.  Measurements enter one by one, so that what comes out are whitened innovations e and log S / 2;
their likelihood is exact for a linear model.  The rudder's own sensor noise and its corners between samples are
process noise.  What derivatives need of a run is written down as it goes (`_linear` carries them along it).
"""

from __future__ import annotations

import numpy as np
from numba import njit, types

from ...models.drivers import A1, A2, A3, I1, JIT, RHS, f8, i8
from .layout import (
    B_C,
    CHANNELS,
    CLOCK,
    D_0,
    D_E,
    D_N,
    E_D,
    E_F,
    EARTH,
    F_0,
    KINK,
    LIMIT,
    MISALIGNED,
    OMEGA,
    PLAY,
    RATE,
    RMS,
    S_C,
    T_0,
    TAU_C,
    TAU_D,
    V_E,
    V_N,
    W_E,
    W_N,
    WIND_DRIFT,
    ZETA,
)

JACOBIAN = types.FunctionType(types.void(A1, A1, A1, A1, A1, A1))


@njit(inline="always")
def _between(series, x):
    """Linear interpolation of samples at position x, held at the ends."""
    if x <= 0.0:
        return series[0]
    k = int(x)
    if k >= series.size - 1:
        return series[series.size - 1]
    return series[k] + (x - k) * (series[k + 1] - series[k])


@njit(types.void(A1, A1, A1, A1, f8, i8, A1), **JIT)
def acting_rudder(time, recorded, quiet, q, noise, parts, out):
    """Rudder angle that the hull feels at `parts` points per sample, from the recorded series and parameters q.

    quiet : the recorded series without its sensor's noise (sd `noise`), which play takes.
    """
    n, size = recorded.size, out.size
    fine = np.empty(size)
    for i in range(size):
        fine[i] = _between(recorded, i / parts)
    if q[PLAY] > 0.0:
        noisy = np.exp(-q[PLAY] / noise)  # a play far below the sensor's noise leaves the recorded angle as it is
        z = quiet[0]
        for i in range(size):
            angle = _between(quiet, i / parts)
            z = min(max(z, angle - q[PLAY]), angle + q[PLAY])
            fine[i] = z + noisy * (fine[i] - angle)
    if q[RATE] > 0.0:
        for i in range(1, size):
            k = (i - 1) // parts
            most = q[RATE] * (time[k + 1] - time[k]) / parts
            fine[i] = fine[i - 1] + min(max(fine[i] - fine[i - 1], -most), most)
    if q[LIMIT] > 0.0:
        for i in range(size):
            fine[i] = min(max(fine[i], -q[LIMIT]), q[LIMIT])
    for k in range(n):
        step = time[min(k + 1, n - 1)] - time[min(k, n - 2)]
        for j in range(parts):
            if k == n - 1 and j > 0:
                break
            gain = 1.0 + q[E_D]
            if q[E_F] != 0.0:
                gain += q[E_F] * min(max((time[k] + step * j / parts - q[T_0]) / step + 0.5, 0.0), 1.0)
            late = q[TAU_D] / step if step > 0.0 else 0.0
            i = k * parts + j
            out[i] = gain * _between(fine, i - late * parts) + q[D_0]


@njit(inline="always")
def _inputs(u, rudder, other, k, q, unit, force, first, env, psi):
    """Kernel inputs: rudder, the record's other inputs, current and wind, and forces in physical units."""
    u[0] = rudder
    for i in range(other.shape[1]):
        u[1 + i] = other[k, i]
    if env >= 0:
        u[env] = q[V_N]
        u[env + 1] = q[V_E]
        u[env + 2] = q[W_N]
        u[env + 3] = q[W_E]
    for i in range(unit.size):
        u[first + i] = unit[i] * (q[F_0 + i] + force[i])
    size = np.sqrt(q[D_N] * q[D_N] + q[D_E] * q[D_E])
    if size > 0.0 and unit.size == 3:
        along = q[D_N] * np.cos(psi) + q[D_E] * np.sin(psi)
        across = -q[D_N] * np.sin(psi) + q[D_E] * np.cos(psi)
        surge = -WIND_DRIFT[0] * along * (1.0 if along > 0.0 else 0.3)
        u[first] += unit[0] * surge
        u[first + 1] -= unit[1] * WIND_DRIFT[1] * across * abs(across) / size
        u[first + 2] -= unit[2] * WIND_DRIFT[2] * 2.0 * across * along / size


@njit(
    types.void(RHS, A1, A1, i8, f8, A2, i8, A1, A1, A1, A1, i8, i8, i8, i8, f8, i8, A1, A1),
    **JIT,
)
def _back(rhs, x, rudder, k, dt, other, n, theta, q, unit, force, first, env, i_psi, parts, tau, nu, out, work):
    """State (n,) a time tau before sample k: midpoint steps of the model run backwards."""
    count = int(tau / (2.0 * dt)) + 1
    h = tau / count
    u, rate, middle = work[:nu], work[nu : nu + n], work[nu + n : nu + 2 * n]
    for i in range(n):
        out[i] = x[i]
    for j in range(count):
        position = max(k - (j + 0.5) * h / dt, 0.0) * parts
        angle = _between(rudder, position)
        _inputs(u, angle, other, k, q, unit, force, first, env, out[i_psi])
        rhs(out, u, theta, rate)
        for i in range(n):
            middle[i] = out[i] - 0.5 * h * rate[i]
        rhs(middle, u, theta, rate)
        for i in range(n):
            out[i] -= h * rate[i]


SIGNATURE = types.void(
    *(RHS, JACOBIAN, A1, A1, A1, A2, A2, A1, I1, A1, A1, A1, A2, A1, A1, i8, I1, A1),
    *(A2, A2, A2, A2, A3, A3, A3, A2, A3, A3),
)


@njit(SIGNATURE, **JIT)
def run_filter(
    rhs, jacobian, time, recorded, quiet, other, measured, p, layout, unit, noise, rudder_noise, exogenous, x0, p0,
    free, varied, probes, whitened, log_s, filtered, predicted, transition, slopes, gains, roots, spreads, pushes,
):  # fmt: skip
    """Filter one record.

    time, recorded, quiet (T,) as in `acting_rudder`; other (T, no) inputs beside the rudder; measured (T, 6) psi, r, u,
    v, x, y with nan gaps;
    p = [theta, OUTER]; layout = [n, size of theta, nu, first force input, first current input or -1, substeps, then
    the state of each channel, -1 without one, -2 - state for a position that nothing measures (left out of the
    covariance)]; unit (nf,) force units; noise (6 + nf + 1,) sensor sds, force sds in units,
    correlation time; rudder_noise (2,) sd of the rudder's sensor and share of its second difference that is error at a
    corner; exogenous (T, nf + 6) added forces and sensor shifts; x0, p0
    (n,) start and variance of states without a channel; free: sample from which nothing is updated any more; varied
    (m,): entries of theta, differenced over probes (m,).

    Filled: whitened, log_s (T, 6) innovations and log S / 2 (0 at gaps), filtered (T, nx) states, predicted (T, 6);
    and, unless they have no rows: transition (T, nx, nx) to the next sample, slopes (T, 6, nx) of the channels by the
    states, gains (T, 6, nx) covariances with them, roots (T, 6) 1 / sqrt S or 0, spreads (T, nf, nx) covariances of the
    forces after the sample, pushes (m, T, n) of the states over the next step by the varied entries (midpoint rule).
    """
    n, nth, nu, first, env, parts_of = layout[0], layout[1], layout[2], layout[3], layout[4], layout[5]
    channel = layout[6:]
    theta, q = p[:nth], p[nth:]
    nf, size, m, kept = unit.size, time.size, varied.size, transition.shape[0] > 0
    waves = q[RMS] > 0.0
    nx = n + nf + (2 if waves else 0)
    na = n + nf
    parts = 2 * parts_of
    rudder = np.empty((size - 1) * parts + 1)
    acting_rudder(time, recorded, quiet, q, rudder_noise[0], parts, rudder)
    x, cov = np.zeros(nx), np.zeros((nx, nx))
    own = x[:n]
    phi, temporary, a = np.zeros((nx, nx)), np.zeros((nx, nx)), np.zeros((na, na))
    power, next_power = np.zeros((na, na)), np.zeros((na, na))
    jx, ju = np.zeros(n * n), np.zeros(n * nu)
    u, rate, probe, total = np.zeros(nu), np.zeros(n), np.zeros(n), np.zeros(n)
    h, ph, force = np.zeros(nx), np.zeros(nx), np.zeros(nf)
    late, work = np.zeros((CHANNELS, n)), np.zeros(nu + 2 * n)
    other_theta, base_rate, push = theta.copy(), np.zeros(n), np.zeros(n)
    i_psi = channel[0]
    live = np.ones(n, np.bool_)
    for c in range(CHANNELS):
        if channel[c] <= -2:
            live[-2 - channel[c]] = False
    for i in range(n):
        x[i], cov[i, i] = x0[i], p0[i] if live[i] else 0.0
    for c in range(CHANNELS):
        i = channel[c]
        if i < 0 or (q[EARTH] > 0.0 and (c == 2 or c == 3)) or (c == 2 and channel[3] < 0):
            continue  # a speed loss starts from the steady course that its reference speed stands for
        for k in range(min(size, 6)):
            y = measured[k, c]
            if not np.isnan(y):
                x[i] = (y - q[B_C + c]) / (1.0 + q[S_C + c])
                cov[i, i] = 100.0 * noise[c] ** 2
                break
    for i in range(nf):
        cov[n + i, n + i] = noise[6 + i] ** 2
    f11 = f12 = f21 = f22 = q11 = q12 = q22 = 0.0
    if waves:
        cov[na, na] = q[RMS] ** 2
        cov[na + 1, na + 1] = (q[RMS] * q[OMEGA]) ** 2
    for k in range(size):
        for i in range(nf):
            force[i] = x[n + i] + exogenous[k, i]
        for c in range(CHANNELS):
            if q[TAU_C + c] > 0.0 and channel[c] >= 0:
                step = time[min(k + 1, size - 1)] - time[min(k, size - 2)]
                _back(
                    rhs, x, rudder, k, step, other, n, theta, q, unit, force, first, env, i_psi, parts,
                    q[TAU_C + c], nu, late[c], work,
                )  # fmt: skip
                for i in range(n):  # what the sample's channels tell in turn moves the late state as the present one
                    late[c, i] -= x[i]
        if q[CLOCK] > 0.0:
            _inputs(u, rudder[k * parts], other, k, q, unit, force, first, env, x[i_psi])
            rhs(own, u, theta, rate)
        for c in range(CHANNELS):
            y = measured[k, c]
            i = channel[c]
            if i < 0:
                whitened[k, c], log_s[k, c], predicted[k, c] = 0.0, 0.0, np.nan
                continue
            for j in range(nx):
                h[j] = 0.0
            gain = 1.0 + q[S_C + c]
            value = late[c, i] + x[i] if q[TAU_C + c] > 0.0 else x[i]
            if (c == 2 or c == 3) and channel[5 - c] >= 0:
                other_value = x[channel[5 - c]]
                if q[TAU_C + c] > 0.0:
                    other_value += late[c, channel[5 - c]]
                along, across = (value, other_value) if c == 2 else (other_value, value)
                angle = q[MISALIGNED]
                if q[EARTH] > 0.0:
                    angle = -x[i_psi]
                cosine, sine = np.cos(angle), np.sin(angle)
                if c == 2:  # axes turned by `angle`: the sensor's surge is u cos + v sin
                    expected = gain * (along * cosine + across * sine)
                    h[channel[2]], h[channel[3]] = gain * cosine, gain * sine
                    slope = -along * sine + across * cosine
                else:
                    expected = gain * (-along * sine + across * cosine)
                    h[channel[2]], h[channel[3]] = -gain * sine, gain * cosine
                    slope = -along * cosine - across * sine
                if q[EARTH] > 0.0:
                    h[i_psi] = -gain * slope
            else:
                expected = gain * value
                h[i] = gain
            if c == 0 and q[TAU_C] > 0.0 and channel[1] >= 0:
                h[channel[1]] = -gain * q[TAU_C]
            expected += q[B_C + c] + exogenous[k, nf + c]
            if waves and c == 0:
                expected += x[na]
                h[na] = 1.0
            elif waves and c == 1:
                expected += x[na + 1]
                h[na + 1] = 1.0
            predicted[k, c] = expected
            if np.isnan(y):
                whitened[k, c], log_s[k, c] = 0.0, 0.0
                continue
            nu_c = y - expected
            if c == 0:
                nu_c -= 2.0 * np.pi * np.round(nu_c / (2.0 * np.pi))
            s = noise[c] ** 2
            if q[CLOCK] > 0.0:
                s += (q[CLOCK] * rate[i]) ** 2
            if k < free:
                for j in range(nx):
                    ph[j] = 0.0
                for j in range(nx):
                    w = h[j]
                    if w != 0.0:
                        for i2 in range(nx):
                            ph[i2] += w * cov[j, i2]
                for j in range(nx):
                    s += h[j] * ph[j]
            root = 1.0 / np.sqrt(s)
            whitened[k, c], log_s[k, c] = nu_c * root, -np.log(root)
            if k >= free:
                continue
            inverse = 1.0 / s
            for i2 in range(nx):
                w = ph[i2] * inverse
                x[i2] += w * nu_c
                if w != 0.0:
                    for j in range(nx):
                        cov[i2, j] -= w * ph[j]
            if kept:
                roots[k, c] = root
                for j in range(nx):
                    slopes[k, c, j], gains[k, c, j] = h[j], ph[j]
        for i in range(nx):
            filtered[k, i] = x[i]
        if k == size - 1:
            break
        # ---- to the next sample
        dt = time[k + 1] - time[k]
        for i in range(nf):
            force[i] = x[n + i] + exogenous[k, i]
        if k < free:
            _inputs(u, rudder[k * parts], other, k, q, unit, force, first, env, x[i_psi])
            jacobian(own, u, theta, rate, jx, ju)
        step = dt / parts_of
        for s_ in range(parts_of):
            at = k * parts + 2 * s_
            _inputs(u, rudder[at], other, k, q, unit, force, first, env, x[i_psi])
            if s_ > 0 or k >= free:  # else the Jacobian brought it along
                rhs(own, u, theta, rate)
            for i in range(n):
                total[i] = x[i] + step / 6.0 * rate[i]
                probe[i] = x[i] + 0.5 * step * rate[i]
            _inputs(u, rudder[at + 1], other, k, q, unit, force, first, env, probe[i_psi])
            rhs(probe, u, theta, rate)
            for i in range(n):
                total[i] += step / 3.0 * rate[i]
                probe[i] = x[i] + 0.5 * step * rate[i]
            rhs(probe, u, theta, rate)
            for i in range(n):
                total[i] += step / 3.0 * rate[i]
                probe[i] = x[i] + step * rate[i]
            _inputs(u, rudder[at + 2], other, k, q, unit, force, first, env, probe[i_psi])
            rhs(probe, u, theta, rate)
            for i in range(n):
                x[i] = total[i] + step / 6.0 * rate[i]
        decay = np.exp(-dt / noise[6 + nf])
        for i in range(nf):
            x[n + i] *= decay
        if waves:
            om, ze = q[OMEGA], q[ZETA]
            damped = om * np.sqrt(1.0 - ze * ze)
            fade, cosine, sine = np.exp(-ze * om * dt), np.cos(damped * dt), np.sin(damped * dt)
            f11, f12 = fade * (cosine + ze * om / damped * sine), fade * sine / damped
            f21, f22 = -fade * om * om / damped * sine, fade * (cosine - ze * om / damped * sine)
            s11 = q[RMS] ** 2
            s22 = s11 * om * om
            q11 = s11 - (f11 * f11 * s11 + f12 * f12 * s22)
            q12 = -(f11 * f21 * s11 + f12 * f22 * s22)
            q22 = s22 - (f21 * f21 * s11 + f22 * f22 * s22)
            w1 = x[na]
            x[na] = f11 * w1 + f12 * x[na + 1]
            x[na + 1] = f21 * w1 + f22 * x[na + 1]
        if k >= free:
            continue
        # ---- covariance: third-order expansion of the transition of states and held forces
        for i in range(n):
            for j in range(n):
                a[i, j] = jx[i * n + j] * dt
            for j in range(nf):
                a[i, n + j] = ju[i * nu + first + j] * unit[j] * dt
        for i in range(nx):
            for j in range(nx):
                phi[i, j] = 1.0 if i == j else 0.0
        for i in range(n):
            for j in range(na):
                power[i, j] = a[i, j]
                phi[i, j] += a[i, j]
        for order in range(2, 4):
            for i in range(n):
                if not live[i]:
                    continue
                for j in range(na):
                    next_power[i, j] = 0.0
                for j2 in range(n):
                    w = power[i, j2] / order
                    if w != 0.0:
                        for j in range(na):
                            next_power[i, j] += w * a[j2, j]
            for i in range(n):
                if not live[i]:
                    continue
                for j in range(na):
                    power[i, j] = next_power[i, j]
                    phi[i, j] += power[i, j]
        if m > 0:
            for i in range(n):
                probe[i] = 0.5 * (filtered[k, i] + x[i])
            _inputs(u, rudder[k * parts + parts_of], other, k, q, unit, force, first, env, probe[i_psi])
            rhs(probe, u, theta, base_rate)
        for column in range(m):
            other_theta[varied[column]] += probes[column]
            rhs(probe, u, other_theta, push)
            other_theta[varied[column]] = theta[varied[column]]
            for i in range(n):
                push[i] = (push[i] - base_rate[i]) * dt / probes[column]
            for i in range(n):
                if not live[i]:
                    continue
                value = push[i]
                for j in range(n):
                    value += 0.5 * a[i, j] * push[j]
                pushes[column, k, i] = value
        for i in range(nf):
            phi[n + i, n + i] = decay
        if waves:
            phi[na, na], phi[na, na + 1], phi[na + 1, na], phi[na + 1, na + 1] = f11, f12, f21, f22
        if kept:
            for i in range(nx):
                if i >= n or live[i]:
                    for j in range(nx):
                        transition[k, i, j] = phi[i, j]
            for i in range(nf):
                for j in range(nx):
                    spreads[k, i, j] = cov[n + i, j]
        for i in range(nx):
            if i < n and not live[i]:
                continue
            for j in range(nx):
                temporary[i, j] = 0.0
            for j2 in range(nx):
                w = phi[i, j2]
                if w != 0.0:
                    for j in range(nx):
                        temporary[i, j] += w * cov[j2, j]
        for i in range(nx):
            if i < n and not live[i]:
                continue
            for j in range(min(i + 1, n)):
                if live[j]:
                    value = 0.0
                    for j2 in range(na):
                        value += temporary[i, j2] * phi[j, j2]
                    cov[i, j] = value
                    cov[j, i] = value
            for j in range(n, min(i + 1, na)):
                cov[i, j] = temporary[i, j] * decay
                cov[j, i] = cov[i, j]
            for j in range(na, i + 1):
                cov[i, j] = temporary[i, na] * phi[j, na] + temporary[i, na + 1] * phi[j, na + 1]
                cov[j, i] = cov[i, j]
        for i in range(nf):
            cov[n + i, n + i] += noise[6 + i] ** 2 * (1.0 - decay * decay)
        if waves:
            cov[na, na] += q11
            cov[na, na + 1] += q12
            cov[na + 1, na] += q12
            cov[na + 1, na + 1] += q22
        corner = 0.0
        for o in range(2):
            if k + o >= 1 and k + o < size - 1:
                corner = max(corner, abs(recorded[k + o + 1] - 2.0 * recorded[k + o] + recorded[k + o - 1]))
        variance = rudder_noise[0] ** 2
        if corner > KINK * rudder_noise[0]:
            variance += (rudder_noise[1] * corner) ** 2
        variance *= dt * dt * (1.0 + q[E_D]) ** 2
        for i in range(n):
            if not live[i]:
                continue
            w = ju[i * nu] * variance
            if w != 0.0:
                for j in range(n):
                    if live[j]:
                        cov[i, j] += w * ju[j * nu]
            cov[i, i] += 1e-14
