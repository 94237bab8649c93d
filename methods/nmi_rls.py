"""NMI-RLS: multi-innovation recursive least squares with sine-shaped innovations (paper 004), corrected and printed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from ..estimation.methods_only.recursive.multi_innovation import MultiInnovationRule, check_length, one_step_share
from ..estimation.methods_only.tuning.space import Integer, Real
from ..models.errors import BadInput
from .base import RecursiveMethod

if TYPE_CHECKING:
    from ..estimation.methods_only.recursive.recursion import UpdateRule
    from ..estimation.regression.samples import RegressionSamples


class NmiRls(RecursiveMethod):
    """Nonlinear multi-innovation recursive least squares.

    Parameters
    ----------
    omega : in z = sin(omega e)/omega, omega e limited to +-pi/2, where e is the error of the state predicted one
        sample ahead, in units of the state's root mean square.  Large innovations lose weight; towards 0 it is
        `mi-rls`, and at 1 nearly so.
    length, p0, theta0, prior, scheme : as in `mi-rls`.
    variant : 'corrected', or 'as_printed': z = sin(omega e) of innovations in units of the left side's root mean
        square, and eq 23 with the plus sign that makes P grow; it diverges.
    """

    name = "nmi-rls"
    title = "nonlinear multi-innovation recursive least squares (paper 004)"
    variants = ("corrected", "as_printed")
    search_space: ClassVar = {"omega": Real(0.03, 10.0, log=True), "length": Integer(1, 50, log=True)}

    def __init__(
        self,
        omega: float = 1.0,
        length: int = 10,
        p0: float = 1e6,
        theta0=0.0,
        prior: str = "scaled",
        scheme: str | None = None,
        variant: str = "corrected",
    ) -> None:
        self.omega, self.length, self.variant = omega, length, variant
        self.p0, self.theta0, self.prior, self.scheme = p0, theta0, prior, scheme

    def check_options(self) -> None:
        super().check_options()
        check_length(self.length)
        if not self.omega > 0.0:
            raise BadInput(f"omega is {self.omega!r}, a positive number is needed (0 would be mi-rls)")

    def update_rule(self, parts: Sequence[RegressionSamples]) -> UpdateRule:
        if self.variant == "as_printed":
            return MultiInnovationRule(int(self.length), (self.omega,), as_printed=True)
        return MultiInnovationRule(int(self.length), tuple(self.omega * one_step_share(parts)))
