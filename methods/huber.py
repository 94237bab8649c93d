"""Huber's M-estimator: least squares for small residuals, least absolute values for large ones."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from ..estimation.methods_only.regression.robust import EFFICIENT, huber_weight, m_estimate
from ..estimation.methods_only.regression.weighted import RegressionRows
from ..estimation.methods_only.tuning.space import Real
from ..estimation.regression.schemes import check_scheme, regression_samples
from ..models.errors import BadInput
from .base import Method

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..estimation.results.fit import Fit
    from ..models.model import Model


class Huber(Method):
    """Regression with Huber's loss, by iteratively reweighted least squares.

    Parameters
    ----------
    k : residual, in standard deviations, from which the loss is linear; 1.345 gives 95 % efficiency on Gaussian noise.
    scheme : difference scheme, see `helmbench.estimation.regression.schemes`.

    The loss is convex, so the estimate is unique.  An outlier keeps the influence of a residual of k, so long bursts
    of outliers of one sign bias the estimate at any k; `tukey` and `lts` reject them.  The scale of each equation's
    residuals is 1.4826 times their median size, computed again in each iteration.  Huber 1964, Annals of Mathematical
    Statistics 35.
    """

    name = "huber"
    title = "robust regression: Huber's M-estimator"
    search_space: ClassVar = {"k": Real(0.3, 3.0, log=True)}

    def __init__(self, k: float = EFFICIENT, scheme: str = "midpoint") -> None:
        self.k, self.scheme = k, scheme

    def check_options(self) -> None:
        super().check_options()
        check_scheme(self.scheme)
        if not self.k > 0.0:
            raise BadInput(f"k is {self.k!r}, a positive number is needed")

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        rows = RegressionRows(regression_samples(records, model, self.scheme), model)
        return m_estimate(rows, huber_weight(self.k))
