"""Huber's M-estimator: least squares for small residuals, least absolute values for large ones."""

from __future__ import annotations

from typing import ClassVar

from .m_estimation import EFFICIENT, MEstimator, huber_weight
from .tuning.space import Real


class Huber(MEstimator):
    """Regression with Huber's loss, by iteratively reweighted least squares.

    Parameters
    ----------
    k : residual, in standard deviations, from which the loss is linear; 1.345 gives 95 % efficiency on Gaussian noise.
    scheme : difference scheme, see `regression`.

    The loss is convex, so the estimate is unique, but an outlier keeps the pull of a residual of k: long bursts of one
    sign bias it at any k, where `tukey` and `lts` reject them.  Huber 1964, Annals of Mathematical Statistics 35.
    """

    name = "huber"
    title = "robust regression: Huber's M-estimator"
    search_space: ClassVar = {"k": Real(0.3, 3.0, log=True)}
    weighting = staticmethod(huber_weight)
    convex = True

    def __init__(self, k: float = EFFICIENT, scheme: str = "midpoint") -> None:
        super().__init__(k, scheme)
