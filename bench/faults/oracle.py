"""The oracle's Kalman filter: how far a noise-free record is from what the ship without effects would do (numba).

An extended filter of the ship's true equations, with the sensors' and the rudder sensor's true variances, the true
gust process and a vague start. The whitened innovations of a noise-free record are what an effect adds to
the ones that the noise gives, so their sum of squares is the non-centrality of the best possible test.
"""

from __future__ import annotations

from math import exp, log

import numpy as np

from ...models.compilation import njit
from .equations import JIT
from .integrate import rk4


@njit(**JIT)
def advance(kind, c, s, p, extra, functions, h, m, x, rudder, first, spread, force, slopes, work, mid, d, f):
    """m steps of h with the rudder (half steps of h / spread) from index `first`, and a constant force (3,)."""
    for k in range(m):
        for i in range(3):
            d[i] = rudder[min(first + (2 * k + i) * spread, rudder.size - 1)] + force[3]
            f[i, 0], f[i, 1], f[i, 2] = force[0], force[1], force[2]
        rk4(kind, c, s, p, extra, functions, 0.0, h, x, d, f, slopes, work, mid)


@njit(**JIT)
def innovations(
    kind, c, s, p, extra, functions, h, m, spread, per, x0, sd0, y, which, sd, rudder, rudder_sd, gust_sd, tau, z
):
    """Whitened innovations z (N, k) of samples y (N, k) (nan: not measured) of the states `which` (k,).

    extra and functions are no further force (`simulator.further_forces`); x0, sd0 (6,) start; m steps of h a sample,
    each over 2 spread rudder half steps; per: half steps a sample.
    """
    nx, nb = 9, 6
    x = np.zeros(nx)
    x[:6] = x0
    cov = np.zeros((nx, nx))
    for i in range(nb):
        cov[i, i] = sd0[i] ** 2
    for i in range(3):
        cov[6 + i, 6 + i] = gust_sd[i] ** 2
    decay = exp(-h * m / tau)
    slopes, work, mid, d, f = np.zeros((4, 8)), np.zeros(5), np.zeros(8), np.zeros(3), np.zeros((3, 3))
    state, force, base = np.zeros(8), np.zeros(4), np.zeros(nb)
    phi, drive = np.zeros((nx, nx)), np.zeros(nx)
    for k in range(y.shape[0]):
        for j in range(y.shape[1]):
            i = which[j]
            if np.isnan(y[k, j]):
                continue
            variance = cov[i, i] + sd[j] ** 2
            error = y[k, j] - x[i]
            z[k, j] = error / np.sqrt(variance)
            gain = cov[:, i] / variance
            x += gain * error
            cov -= np.outer(gain, cov[i].copy())
        if k == y.shape[0] - 1:
            break
        phi[:] = 0.0
        for i in range(-1, nb + 4):  # the run itself, then by each state, by each gust's force and by the rudder
            force[:3], force[3] = x[6:9], 0.0
            state[:6], state[6], state[7] = x[:6], 0.0, 0.0
            size = 1.0
            if 0 <= i < nb:
                size = 1e-5 * max(sd0[i], 1e-6)
                state[i] += size
            elif i >= nb:
                size = 1e-4 if i == nb + 3 else gust_sd[i - nb]
                force[i - nb] += size
            if size == 0.0:
                continue
            advance(
                kind, c, s, p, extra, functions, h, m, state, rudder, k * per, spread, force, slopes, work, mid, d, f
            )
            if i < 0:
                base[:] = state[:6]
            elif i == nb + 3:
                drive[:6] = (state[:6] - base) / size
            else:
                phi[:6, i] = (state[:6] - base) / size
            if nb <= i < nb + 3:
                phi[i, i] = decay
        x[:6] = base
        x[6:9] *= decay
        cov = phi @ cov @ phi.T + np.outer(drive, drive) * rudder_sd**2
        for i in range(3):
            cov[6 + i, 6 + i] += gust_sd[i] ** 2 * (1.0 - decay**2)


@njit(**JIT)
def variance_gain(z):
    """n (a - log(1 + a)) summed over channels, a = mean square of z: what a test of variances can gain."""
    total = 0.0
    for j in range(z.shape[1]):
        a, n = 0.0, 0
        for k in range(z.shape[0]):
            if not np.isnan(z[k, j]):
                a += z[k, j] ** 2
                n += 1
        if n:
            total += a - n * log(1.0 + a / n)
    return total
