"""Least squares on the leading singular values of the regression."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..estimation.methods_only.regression.weighted import RegressionRows
from ..estimation.methods_only.tuning.space import Choice
from ..estimation.numerics.factors import spectrum
from ..estimation.results.fit import Fit
from .base import RegressionMethod
from .options import option, whole

if TYPE_CHECKING:
    pass

DETERMINED = 1e-14
"""Singular value, relative to the largest, below which a direction has no information."""


class TruncatedSolution(NamedTuple):
    """Coefficients (p,), their covariance (p, p), and how many singular values they rest on."""

    coefficients: np.ndarray
    covariance: np.ndarray
    rank: int


class TsvdLs(RegressionMethod):
    """Least squares by truncated singular value decomposition of the scaled columns.

    Directions that are left out are set to zero (Hansen 1987, BIT 27).  The covariance is that of the directions kept,
    and does not count what was set to zero.
    """

    name = "tsvd-ls"
    title = "least squares by truncated singular values, rank by cross-validation"
    rank: int | None = option(
        None,
        "singular values that are kept; None chooses it by generalised cross-validation (Golub, Heath & Wahba 1979)",
        whole(1),
    )
    scheme: str = option(searched=Choice("forward", "midpoint"))

    def solve(self, rows: RegressionRows) -> Fit:
        sd = rows.least_residual_sd()
        found = truncated(rows.factor(1.0 / sd**2), rows.n * rows.used.size, self.rank)
        extra = {"rank": found.rank, "residual_sd": sd.tolist()}
        return Fit(found.coefficients, found.covariance, extra=extra)


def truncated(factor: np.ndarray, n: int, rank: int | None = None) -> TruncatedSolution:
    """Truncated solution of the n rows behind a triangular factor of [A | b].

    For rank None, the one with the least GCV = n RSS/(n - rank)^2.
    """
    found = spectrum(factor)
    most = int(np.sum(found.s > DETERMINED * found.s[0]))
    residuals = found.outside + np.append(np.cumsum(found.scores[::-1] ** 2)[::-1], 0.0)
    if rank is None:
        ranks = np.arange(1, most + 1)
        rank = int(ranks[np.argmin(residuals[ranks] / np.maximum(n - ranks, 1.0) ** 2)])
    rank = min(rank, most)
    v, s, scores = found.v[:, :rank], found.s[:rank], found.scores[:rank]
    covariance = (v * (residuals[rank] / max(n - rank, 1.0) / s**2)) @ v.T
    return TruncatedSolution(v @ (scores / s), covariance, rank)
