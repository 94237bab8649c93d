"""Tukey's biweight: a redescending M-estimator, which gives gross outliers no weight at all."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from ..estimation.methods_only.regression.robust import biweight, huber_estimate, m_estimate
from ..estimation.methods_only.regression.weighted import RegressionRows
from ..estimation.methods_only.tuning.space import Real
from ..estimation.regression.schemes import check_scheme, regression_samples
from ..models.errors import BadInput
from .base import Method

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..estimation.results.fit import Fit
    from ..models.model import Model


class Tukey(Method):
    """Regression with Tukey's biweight, by iteratively reweighted least squares.

    Parameters
    ----------
    k : residual, in standard deviations, beyond which a row has no weight; 4.685 gives 95 % efficiency.
    scheme : difference scheme, see `helmbench.estimation.regression.schemes`.

    The loss is not convex: the iteration starts from Huber's estimate and keeps the scale of the residuals found
    there.  Beaton & Tukey 1974, Technometrics 16.
    """

    name = "tukey"
    title = "robust regression: Tukey's biweight, started from Huber's estimate"
    search_space: ClassVar = {"k": Real(2.5, 10.0, log=True)}

    def __init__(self, k: float = 4.685, scheme: str = "midpoint") -> None:
        self.k, self.scheme = k, scheme

    def check_options(self) -> None:
        super().check_options()
        check_scheme(self.scheme)
        if not self.k > 0.0:
            raise BadInput(f"k is {self.k!r}, a positive number is needed")

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        rows = RegressionRows(regression_samples(records, model, self.scheme), model)
        return m_estimate(rows, biweight(self.k), start=huber_estimate(rows))
