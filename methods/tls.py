"""Total least squares: errors in the regressors as well as on the left side."""

from __future__ import annotations

import numpy as np

from ..estimation.methods_only.regression.weighted import RegressionRows, mad
from ..estimation.methods_only.tuning.space import Choice
from ..estimation.numerics import factors
from ..estimation.results.fit import Fit
from ..models.errors import FitFailed
from ..models.linear_algebra import svd
from .base import RegressionMethod, method
from .options import option, words

SCALINGS = ("noise", "unit")
EXACT = 1e-4
"""Noise of a column, relative to its root mean square, below which the column counts as exact."""


@method(
    "tls", "scaled total least squares (SVD)", RegressionMethod, scheme=option(searched=Choice("forward", "midpoint"))
)
def Tls(
    rows: RegressionRows,
    scaling: str = option(
        "noise",
        "'noise' (each column in units of its own white noise, estimated from its third differences; columns without "
        "visible noise, such as the rudder's, are exact) or 'unit' (all columns of unit length, none exact)",
        words("scaling", SCALINGS),
        Choice(*SCALINGS),
    ),
) -> Fit:
    """Scaled total least squares by singular values, mixed with ordinary least squares for exact columns.

    Golub & Van Loan 1980; exact columns as in Van Huffel & Vandewalle 1991, section 3.5.  The equations of a 3-DOF
    model are solved one by one where they share no coefficient.  With nearly collinear regressors the solution has
    very large errors (`extra['gap']` near 1); this is a property of the method, not a failure.
    """
    sd = rows.least_residual_sd()
    c, covariance, gaps = np.zeros(rows.p), np.diag(np.full(rows.p, np.inf)), []
    for group in _groups(rows):
        weight = np.zeros(rows.used.size)
        weight[group] = 1.0 / sd[group] ** 2
        factor = rows.factor(weight)
        columns = np.flatnonzero(np.any(factor[:, :-1] != 0.0, axis=0))
        noise = _column_noise(rows, group, columns) if scaling == "noise" else None
        x, spread, gap = total(np.column_stack([factor[:, columns], factor[:, -1]]), rows.n * len(group), noise)
        c[columns] = x
        covariance[np.ix_(columns, columns)] = spread
        gaps.append(gap)
    if not np.isfinite(c).all():
        raise FitFailed("total least squares has no finite solution")
    return Fit(c, covariance, extra={"gap": gaps})


def _groups(rows: RegressionRows) -> list[list[int]]:
    """Groups of equations (indices into `rows.used`) that share coefficients."""
    from scipy.sparse.csgraph import connected_components

    uses = np.any(rows.equations[rows.used][:, :, :-1] != 0.0, axis=1).astype(int)
    count, labels = connected_components(uses @ uses.T, directed=False)
    return [np.flatnonzero(labels == label).tolist() for label in range(count)]


def _column_noise(rows: RegressionRows, group: list[int], columns: np.ndarray) -> np.ndarray:
    """White noise (m + 1,) of the columns and the left side of a group's weighted rows; 0 where none is visible."""
    weight = 1.0 / rows.least_residual_sd()[group]
    third, square, n, n_third = 0.0, 0.0, 0, 0
    for _, y, phi in rows.blocks():
        for e, w in zip(group, weight, strict=True):
            block = w * np.column_stack([phi[:, e][:, columns], y[:, e]])
            differences = np.diff(block, 3, axis=0)
            third, square = third + _robust_squares(differences), square + (block**2).sum(axis=0)
            n, n_third = n + len(block), n_third + len(differences)
    sd = np.sqrt(third / max(n_third, 1) / 20.0)
    rms = np.sqrt(square / n)
    sd = np.where(sd > EXACT * rms, sd, 0.0)
    sd[-1] = max(sd[-1], EXACT * rms[-1])
    return sd


def _robust_squares(differences: np.ndarray) -> np.ndarray:
    """Sum of squares (m,) of third differences (N, m), from their median size: kinks do not count."""
    if not len(differences):
        return np.zeros(differences.shape[1])
    return len(differences) * mad(differences) ** 2


def total(factor: np.ndarray, n: int, noise: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray, float]:
    """Total least squares of [A | b] given by a triangular factor of its n rows.

    Parameters
    ----------
    noise : (m + 1,) standard deviation of the errors in each column of [A | b]; zero: the column is exact.  None:
        proportional to the lengths of the columns.

    Exact columns are eliminated by orthogonal decomposition.  In units of the noise, the right singular vector of the
    smallest singular value of the remaining columns is proportional to (x, -1).

    Raises
    ------
    FitFailed : the regressors are linearly dependent within their noise.
    """
    m = factor.shape[1] - 1
    length = factors.column_lengths(factor)
    noise = length if noise is None else noise
    exact, noisy = np.flatnonzero(noise[:m] == 0.0), np.flatnonzero(noise[:m] > 0.0)
    order = np.concatenate([exact, noisy, [m]])
    unit = np.where(noise > 0.0, noise, length)
    triangle = np.asarray(np.linalg.qr(factor[:, order] / unit[order], mode="r"), float)
    rest = triangle[exact.size :, exact.size :]
    _, s, vt = svd(rest, full_matrices=True)
    vector = vt[-1]
    if abs(vector[-1]) < 1e-14:
        raise FitFailed("total least squares has no solution: the regressors are linearly dependent within their noise")
    x = np.zeros(m)
    x[noisy] = -vector[:-1] / vector[-1]
    right = triangle[: exact.size, -1] - triangle[: exact.size, exact.size : -1] @ x[noisy]
    if exact.size:
        x[exact] = factors.solve(np.column_stack([triangle[: exact.size, : exact.size], right])).x
    least = float(s[-1]) if len(s) == rest.shape[1] else 0.0
    alone = svd(rest[:, :-1], compute_uv=False)[-1] if noisy.size else np.inf
    covariance = _covariance(triangle, exact.size, float((x[noisy] ** 2).sum()), least, n)
    back = np.empty(m)
    back[order[:-1]] = unit[m] / unit[order[:-1]]
    inverse = np.argsort(order[:-1])
    return x * back, covariance[np.ix_(inverse, inverse)] * np.outer(back, back), least / float(alone)


def _covariance(triangle: np.ndarray, exact: int, size: float, least: float, n: int) -> np.ndarray:
    """First-order covariance (m, m) in scaled columns: s^2 (1 + |x|^2) (A'A - n s^2 I)^-1, s^2 the estimated noise.

    The identity matrix and `size`, |x|^2, only count columns after the first `exact` ones.
    """
    m = triangle.shape[1] - 1
    variance = least**2 / max(n - m, 1)
    _, s, vt = svd(triangle[:, :-1], full_matrices=False)
    middle = (vt.T * s**2) @ vt - np.diag(n * variance * (np.arange(m) >= exact))
    values, vectors = np.linalg.eigh((middle + middle.T) / 2.0)
    values = np.maximum(values, 1e-14 * s[0] ** 2)
    return variance * (1.0 + size) * (vectors / values) @ vectors.T
