"""Compiled recursive least squares (numba; imported only when it runs)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import types

from ....models.compilation import A1, A2, JIT, f8, njit

SUMS: dict[str, Any] = {**JIT, "fastmath": {*JIT["fastmath"], "reassoc"}}
"""Compiler options that let the sums over coefficients run in vector registers."""


@njit(types.void(A1, A2, A1, f8, A1, A2, A1, A2), **SUMS)
def recursive_ls(y, h, forget, weight, theta, factor, diagonal, path):
    """Weighted recursive least squares with forgetting, on the factors of P.

    P = U diag(diagonal) U' with U unit upper triangular (Bierman 1977), which keeps P positive definite where the plain
    recursion does not; `factor` holds U transposed, row j being column j of U.

    y (M,), h (M, d), forget (M,): P is divided by forget[k] before row k, whose noise variance is 1/weight.
    theta (d,), factor (d, d) and diagonal (d,) are updated in place; path (M, d) is filled with theta.
    """
    d = theta.size
    f, v, gain = np.empty(d), np.empty(d), np.empty(d)
    for k in range(y.size):
        row = h[k]
        error = y[k]
        for j in range(d):
            error -= row[j] * theta[j]
        if forget[k] != 1.0:
            for j in range(d):
                diagonal[j] /= forget[k]
        for j in range(d):
            total = row[j]
            for i in range(j):
                total += factor[j, i] * row[i]
            f[j] = total
            v[j] = diagonal[j] * total
        sigma = 1.0 / weight
        inverse = weight
        for j in range(d):
            if f[j] != 0.0:
                step = -f[j] * inverse
                before = sigma
                sigma += f[j] * v[j]
                inverse = 1.0 / sigma
                diagonal[j] *= before * inverse
                for i in range(j):
                    old = factor[j, i]
                    factor[j, i] = old + gain[i] * step
                    gain[i] += old * v[j]
            gain[j] = v[j]
        scale = error * inverse
        for j in range(d):
            theta[j] += gain[j] * scale
            path[k, j] = theta[j]


@njit(types.void(A1, A2, A1, f8, A1, A2, A2), **JIT)
def recursive_ls_as_printed(y, h, forget, weight, theta, p, path):
    """Eq 22 of paper 000 literally: the estimate is divided by mu as if the data were not forgotten."""
    d = theta.size
    ph = np.empty(d)
    for k in range(y.size):
        row, mu = h[k], forget[k]
        product, predicted = 0.0, 0.0
        for i in range(d):
            total = 0.0
            for j in range(d):
                total += p[i, j] * row[j]
            ph[i] = total
        for i in range(d):
            product += row[i] * ph[i]
            predicted += row[i] * theta[i] / mu
        scale = 1.0 / (mu * mu / weight + mu * product)
        for i in range(d):
            for j in range(d):
                p[i, j] = p[i, j] / mu - ph[i] * ph[j] * scale
        for i in range(d):
            total = 0.0
            for j in range(d):
                total += p[i, j] * row[j]
            theta[i] = theta[i] / mu + weight * (y[k] - predicted) * total
        for i in range(d):
            path[k, i] = theta[i]
