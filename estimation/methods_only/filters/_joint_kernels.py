"""Compiled extended Kalman filter of states and constants (numba; imported only when it runs)."""

from __future__ import annotations

import numpy as np
from numba import types

from ....models.compilation import A1, A2, I1, JIT, f8, i8, njit
from ....models.drivers import TANGENT, tangent_sample


@njit(types.void(A2, A1, A2, A2), **JIT)
def _predict_covariance(p, noise, transition, product):
    """P of the joint vector one sample later; transition (n, m) = [d x'/d x, d x'/d c], noise (n,) variances."""
    n, m = transition.shape
    for i in range(n):
        for j in range(m):
            product[i, j] = 0.0
        for k in range(m):
            t = transition[i, k]
            if t != 0.0:
                for j in range(m):
                    product[i, j] += t * p[k, j]
    for i in range(n):
        for j in range(n, m):
            p[i, j] = product[i, j]
            p[j, i] = product[i, j]
        for j in range(i + 1):
            total = 0.0
            for k in range(m):
                total += product[i, k] * transition[j, k]
            p[i, j] = total
            p[j, i] = total
        p[i, i] += noise[i]


@njit(types.void(A1, A2, i8, f8, f8, A1), **JIT)
def _update(z, p, measured, innovation, variance, gain):
    """Measurement of element `measured` of z with noise `variance`: Joseph form, exactly symmetric."""
    m = z.size
    total = p[measured, measured] + variance
    for i in range(m):
        gain[i] = p[i, measured] / total
        z[i] += gain[i] * innovation
    for i in range(m):
        if i != measured:
            g = gain[i]
            for j in range(m):
                p[i, j] -= g * p[measured, j]
    g = 1.0 - gain[measured]
    for j in range(m):
        p[measured, j] *= g
    for i in range(m):
        first = p[i, measured]
        for j in range(m):
            p[i, j] += gain[j] * (gain[i] * variance - first)
    for i in range(m):
        for j in range(i):
            mean = 0.5 * (p[i, j] + p[j, i])
            p[i, j] = mean
            p[j, i] = mean


@njit(types.void(A1, i8, A1, A2, A1), **JIT)
def coefficients_of(z, n, origin, factor, coefficients):
    """coefficients (q,) = origin + factor z[n:]."""
    for i in range(origin.size):
        total = origin[i]
        for j in range(z.size - n):
            total += factor[i, j] * z[n + j]
        coefficients[i] = total


@njit(f8(A1, A2, i8, A1, I1, A1, A1, A2, A1, A1, A1), **JIT)
def measure(z, p, n, outputs, columns, sensor, origin, factor, innovations, coefficients, gain):
    """One row of measurements, one channel after the other; returns its share of the negative log likelihood.

    z (m,), p (m, m) are updated; outputs (c,), nan = gap, measure the states `columns` (of n) with variances sensor
    (c,).  Filled: innovations (c,), nan at gaps, and coefficients (q,) = origin + factor z[n:].
    """
    cost = 0.0
    for c in range(columns.size):
        innovations[c] = np.nan
        if np.isfinite(outputs[c]):
            error = outputs[c] - z[columns[c]]
            total = p[columns[c], columns[c]] + sensor[c]
            innovations[c] = error
            cost += 0.5 * (np.log(total) + error * error / total)
            _update(z, p, columns[c], error, sensor[c], gain)
    coefficients_of(z, n, origin, factor, coefficients)
    return cost


@njit(f8(TANGENT, A1, A1, A2, A1, A2, A2, A2, I1, I1, f8, i8, I1, I1, i8, A1, A1, A2, A2), **JIT)
def kalman(
    tangent, z, theta, p, origin, factor, inputs, outputs, index, columns, dt, substeps, source, target, sparse,
    process, sensor, path, innovations,
):  # fmt: skip
    """One record through an extended Kalman filter of the joint vector z = (states n, constants e).

    The coefficients are origin + factor e, with origin (q,) and factor (q, m - n); without a `source` of slopes by the
    coefficients they are fixed.
    z (m,), p (m, m) and the coefficients in theta are updated in place.  outputs (N, c), nan = gap, measure the states
    `columns` at grid points `index` (N,), which do not decrease.  process (n,) and sensor (c,) are variances.  path
    (N, q) is filled with the coefficients after each sample, innovations (N, c) with the prediction errors.

    Returns the negative log likelihood of the innovations.
    """
    m, q, e = z.size, origin.size, factor.shape[1]
    n = m - e
    width = n + q if source.size > 0 else n
    x, flat, gain = np.empty(n), np.empty(n * width), np.empty(m)
    work = np.empty(4 * n + 3 * n * width + inputs.shape[1] * (1 + n) + sparse)
    transition, product = np.empty((n, m)), np.empty((n, m))
    row, cost = 0, 0.0
    for k in range(inputs.shape[0]):
        while row < index.size and index[row] <= k:
            cost += measure(z, p, n, outputs[row], columns, sensor, origin, factor, innovations[row], path[row], gain)
            theta[:q] = path[row]
            row += 1
        if k == inputs.shape[0] - 1:
            break
        for i in range(n):
            x[i] = z[i]
            for j in range(width):
                flat[i * width + j] = 1.0 if i == j else 0.0
        tangent_sample(tangent, x, flat, inputs[k], inputs[k + 1], theta, dt, substeps, False, source, target, work)
        for i in range(n):
            z[i] = x[i]
            for j in range(n):
                transition[i, j] = flat[i * width + j]
            for j in range(e):
                transition[i, n + j] = 0.0
            if width > n:
                for c in range(q):
                    slope = flat[i * width + n + c]
                    if slope != 0.0:
                        for j in range(e):
                            transition[i, n + j] += slope * factor[c, j]
        _predict_covariance(p, process, transition, product)
        if not np.isfinite(cost):
            break
    return cost
