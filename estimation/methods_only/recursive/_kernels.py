"""Compiled recursive least squares (numba; imported only when it runs)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import types

from ....models.compilation import A1, A2, JIT, f8, njit

SUMS: dict[str, Any] = {**JIT, "fastmath": {*JIT["fastmath"], "reassoc"}}
"""Compiler options that let the sums over coefficients run in vector registers."""


@njit(inline="always")
def update(row, noise, factor, diagonal, f, v, gain):
    """Measurement update of P = U diag(diagonal) U' (factor = U') with one row (d,) of that noise variance.

    Bierman 1977, which keeps P positive definite where the plain recursion does not.  f, v and gain (d,) are filled,
    gain times the returned 1/(noise + row'P row) being the gain.
    """
    for j in range(row.size):
        total = row[j]
        for i in range(j):
            total += factor[j, i] * row[i]
        f[j] = total
        v[j] = diagonal[j] * total
    sigma, inverse = noise, 1.0 / noise
    for j in range(row.size):
        if f[j] != 0.0:
            step, before = -f[j] * inverse, sigma
            sigma += f[j] * v[j]
            inverse = 1.0 / sigma
            diagonal[j] *= before * inverse
            for i in range(j):
                old = factor[j, i]
                factor[j, i] = old + gain[i] * step
                gain[i] += old * v[j]
        gain[j] = v[j]
    return inverse


@njit(types.void(A1, A2, A1, f8, A1, A2, A1, A2), **SUMS)
def recursive_ls(y, h, forget, weight, theta, factor, diagonal, path):
    """Weighted recursive least squares with forgetting, on the factors of P: `factor` holds U transposed, row j being
    column j of U.

    y (M,), h (M, d), forget (M,): P is divided by forget[k] before row k, whose noise variance is 1/weight.
    theta (d,), factor (d, d) and diagonal (d,) are updated in place; path (M, d) is filled with theta.
    """
    d = theta.size
    f, v, gain = np.empty(d), np.empty(d), np.empty(d)
    for k in range(y.size):
        error = y[k]
        for j in range(d):
            error -= h[k, j] * theta[j]
        if forget[k] != 1.0:
            for j in range(d):
                diagonal[j] /= forget[k]
        scale = error * update(h[k], 1.0 / weight, factor, diagonal, f, v, gain)
        for j in range(d):
            theta[j] += gain[j] * scale
            path[k, j] = theta[j]
