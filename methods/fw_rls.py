"""FW-RLS: recursive least squares with forgetting and weighting (paper 000), corrected and as printed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from ..estimation.methods_only.recursive.recursion import LeastSquaresRule, UpdateRule
from ..estimation.methods_only.tuning.space import Real
from ..models.errors import BadInput
from .base import RecursiveMethod

if TYPE_CHECKING:
    from ..estimation.regression.samples import RegressionSamples


class FwRls(RecursiveMethod):
    """Weighted recursive least squares with forgetting on the model's difference equations.

    Parameters
    ----------
    mu : forgetting factor of one sample, 0 < mu <= 1.
    weight : the constant weight L(k) > 0.  It acts only as p0 -> weight p0, that is as a weaker prior.
    p0, theta0, prior, scheme : as in `rls`.
    variant : 'corrected', or 'as_printed': eq 22 literally, which forgets the information but not the data and does
        not converge.
    """

    name = "fw-rls"
    title = "recursive least squares with forgetting and weighting (paper 000)"
    variants = ("corrected", "as_printed")
    search_space: ClassVar = {"mu": Real(0.95, 1.0), "weight": Real(1e-2, 1e4, log=True)}

    def __init__(
        self,
        mu: float = 0.999,
        weight: float = 20.0,
        p0: float = 1e10,
        theta0=0.0,
        prior: str = "scaled",
        scheme: str | None = None,
        variant: str = "corrected",
    ) -> None:
        self.p0, self.theta0, self.prior, self.scheme = p0, theta0, prior, scheme
        self.mu, self.weight, self.variant = mu, weight, variant

    def check_options(self) -> None:
        super().check_options()
        if not 0.0 < self.mu <= 1.0:
            raise BadInput(f"mu is {self.mu!r}, the forgetting factor lies in (0, 1]")
        if not self.weight > 0.0:
            raise BadInput(f"weight is {self.weight!r}, a positive number is needed")

    def update_rule(self, parts: Sequence[RegressionSamples]) -> UpdateRule:
        return LeastSquaresRule(self.mu, self.weight, as_printed=self.variant == "as_printed")
