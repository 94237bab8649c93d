"""Ridge regression, the penalty chosen by generalised cross-validation."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..estimation.methods_only.regression.weighted import RegressionRows
from ..estimation.methods_only.tuning.space import Real
from ..estimation.numerics.factors import spectrum
from ..estimation.results.fit import Fit
from .base import RegressionMethod
from .options import NOT_NEGATIVE, option

if TYPE_CHECKING:
    pass

GRID = np.logspace(-14.0, 2.0, 161)
"""Penalties tried, in units of the largest squared singular value of the scaled regression."""
DETERMINED = 1e-30
"""Squared singular value, relative to the largest, below which a direction has no information."""


class Ridge(RegressionMethod):
    """Least squares with a quadratic penalty on the coefficients of scaled columns.

    The covariance is the Bayesian posterior one, s^2 (A'A + penalty)^-1, which is finite where the records have no
    information; it does not count the bias from coefficients that are not zero.
    """

    name = "ridge"
    title = "ridge regression, penalty by generalised cross-validation"
    penalty: float | None = option(
        None,
        "in units of the largest squared singular value of the regression with columns of unit length; None chooses it "
        "by generalised cross-validation (Golub, Heath & Wahba 1979, Technometrics 21)",
        NOT_NEGATIVE,
        Real(1e-14, 1.0, log=True),
    )

    def solve(self, rows: RegressionRows) -> Fit:
        sd = rows.least_residual_sd()
        found = ridge(rows.factor(1.0 / sd**2), rows.n * rows.used.size, self.penalty)
        extra = {"penalty": found.penalty, "degrees_of_freedom": found.freedom, "residual_sd": sd.tolist()}
        return Fit(found.coefficients, found.covariance, extra=extra)


class RidgeSolution(NamedTuple):
    """Coefficients (p,), covariance (p, p), the penalty and the effective number of coefficients."""

    coefficients: np.ndarray
    covariance: np.ndarray
    penalty: float
    freedom: float


def ridge(factor: np.ndarray, n: int, penalty: float | None = None) -> RidgeSolution:
    """Ridge solution of the n rows behind a triangular factor of [A | b].

    For penalty None, the one with the least GCV = n RSS/(n - freedom)^2.
    """
    found = spectrum(factor)
    s, scores, v = found.s, found.scores, found.v
    square = s**2 / max(float(s[0]) ** 2, np.finfo(float).tiny)

    def residual_and_freedom(value: float) -> tuple[float, float]:
        shrinkage = value / (square + value) if value > 0.0 else np.where(square > DETERMINED, 0.0, 1.0)
        freedom = float((1.0 - shrinkage).sum())
        return found.outside + float(((shrinkage * scores) ** 2).sum()), freedom

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
    return RidgeSolution(coefficients, covariance, penalty, freedom)
