"""MI-RLS: recursive least squares that uses the last l innovations at once (paper 004, eq 20)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from ..estimation.methods_only.recursive.multi_innovation import MultiInnovationRule, check_length
from ..estimation.methods_only.tuning.space import Integer, Real
from .base import RecursiveMethod

if TYPE_CHECKING:
    from ..estimation.methods_only.recursive.recursion import UpdateRule
    from ..estimation.regression.samples import RegressionSamples


class MiRls(RecursiveMethod):
    """Multi-innovation recursive least squares.

    Parameters
    ----------
    length : samples l in the window.  Every row is used l times, so this is rls with an initial P l times as large:
        only a weaker prior.
    p0, theta0, prior, scheme : as in `rls`.
    """

    name = "mi-rls"
    title = "multi-innovation recursive least squares (paper 004)"
    search_space: ClassVar = {"length": Integer(1, 50, log=True), "p0": Real(1e-2, 1e12, log=True)}

    def __init__(
        self, length: int = 10, p0: float = 1e10, theta0=0.0, prior: str = "scaled", scheme: str | None = None
    ) -> None:
        self.length = length
        self.p0, self.theta0, self.prior, self.scheme = p0, theta0, prior, scheme

    def check_options(self) -> None:
        super().check_options()
        check_length(self.length)

    def update_rule(self, parts: Sequence[RegressionSamples]) -> UpdateRule:
        return MultiInnovationRule(int(self.length))
