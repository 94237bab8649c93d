"""Ridge regression, the penalty chosen by generalised cross-validation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..models.errors import BadInput
from .base import Fit, Method
from .ls import check_scheme
from .regression import differences
from .tuning.space import Real
from .weighted import Regression

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model

GRID = np.logspace(-14.0, 2.0, 161)
"""Penalties tried, in units of the largest squared singular value of the scaled regression."""


class Ridge(Method):
    """Least squares with a quadratic penalty on coefficients in scaled columns.

    Parameters
    ----------
    penalty : in units of the largest squared singular value of the regression with columns of unit length; None
        chooses it by generalised cross-validation (Golub, Heath & Wahba 1979, Technometrics 21).
    scheme : difference scheme, see `regression`.

    The covariance is that of the Bayesian reading, s^2 (A'A + penalty)^-1, and finite where the records say nothing;
    it does not count the bias from coefficients that are not zero.
    """

    name = "ridge"
    title = "ridge regression, penalty by generalised cross-validation"
    search_space: ClassVar = {"penalty": Real(1e-14, 1.0, log=True)}

    def __init__(self, penalty: float | None = None, scheme: str = "midpoint") -> None:
        self.penalty, self.scheme = penalty, scheme

    def check_options(self) -> None:
        super().check_options()
        check_scheme(self.scheme)
        if self.penalty is not None and not self.penalty >= 0.0:
            raise BadInput(f"penalty is {self.penalty!r}, a number >= 0 is needed")

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        rows = Regression(differences(records, model, self.scheme), model)
        sd = np.maximum(rows.start.residual_sd[rows.used], 1e-13 * rows.left)
        factor = rows.factor(1.0 / sd**2)
        c, covariance, penalty, freedom = ridge(factor, rows.n * rows.used.size, self.penalty)
        extra = {"penalty": penalty, "degrees_of_freedom": freedom, "residual_sd": sd.tolist()}
        return Fit(c, covariance, extra=extra)


def ridge(factor: np.ndarray, n: int, penalty: float | None = None):
    """Ridge solution of the n rows behind a triangular factor of [A | b].

    Returns
    -------
    Coefficients (p,), covariance (p, p), the penalty and the effective number of coefficients.  For penalty None,
    the one with the least GCV = n RSS/(n - freedom)^2.
    """
    a, b = factor[:, :-1], factor[:, -1]
    length = np.linalg.norm(a, axis=0)
    length = np.where(length > 0.0, length, 1.0)
    u, s, vt = np.linalg.svd(a / length, full_matrices=False)
    scores = u.T @ b
    outside = max(float(b @ b - scores @ scores), 0.0)
    square = s**2 / max(float(s[0]) ** 2, np.finfo(float).tiny)

    def criteria(value: float) -> tuple[float, float]:
        shrunk = value / (square + value) if value > 0.0 else np.where(square > 1e-30, 0.0, 1.0)
        freedom = float((1.0 - shrunk).sum())
        return outside + float(((shrunk * scores) ** 2).sum()), freedom

    def gcv(value: float) -> float:
        rest, freedom = criteria(value)
        return rest / max(n - freedom, 1.0) ** 2

    if penalty is None:
        penalty = float(GRID[np.argmin([gcv(value) for value in GRID])])
    rest, freedom = criteria(penalty)
    scale = float(s[0]) ** 2
    known = square > 1e-30
    inverse = np.where(known | (penalty > 0.0), 1.0 / np.maximum((square + penalty) * scale, 1e-300), 0.0)
    v = vt.T / length[:, None]
    c = v @ (inverse * s * scores)
    covariance = (v * (inverse * rest / max(n - freedom, 1.0))) @ v.T
    return c, covariance, penalty, freedom
