"""Plain recursive least squares."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from ..estimation.methods_only.recursive.recursion import LeastSquaresRule, UpdateRule
from ..estimation.methods_only.tuning.space import Real
from .base import RecursiveMethod

if TYPE_CHECKING:
    from ..estimation.regression.samples import RegressionSamples


class Rls(RecursiveMethod):
    """Plain recursive least squares.

    Parameters
    ----------
    p0 : initial P = p0 I, in the coordinates that `prior` names.
    theta0 : initial coefficients, one number for all or (p,) numbers.
    prior : 'scaled' (every regressor column and equation of unit root mean square) or 'physical' (the model's
        coordinates and unscaled rows, as in paper 000).
    scheme : difference scheme, see `helmbench.estimation.regression.schemes`; None: of central ('midpoint', the
        trapezoid for first-order equations) and forward differences those whose fits follow left-out windows of the
        records best, in a stream central ones; for printed variants the papers' forward ones.

    Several records are gone through one after the other; P and the coefficients are carried over.
    """

    name = "rls"
    title = "recursive least squares"
    search_space: ClassVar = {"p0": Real(1e-2, 1e12, log=True)}

    def __init__(self, p0: float = 1e10, theta0=0.0, prior: str = "scaled", scheme: str | None = None) -> None:
        self.p0, self.theta0, self.prior, self.scheme = p0, theta0, prior, scheme

    def update_rule(self, parts: Sequence[RegressionSamples]) -> UpdateRule:
        return LeastSquaresRule()
