"""Huber's M-estimator: least squares for small residuals, least absolute values for large ones."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..models.errors import BadInput
from . import factors
from .base import Fit, Method
from .ls import check_scheme
from .regression import differences
from .weighted import Regression, reweighted

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model


def huber_weight(k: float) -> Callable[[np.ndarray], np.ndarray]:
    """Weights min(1, k/|e|) of scaled residuals."""
    return lambda e: k / np.maximum(np.abs(e), k)


class Efficiency(NamedTuple):
    """Means of psi(e)^2 and of psi'(e) over scaled residuals, and their number."""

    square: float
    slope: float
    n: int


def efficiency(residuals: np.ndarray, weight: Callable[[np.ndarray], np.ndarray]) -> Efficiency:
    """Of scaled residuals (N, k), psi(e) = e w(e); the slope by a central difference."""
    h = 1e-5
    high, low = residuals + h, residuals - h
    slope = (high * weight(high) - low * weight(low)) / (2.0 * h)
    square = (residuals * weight(residuals)) ** 2
    return Efficiency(float(square.mean()), float(slope.mean()), residuals.size)


def m_covariance(rows: Regression, scale: np.ndarray, c: np.ndarray, weight) -> np.ndarray:
    """Asymptotic covariance (p, p) of an M-estimate: E psi^2/(E psi')^2 times that of least squares."""
    found = efficiency(rows.residuals(c) / scale, weight)
    solution = factors.solve(rows.factor(1.0 / scale**2))
    free = max(found.n - solution.rank, 1)
    factor = found.square / max(found.slope, 1e-3) ** 2 * found.n / free
    return solution.covariance * factor


class Huber(Method):
    """Regression with Huber's loss, by iteratively reweighted least squares.

    Parameters
    ----------
    k : residual, in standard deviations, from which the loss is linear; 1.345 gives 95 % efficiency on Gaussian noise.
    scheme : difference scheme, see `regression`.

    The spread of each equation's residuals is 1.4826 times their median size, anew in each iteration.
    Huber 1964, Annals of Mathematical Statistics 35.
    """

    name = "huber"
    title = "robust regression: Huber's M-estimator"

    def __init__(self, k: float = 1.345, scheme: str = "midpoint") -> None:
        self.k, self.scheme = k, scheme

    def check_options(self) -> None:
        super().check_options()
        check_scheme(self.scheme)
        if not self.k > 0.0:
            raise BadInput(f"k is {self.k!r}, a positive number is needed")

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        rows = Regression(differences(records, model, self.scheme), model)
        weight = huber_weight(self.k)
        solution, scale, count, converged = reweighted(rows, rows.start.coefficients, weight)
        return robust_fit(rows, solution, scale, weight, count, converged)


def robust_fit(rows: Regression, solution: factors.Solution, scale, weight, count: int, converged: bool) -> Fit:
    """A `Fit` from the end of `reweighted`, with the share of rows that lost more than half their weight."""
    weights = weight(rows.residuals(solution.x) / scale)
    return Fit(
        solution.x,
        m_covariance(rows, scale, solution.x, weight),
        converged,
        "" if converged else f"not converged after {count} iterations",
        count,
        extra={"residual_sd": scale.tolist(), "rank": solution.rank, "outliers": float((weights < 0.5).mean())},
    )
