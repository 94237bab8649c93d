"""Compiled recursions: least squares, multi-innovation and iterative learning (numba; imported only when one runs)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import types

from ....models.compilation import A1, A2, JIT, f8, i8, njit

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


@njit(f8(A1, A1), **JIT)
def _dot(a, b):
    total = 0.0
    for j in range(a.size):
        total += a[j] * b[j]
    return total


@njit(types.void(A1, A2, i8, i8, i8, A1, A1, A2, A1, A2), **JIT)
def multi_innovation(y, h, first, size, length, omega, theta, factor, diagonal, path):
    """Multi-innovation recursive least squares, corrected (paper 004, eq 20 and 22).

    Rows y (M,), h (M, d) come in samples of `size`; rows before `first` only take part in windows.  After each sample
    the last `length` samples update P first, then theta += P Phi z with z = E, or, if omega (size,) is not
    empty, sin(omega E)/omega with omega E limited to +-pi/2.  theta, factor, diagonal are updated in place; path
    (M - first, d) is filled, every row of a sample with the coefficients after it.
    """
    d = theta.size
    f, v, gain, gradient = np.empty(d), np.empty(d), np.empty(d), np.empty(d)
    for end in range(first + size, y.size + 1, size):
        start = max(0, end - length * size)
        if omega.size == 0:
            for k in range(start, end):
                error = y[k] - _dot(h[k], theta)
                error *= update(h[k], 1.0, factor, diagonal, f, v, gain)
                theta += gain * error
        else:
            gradient[:] = 0.0
            for k in range(start, end):
                rate = omega[(k - start) % size]
                angle = rate * (y[k] - _dot(h[k], theta))
                z = np.sin(min(max(angle, -0.5 * np.pi), 0.5 * np.pi)) / rate
                gradient += z * h[k]
            for k in range(start, end):
                update(h[k], 1.0, factor, diagonal, f, v, gain)
            theta += factor.T @ (diagonal * (factor @ gradient))  # the factor is a unit triangle
        for k in range(end - size, end):
            path[k - first] = theta


@njit(types.void(A1, A2, f8, f8, i8, f8, A1, A2, A1, A2, A1), **JIT)
def iterative_learning(y, h, beta, share, most, tolerance, theta, factor, diagonal, path, counts):
    """FCI-LS, corrected: each row up to `most` times, every time followed by a step beta h e_hat/k, k its number.

    beta is limited to `share` of 2/|h|^2.  The repeats of a row end when one changes theta by less than `tolerance`
    standard errors: (d theta)'P^-1(d theta) = e (e - e_hat) is compared with the variance of the rows' errors so far,
    which starts at one.  counts (3,) counts repeats, rows and squared errors, and is updated.
    """
    d = theta.size
    f, v, direction = np.empty(d), np.empty(d), np.empty(d)
    for k in range(y.size):
        row = h[k]
        variance = (1.0 + counts[2]) / (1.0 + counts[1])
        counts[1] += 1.0
        square = _dot(row, row)
        gain = (min(beta, share * 2.0 / square) if square > 0.0 else 0.0) / counts[1]
        for repeat in range(most):
            counts[0] += 1.0
            error = y[k] - _dot(row, theta)
            left = error * update(row, 1.0, factor, diagonal, f, v, direction)
            change = error * (error - left)
            if repeat == 0:
                counts[2] += error * left
            theta += left * (direction + gain * row)
            if not abs(change) >= tolerance**2 * variance:
                break
        path[k] = theta


@njit(i8(A1, A2, f8, i8, f8, A1, A2, A1, A2), **JIT)
def iterative_learning_as_printed(y, h, beta, most, tolerance, theta, factor, diagonal, path):
    """FCI-LS (paper 002, eq 19-24): each row up to `most` times, every time followed by a step beta h e_hat.

    The repeats of a row end when one changes theta by less than `tolerance` (Euclidean norm).  Returns the number of
    repeats.
    """
    d = theta.size
    f, v, gain, before = np.empty(d), np.empty(d), np.empty(d), np.empty(d)
    repeats = 0
    for k in range(y.size):
        row = h[k]
        for _ in range(most):
            repeats += 1
            before[:] = theta
            error = y[k] - _dot(row, theta)
            error *= update(row, 1.0, factor, diagonal, f, v, gain)
            theta += gain * error
            theta += beta * (y[k] - _dot(row, theta)) * row
            if not np.sqrt(np.sum((theta - before) ** 2)) >= tolerance:
                break
        path[k] = theta
    return repeats
