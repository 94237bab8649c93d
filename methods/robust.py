"""M-estimators: least squares whose rows lose weight as their residuals grow."""

from __future__ import annotations

from ..estimation.methods_only.regression.robust import EFFICIENT, biweight, huber_estimate, huber_weight, m_estimate
from ..estimation.methods_only.regression.weighted import RegressionRows
from ..estimation.methods_only.tuning.space import Real
from ..estimation.results.fit import Fit
from .base import RegressionMethod
from .options import POSITIVE, option


class Huber(RegressionMethod):
    """Regression with Huber's loss, by iteratively reweighted least squares.

    The loss is convex, so the estimate is unique.  An outlier keeps the influence of a residual of k, so long bursts
    of outliers of one sign bias the estimate at any k; `tukey` and `lts` reject them.  The scale of each equation's
    residuals is 1.4826 times their median size, computed again in each iteration.  Huber 1964, Annals of Mathematical
    Statistics 35.
    """

    name = "huber"
    title = "robust regression: Huber's M-estimator"
    k: float = option(
        EFFICIENT,
        "residual, in standard deviations, from which the loss is linear; 1.345: 95 % efficiency on Gaussian noise",
        POSITIVE,
        Real(0.3, 3.0, log=True),
    )

    def solve(self, rows: RegressionRows) -> Fit:
        return m_estimate(rows, huber_weight(self.k))


class Tukey(RegressionMethod):
    """Regression with Tukey's biweight, by iteratively reweighted least squares.

    The loss is not convex: the iteration starts from Huber's estimate and keeps the scale of the residuals found
    there.  Gross outliers have no weight at all.  Beaton & Tukey 1974, Technometrics 16.
    """

    name = "tukey"
    title = "robust regression: Tukey's biweight, started from Huber's estimate"
    k: float = option(
        4.685,
        "residual, in standard deviations, beyond which a row has no weight; 4.685 gives 95 % efficiency",
        POSITIVE,
        Real(2.5, 10.0, log=True),
    )

    def solve(self, rows: RegressionRows) -> Fit:
        return m_estimate(rows, biweight(self.k), start=huber_estimate(rows))
