"""Tukey's biweight: a redescending M-estimator, which gives gross outliers no weight at all."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..models.errors import BadInput
from .base import Fit, Method
from .huber import huber_weight, robust_fit
from .ls import check_scheme
from .regression import differences
from .weighted import Regression, reweighted

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model


def biweight(k: float) -> Callable[[np.ndarray], np.ndarray]:
    """Weights (1 - (e/k)^2)^2 of scaled residuals, zero beyond k."""
    return lambda e: np.maximum(1.0 - (e / k) ** 2, 0.0) ** 2


class Tukey(Method):
    """Regression with Tukey's biweight, by iteratively reweighted least squares.

    Parameters
    ----------
    k : residual, in standard deviations, beyond which a row has no weight; 4.685 gives 95 % efficiency.
    scheme : difference scheme, see `regression`.

    The loss is not convex: it starts from Huber's estimate and keeps the spread found there.
    Beaton & Tukey 1974, Technometrics 16.
    """

    name = "tukey"
    title = "robust regression: Tukey's biweight, started from Huber's estimate"

    def __init__(self, k: float = 4.685, scheme: str = "midpoint") -> None:
        self.k, self.scheme = k, scheme

    def check_options(self) -> None:
        super().check_options()
        check_scheme(self.scheme)
        if not self.k > 0.0:
            raise BadInput(f"k is {self.k!r}, a positive number is needed")

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        rows = Regression(differences(records, model, self.scheme), model)
        first, scale, count, _ = reweighted(rows, rows.start.coefficients, huber_weight(1.345))
        weight = biweight(self.k)
        solution, scale, more, converged = reweighted(rows, first.x, weight, scale)
        return robust_fit(rows, solution, scale, weight, count + more, converged)
