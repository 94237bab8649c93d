"""Least-squares support vector regression (paper 003, eq 21-28, corrected).

    minimise |w|^2/2 + C/2 sum_i v_i e_i^2,   e_i = y_i - w phi(x_i) - b

With a linear kernel this is a ridge problem in d + 1 unknowns, solved here by QR: exactly the solution of the dual, at
a cost of d^2 n instead of n^3, and with all digits even where 1/C is below rounding in the dual.  Other kernels use the
dual, in the memory of one n by n matrix.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...numerics import factors

Array = NDArray[np.float64]
ROWS = 64
"""Rows of a kernel matrix that are computed at a time; with 10,000 columns they fit in a processor's cache."""


def primal(x: Array, y: Array, c: float, weights: Array | None = None, intercept: bool = True) -> tuple[Array, float]:
    """w (d,) and intercept of a linear kernel: ridge with unpenalised intercept by blocked QR.

    x (n, d), y (n,), weights (n,) >= 0.
    """
    d = x.shape[1]
    middle, level = np.zeros(d), 0.0
    if intercept:
        share = np.full(len(y), 1.0 / len(y)) if weights is None else weights / weights.sum()
        middle, level = share @ x, float(share @ y)
    factor = np.column_stack([np.eye(d) / np.sqrt(c), np.zeros(d)])
    for start in range(0, len(y), factors.BLOCK):
        cut = slice(start, start + factors.BLOCK)
        rows = np.column_stack([x[cut] - middle, y[cut] - level])
        if weights is not None:
            rows *= np.sqrt(weights[cut])[:, None]
        factor = factors.fold(factor, rows)
    coef = np.asarray(np.linalg.solve(factor[:d, :d], factor[:d, d]), float)
    return coef, level - float(middle @ coef)


def dual(gram: Array, y: Array, c: float, weights: Array | None = None, intercept: bool = True) -> tuple[Array, float]:
    """Multipliers alpha (n,) = C v e, and intercept, of any kernel: eq 25 by Cholesky with two right-hand sides.

    Of the matrix `gram` (n, n) the upper triangle counts, and is overwritten.
    """
    from scipy.linalg import cho_factor, cho_solve

    gram[np.diag_indices_from(gram)] += 1.0 / (c if weights is None else c * weights)
    lower = cho_factor(gram.T, lower=True, overwrite_a=True, check_finite=False)
    sides = np.asfortranarray(np.column_stack([np.ones(len(y)), y]))
    ones, values = np.asarray(cho_solve(lower, sides, overwrite_b=True, check_finite=False)).T
    level = float(values.sum() / ones.sum()) if intercept else 0.0
    return values - level * ones, level


def kernel_matrix(kind: str, a: Array, b: Array, gamma: float, degree: int, coef0: float, upper: bool = False) -> Array:
    """Kernel values (n, m) of rows a (n, d) and b (m, d): 'linear', 'rbf' exp(-gamma |a-b|^2) or 'poly'.

    Needs no more memory than the matrix itself.  With `upper` what lies below the diagonal is not set, as `dual` takes
    it.
    """
    gram, squares = np.empty((len(a), len(b))), np.einsum("ij,ij->i", b, b)
    for start in range(0, len(a), ROWS):
        cut, columns = slice(start, start + ROWS), slice(start if upper else 0, None)
        _fill(gram[cut, columns], kind, a[cut], b[columns], squares[columns], gamma, degree, coef0)
    return gram


def _fill(
    block: Array, kind: str, a: Array, b: Array, squares: Array, gamma: float, degree: int, coef0: float
) -> None:  # fmt: skip
    """Fill a block (k, m) of a kernel matrix: rows a (k, d) and b (m, d), whose squared lengths are `squares` (m,)."""
    np.matmul(a, b.T, out=block)
    if kind == "rbf":
        block *= -2.0
        block += np.einsum("ij,ij->i", a, a)[:, None]
        block += squares
        np.maximum(block, 0.0, out=block)
        block *= -gamma
        np.exp(block, out=block)
    elif kind == "poly":
        block *= gamma
        block += coef0
        np.power(block, degree, out=block)


def within_mad(values: Array, threshold: float = 3.0) -> NDArray[np.bool_]:
    """True (n,) where a value lies within `threshold` robust standard deviations (1.4826 MAD) of the median (eq 21)."""
    middle = np.median(values)
    distance = np.abs(values - middle)
    return distance <= threshold * 1.4826 * np.median(distance)


def pseudo_median(values: Array) -> float:
    """T' of eq 27: the mean of the medians of the second and the third quarter of the sorted values (n,)."""
    ordered = np.sort(values)
    n = len(ordered)
    second, third = ordered[n // 4 : n // 2], ordered[n // 2 : 3 * n // 4]
    if not len(second) or not len(third):
        return float(np.median(ordered))
    return float(np.mean([np.median(second), np.median(third)]))


def adaptive_weights(errors: Array, signed: bool = False) -> Array:
    """w = 2/(1 + exp(|e|/T')), in (0, 1], T' from the sorted |e|; `signed` as printed in eq 26-27, in [0, 2].

    Errors that are practically zero have weight 1.
    """
    from scipy.special import expit

    used = errors if signed else np.abs(errors)
    scale = pseudo_median(used)
    if abs(scale) <= 1e-300:
        return np.ones(len(errors))
    with np.errstate(over="ignore"):
        return 2.0 * expit(-used / scale)
