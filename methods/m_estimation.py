"""M-estimators of a regression by iteratively reweighted least squares: what `huber` and `tukey` share."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, ClassVar, NamedTuple

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

Weight = Callable[[np.ndarray], np.ndarray]
"""Scaled residuals -> weights in [0, 1], of the same shape."""
EFFICIENT = 1.345
"""Huber's k with 95 % efficiency on Gaussian noise."""


def huber_weight(k: float) -> Weight:
    """Weights min(1, k/|e|) of scaled residuals."""
    return lambda e: k / np.maximum(np.abs(e), k)


def biweight(k: float) -> Weight:
    """Weights (1 - (e/k)^2)^2 of scaled residuals, zero beyond k."""
    return lambda e: np.maximum(1.0 - (e / k) ** 2, 0.0) ** 2


def huber_start(rows: Regression) -> tuple[factors.Solution, np.ndarray, int, bool]:
    """Huber's estimate from that of least squares, as `reweighted` returns it: where robust methods start."""
    return reweighted(rows, rows.start.coefficients, huber_weight(EFFICIENT))


class Efficiency(NamedTuple):
    """Means of psi(e)^2 and of psi'(e) over scaled residuals, and their number."""

    square: float
    slope: float
    n: int


def efficiency(residuals: np.ndarray, weight: Weight) -> Efficiency:
    """Of scaled residuals (N, k), psi(e) = e w(e); the slope by a central difference."""
    h = 1e-5
    high, low = residuals + h, residuals - h
    slope = (high * weight(high) - low * weight(low)) / (2.0 * h)
    square = (residuals * weight(residuals)) ** 2
    return Efficiency(float(square.mean()), float(slope.mean()), residuals.size)


def m_covariance(rows: Regression, scale: np.ndarray, c: np.ndarray, weight: Weight) -> np.ndarray:
    """Asymptotic covariance (p, p) of an M-estimate: E psi^2/(E psi')^2 times that of least squares."""
    found = efficiency(rows.residuals(c) / scale, weight)
    solution = factors.solve(rows.factor(1.0 / scale**2))
    free = max(found.n - solution.rank, 1)
    factor = found.square / max(found.slope, 1e-3) ** 2 * found.n / free
    return solution.covariance * factor


class MEstimator(Method):
    """Regression with a robust loss; `weighting` makes the weight function of k.

    A loss that is not convex (`convex` false) starts from Huber's estimate and keeps the spread found there; else the
    spread of each equation's residuals is 1.4826 times their median size, anew in each iteration.
    """

    weighting: ClassVar[Callable[[float], Weight]]
    convex: ClassVar[bool]

    def __init__(self, k: float, scheme: str) -> None:
        self.k, self.scheme = k, scheme

    def check_options(self) -> None:
        super().check_options()
        check_scheme(self.scheme)
        if not self.k > 0.0:
            raise BadInput(f"k is {self.k!r}, a positive number is needed")

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        rows = Regression(differences(records, model, self.scheme), model)
        start, scale, before = rows.start.coefficients, None, 0
        if not self.convex:
            first, scale, before, _ = huber_start(rows)
            start = first.x
        weight = type(self).weighting(self.k)
        solution, scale, count, converged = reweighted(rows, start, weight, scale)
        weights = weight(rows.residuals(solution.x) / scale)
        return Fit(
            solution.x,
            m_covariance(rows, scale, solution.x, weight),
            converged,
            "" if converged else f"not converged after {before + count} iterations",
            before + count,
            extra={"residual_sd": scale.tolist(), "rank": solution.rank, "outliers": float((weights < 0.5).mean())},
        )
