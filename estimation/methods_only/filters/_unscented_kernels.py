"""Compiled recursion of the unscented Kalman filter (numba; imported only when it runs)."""

from __future__ import annotations

import numpy as np
from numba import types

from ....models.compilation import A1, A2, I1, JIT, f8, i8, njit
from ....models.drivers import RHS, rk4_sample
from ._joint_kernels import coefficients_of, measure


@njit(types.void(A2, A2), **JIT)
def _root(p, root):
    """Lower triangle with root root' = p (m, m); a column is zero where p has no variance left."""
    m = p.shape[0]
    for j in range(m):
        left = p[j, j]
        for k in range(j):
            left -= root[j, k] * root[j, k]
        pivot = np.sqrt(left) if left > 1e-14 * p[j, j] else 0.0
        for i in range(m):
            if i < j or pivot == 0.0:
                root[i, j] = 0.0
                continue
            total = p[i, j]
            for k in range(j):
                total -= root[i, k] * root[j, k]
            root[i, j] = total / pivot


@njit(f8(RHS, A1, A1, A2, A1, A2, A2, A2, I1, I1, f8, i8, A1, A1, f8, f8, A2, A2), **JIT)
def unscented(
    rhs, z, theta, p, origin, factor, inputs, outputs, index, columns, dt, substeps, process, sensor, alpha, beta,
    path, innovations,
):  # fmt: skip
    """One record through an unscented Kalman filter of z = (states n, e), coefficients origin + factor e.

    Prediction by 2 (n + e) + 1 sigma points at alpha sqrt(n + e) standard deviations, the coefficients constant;
    measurements of single states are linear and taken in one by one.  Arguments as those of the extended filter's
    kernel.  Returns the negative log likelihood.
    """
    m, q, e = z.size, origin.size, factor.shape[1]
    n = m - e
    reach = alpha * np.sqrt(float(m))
    weight = 0.5 / reach**2
    root, gain = np.zeros((m, m)), np.empty(m)
    middle, moved, shift, mean = np.empty(n), np.empty(n), np.empty(n), np.empty(q)
    work = np.empty(3 * n + inputs.shape[1])
    spread, cross = np.empty((n, n)), np.empty((n, e))
    row, cost = 0, 0.0
    for k in range(inputs.shape[0]):
        while row < index.size and index[row] <= k:
            cost += measure(z, p, n, outputs[row], columns, sensor, origin, factor, innovations[row], path[row], gain)
            row += 1
        if k == inputs.shape[0] - 1 or not np.isfinite(cost):
            break
        _root(p, root)
        steps = root[n:].T @ factor.T  # what each column of the root adds to the coefficients
        coefficients_of(z, n, origin, factor, mean)
        theta[:q] = mean
        middle[:] = z[:n]
        rk4_sample(rhs, middle, inputs[k], inputs[k + 1], theta, dt, substeps, work)
        shift[:], spread[:], cross[:] = 0.0, 0.0, 0.0
        for s in range(2 * m):
            column, side = s // 2, 1.0 - 2.0 * (s % 2)
            for i in range(n):
                moved[i] = z[i] + side * reach * root[i, column]
            for i in range(q):
                theta[i] = mean[i] + side * reach * steps[column, i]
            rk4_sample(rhs, moved, inputs[k], inputs[k + 1], theta, dt, substeps, work)
            for i in range(n):
                moved[i] -= middle[i]
                shift[i] += weight * moved[i]
            for i in range(n):
                for j in range(i + 1):
                    spread[i, j] += weight * moved[i] * moved[j]
                for j in range(e):
                    cross[i, j] += weight * moved[i] * side * reach * root[n + j, column]
        for i in range(n):
            z[i] = middle[i] + shift[i]
            for j in range(i + 1):
                total = spread[i, j] + (beta - alpha * alpha) * shift[i] * shift[j]
                p[i, j] = total
                p[j, i] = total
            p[i, i] += process[i]
            for j in range(e):
                p[i, n + j] = cross[i, j]
                p[n + j, i] = cross[i, j]
    coefficients_of(z, n, origin, factor, mean)
    theta[:q] = mean
    return cost
