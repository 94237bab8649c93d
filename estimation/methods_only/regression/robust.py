"""M-estimators of a regression by iteratively reweighted least squares.

Sources: Huber 1964, Annals of Mathematical Statistics 35; Beaton & Tukey 1974, Technometrics 16.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...numerics import factors
from ...results.fit import Fit
from .weighted import RegressionRows, Reweighted, reweighted

Weight = Callable[[np.ndarray], np.ndarray]
"""Scaled residuals -> weights in [0, 1], of the same shape."""
EFFICIENT = 1.345
"""Huber's k with 95 % efficiency on Gaussian noise."""
OUTLIER = 0.5
"""Weight below which a residual counts as an outlier."""


def huber_weight(k: float) -> Weight:
    """Weights min(1, k/|e|) of scaled residuals e."""
    return lambda e: k / np.maximum(np.abs(e), k)


def biweight(k: float) -> Weight:
    """Tukey's weights (1 - (e/k)^2)^2 of scaled residuals e, zero beyond k."""
    return lambda e: np.maximum(1.0 - (e / k) ** 2, 0.0) ** 2


def huber_estimate(rows: RegressionRows) -> Reweighted:
    """Huber's estimate from that of least squares: the start of the other robust methods."""
    return reweighted(rows, rows.start.coefficients, huber_weight(EFFICIENT))


def m_estimate(rows: RegressionRows, weight: Weight, start: Reweighted | None = None) -> Fit:
    """M-estimate with its asymptotic covariance.

    Parameters
    ----------
    weight : scaled residuals -> weights.
    start : estimate that a loss with several minima starts from, whose scale of the residuals is kept; None starts
        from least squares and computes the scale again in each iteration.
    """
    if start is None:
        found, before = reweighted(rows, rows.start.coefficients, weight), 0
    else:
        found, before = reweighted(rows, start.solution.x, weight, start.scale), start.n_iterations
    solution, count = found.solution, before + found.n_iterations
    weights = weight(rows.residuals(solution.x) / found.scale)
    return Fit(
        solution.x,
        m_covariance(rows, found.scale, solution.x, weight),
        found.converged,
        "" if found.converged else f"not converged after {count} iterations",
        count,
        extra={
            "residual_sd": found.scale.tolist(),
            "rank": solution.rank,
            "outliers": float((weights < OUTLIER).mean()),
        },
    )


def m_covariance(rows: RegressionRows, scale: np.ndarray, c: np.ndarray, weight: Weight) -> np.ndarray:
    """Asymptotic covariance (p, p) of an M-estimate c (p,): E psi^2/(E psi')^2 times that of least squares.

    scale (k,) is the spread of the residuals of each equation.
    """
    residuals = rows.residuals(c) / scale
    square, slope = psi_moments(residuals, weight)
    solution = factors.solve(rows.factor(1.0 / scale**2))
    factor = square / max(slope, 1e-3) ** 2 * residuals.size / max(residuals.size - solution.rank, 1)
    return solution.covariance * factor


def psi_moments(residuals: np.ndarray, weight: Weight) -> tuple[float, float]:
    """Means of psi(e)^2 and psi'(e) over scaled residuals (N, k), psi(e) = e w(e); psi' by a central difference."""
    h = 1e-5
    high, low = residuals + h, residuals - h
    slope = (high * weight(high) - low * weight(low)) / (2.0 * h)
    square = (residuals * weight(residuals)) ** 2
    return float(square.mean()), float(slope.mean())
