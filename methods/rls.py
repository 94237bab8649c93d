"""Recursive least squares: plain, with forgetting (paper 000), and with several innovations at once (paper 004)."""

from __future__ import annotations

from collections.abc import Sequence

from ..estimation.methods_only.recursive.multi_innovation import MultiInnovationRule, one_step_share
from ..estimation.methods_only.recursive.recursion import LeastSquaresRule, UpdateRule
from ..estimation.methods_only.tuning.space import Integer, Real
from ..estimation.regression.samples import RegressionSamples
from .base import RecursiveMethod
from .options import POSITIVE, SHARE, number, option, whole

SEARCHED_PRIOR = option(searched=Real(1e-2, 1e12, log=True))
"""`p0`, tuned."""


class Rls(RecursiveMethod):
    """Plain recursive least squares."""

    name = "rls"
    title = "recursive least squares"
    p0: float = SEARCHED_PRIOR

    def update_rule(self, parts: Sequence[RegressionSamples]) -> UpdateRule:
        return LeastSquaresRule()


class FwRls(RecursiveMethod):
    """Weighted recursive least squares with forgetting on the model's difference equations."""

    name = "fw-rls"
    title = "recursive least squares with forgetting and weighting (paper 000)"
    variants = ("corrected", "as_printed")
    mu: float = option(0.999, "forgetting factor of one sample", SHARE, Real(0.95, 1.0))
    weight: float = option(
        20.0,
        "the constant weight L(k).  It acts only as p0 -> weight p0, that is as a weaker prior",
        POSITIVE,
        Real(1e-2, 1e4, log=True),
    )
    variant: str = option(
        "corrected",
        "'corrected', or 'as_printed': eq 22 literally, which forgets the information but not the data and does not "
        "converge",
    )

    def update_rule(self, parts: Sequence[RegressionSamples]) -> UpdateRule:
        return LeastSquaresRule(self.mu, self.weight, as_printed=self.variant == "as_printed")


class MiRls(RecursiveMethod):
    """Multi-innovation recursive least squares: the last l innovations are used at once (paper 004, eq 20)."""

    name = "mi-rls"
    title = "multi-innovation recursive least squares (paper 004)"
    length: int = option(
        10,
        "samples l in the window.  Every row is used l times, so this is rls with an initial P l times as large: only "
        "a weaker prior",
        whole(1),
        Integer(1, 50, log=True),
    )
    p0: float = SEARCHED_PRIOR

    def update_rule(self, parts: Sequence[RegressionSamples]) -> UpdateRule:
        return MultiInnovationRule(self.length)


class NmiRls(RecursiveMethod):
    """Nonlinear multi-innovation recursive least squares: innovations pass through a sine (paper 004)."""

    name = "nmi-rls"
    title = "nonlinear multi-innovation recursive least squares (paper 004)"
    variants = ("corrected", "as_printed")
    omega: float = option(
        1.0,
        "in z = sin(omega e)/omega, omega e limited to +-pi/2, where e is the error of the state predicted one sample "
        "ahead, in units of the state's root mean square.  Large innovations lose weight; towards 0 it is `mi-rls`, "
        "and at 1 nearly so",
        number("a positive number (0 would be mi-rls)", lambda value: value > 0.0),
        Real(0.03, 10.0, log=True),
    )
    length: int = option(10, "samples in the window, as in `mi-rls`", whole(1), Integer(1, 50, log=True))
    p0 = 1e6
    variant: str = option(
        "corrected",
        "'corrected', or 'as_printed': z = sin(omega e) of innovations in units of the left side's root mean square, "
        "and eq 23 with the plus sign that makes P grow; it diverges",
    )

    def update_rule(self, parts: Sequence[RegressionSamples]) -> UpdateRule:
        if self.variant == "as_printed":
            return MultiInnovationRule(self.length, (self.omega,), as_printed=True)
        return MultiInnovationRule(self.length, tuple(self.omega * one_step_share(parts)))
