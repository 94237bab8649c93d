"""Tukey's biweight: a redescending M-estimator, which gives gross outliers no weight at all."""

from __future__ import annotations

from typing import ClassVar

from .m_estimation import MEstimator, biweight
from .tuning.space import Real


class Tukey(MEstimator):
    """Regression with Tukey's biweight, by iteratively reweighted least squares.

    Parameters
    ----------
    k : residual, in standard deviations, beyond which a row has no weight; 4.685 gives 95 % efficiency.
    scheme : difference scheme, see `regression`.

    The loss is not convex: it starts from Huber's estimate.  Beaton & Tukey 1974, Technometrics 16.
    """

    name = "tukey"
    title = "robust regression: Tukey's biweight, started from Huber's estimate"
    search_space: ClassVar = {"k": Real(2.5, 10.0, log=True)}
    weighting = staticmethod(biweight)
    convex = False

    def __init__(self, k: float = 4.685, scheme: str = "midpoint") -> None:
        super().__init__(k, scheme)
