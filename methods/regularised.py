"""Least squares regularised by a penalty or by truncated singular values, how much by generalised cross-validation."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..estimation.methods_only.regression.weighted import RegressionRows
from ..estimation.methods_only.tuning.space import Choice, Real
from ..estimation.numerics import factors
from ..estimation.results.fit import Fit
from ..models.linear_algebra import svd
from .base import RegressionMethod, method
from .options import NOT_NEGATIVE, option, whole

GRID = np.logspace(-14.0, 2.0, 161)
"""Penalties tried, in units of the largest squared singular value of the scaled regression."""
DETERMINED = 1e-30
"""Squared singular value, relative to the largest, below which a ridge direction has no information."""
KNOWN = 1e-14
"""Singular value, relative to the largest, below which a truncated direction has none."""


@method("ridge", "ridge regression, penalty by generalised cross-validation", RegressionMethod)
def Ridge(
    rows: RegressionRows,
    penalty: float | None = option(
        None,
        "in units of the largest squared singular value of the regression with columns of unit length; None chooses it "
        "by generalised cross-validation (Golub, Heath & Wahba 1979, Technometrics 21)",
        NOT_NEGATIVE,
        Real(1e-14, 1.0, log=True),
    ),
) -> Fit:
    """Least squares with a quadratic penalty on the coefficients of scaled columns.

    The covariance is the Bayesian posterior one, s^2 (A'A + penalty)^-1, which is finite where the records have no
    information; it does not count the bias from coefficients that are not zero.
    """
    return _weighted(rows, ridge, penalty)


def ridge(factor: np.ndarray, n: int, penalty: float | None = None) -> Fit:
    """Ridge solution of the n rows behind a triangular factor of [A | b].

    For penalty None, the one with the least GCV = n RSS/(n - freedom)^2; `extra` has both.
    """
    s, scores, v, outside = _spectrum(factor)
    square = s**2 / max(float(s[0]) ** 2, np.finfo(float).tiny)

    def residual_and_freedom(value: float) -> tuple[float, float]:
        shrinkage = value / (square + value) if value > 0.0 else np.where(square > DETERMINED, 0.0, 1.0)
        freedom = float((1.0 - shrinkage).sum())
        return outside + float(((shrinkage * scores) ** 2).sum()), freedom

    def gcv(value: float) -> float:
        residual, freedom = residual_and_freedom(value)
        return residual / max(n - freedom, 1.0) ** 2

    if penalty is None:
        penalty = float(GRID[np.argmin([gcv(value) for value in GRID])])
    residual, freedom = residual_and_freedom(penalty)
    penalised = np.maximum((square + penalty) * float(s[0]) ** 2, 1e-300)
    inverse = np.where((square > DETERMINED) | (penalty > 0.0), 1.0 / penalised, 0.0)
    coefficients = v @ (inverse * s * scores)
    covariance = (v * (inverse * residual / max(n - freedom, 1.0))) @ v.T
    return Fit(coefficients, covariance, extra={"penalty": penalty, "degrees_of_freedom": freedom})


@method(
    "tsvd-ls",
    "least squares by truncated singular values, rank by cross-validation",
    RegressionMethod,
    scheme=option(searched=Choice("forward", "midpoint")),
)
def TsvdLs(
    rows: RegressionRows,
    rank: int | None = option(
        None,
        "singular values that are kept; None chooses it by generalised cross-validation (Golub, Heath & Wahba 1979)",
        whole(1),
    ),
) -> Fit:
    """Least squares by truncated singular value decomposition of the scaled columns.

    Directions that are left out are set to zero (Hansen 1987, BIT 27).  The covariance is that of the directions kept,
    and does not count what was set to zero.
    """
    return _weighted(rows, truncated, rank)


def truncated(factor: np.ndarray, n: int, rank: int | None = None) -> Fit:
    """Truncated solution of the n rows behind a triangular factor of [A | b].

    For rank None, the one with the least GCV = n RSS/(n - rank)^2; `extra` has it.
    """
    s, scores, v, outside = _spectrum(factor)
    most = int(np.sum(s > KNOWN * s[0]))
    residuals = outside + np.append(np.cumsum(scores[::-1] ** 2)[::-1], 0.0)
    if rank is None:
        ranks = np.arange(1, most + 1)
        rank = int(ranks[np.argmin(residuals[ranks] / np.maximum(n - ranks, 1.0) ** 2)])
    rank = min(rank, most)
    v, s, scores = v[:, :rank], s[:rank], scores[:rank]
    covariance = (v * (residuals[rank] / max(n - rank, 1.0) / s**2)) @ v.T
    return Fit(v @ (scores / s), covariance, extra={"rank": rank})


def _weighted(rows: RegressionRows, solve: Callable[..., Fit], option: float | None) -> Fit:
    """The solution of rows in units of the residuals of least squares."""
    sd = rows.least_residual_sd()
    found = solve(rows.factor(1.0 / sd**2), rows.n * rows.used.size, option)
    return found._replace(extra={**found.extra, "residual_sd": sd.tolist()})


def _spectrum(factor: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """The regression behind a triangular factor (m + 1, m + 1) of [A | b] by singular values, columns of unit length.

    Returns
    -------
    The values (m,), the left side along their directions (m,), the directions (m, m) in coefficients of the columns as
    they are, and the squares of the left side that no column explains.
    """
    a, b = factor[:, :-1], factor[:, -1]
    length = factors.column_lengths(a)
    u, s, vt = svd(a / length, full_matrices=False)
    scores = u.T @ b
    return s, scores, vt.T / length[:, None], max(float(b @ b - scores @ scores), 0.0)
