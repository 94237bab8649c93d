"""FCI-LS: recursive least squares with iterative learning and a P-type step (paper 002), corrected and as printed."""

from __future__ import annotations

from collections.abc import Sequence

from ..datasets.record import Record
from ..estimation.estimates.estimate import Estimate
from ..estimation.methods_only.recursive.iterative_learning import (
    BETA,
    PRINTED_TOLERANCE,
    TOLERANCE,
    LearningRule,
    PrintedLearning,
    printed_fit,
)
from ..estimation.methods_only.recursive.recursion import UpdateRule
from ..estimation.methods_only.tuning.space import Real
from ..estimation.regression.samples import RegressionSamples
from ..estimation.results.fit import Fit
from ..models.errors import BadInput, CannotFit
from ..models.model import Model
from .base import RecursiveMethod
from .options import NOT_NEGATIVE, option, whole


class FciLs(RecursiveMethod):
    """Fast convergent iterative learning least squares.

    Every row is used several times, each time followed by a step beta phi e, until the coefficients change by less
    than `tolerance`.  With beta = 0 this weights the row by the number of repeats, which grows with the innovation:
    the opposite of a robust method.  Corrected, the repeats end within `tolerance` standard errors and the step falls
    like 1/k.  Both matter for the first rows only, where there is something to gain; as rows come in, the estimate
    becomes that of `rls`.  As printed, neither decreases, and the last rows decide the estimate.

    """

    name = "fci-ls"
    title = "iterative-learning recursive least squares (paper 002)"
    variants = ("corrected", "as_printed")
    beta: float = option(
        BETA,
        "gain of the P-type step at the first row, in scaled columns; limited to 1/|phi|^2 (see "
        "`helmbench.estimation.methods_only.recursive.iterative_learning.SHARE`)",
        NOT_NEGATIVE,
        Real(1e-4, 1.0, log=True),
    )
    most: int = option(200, "most repeats N_max of a row", whole(1))
    tolerance: float | None = option(
        None,
        "sigma of eq 23: in standard errors (None: 3), as printed in the coefficients' units (None: 1e-3)",
        NOT_NEGATIVE,
        Real(0.1, 10.0, log=True),
    )
    p0 = 1e6
    degrees: bool = option(False, "as printed: angles and rates in degrees")
    variant: str = option(
        "corrected",
        "'corrected', or 'as_printed': the difference equation r(t+1) = a1 r(t) + ... with its columns as they are, "
        "P(0) = p0 I, all coefficients zero at first, beta constant and without bound.  Response models only.  It "
        "diverges for beta above 2/|phi|^2, and in radians the prior suppresses the cubic term",
    )

    def update_rule(self, parts: Sequence[RegressionSamples]) -> UpdateRule:
        return LearningRule(self.beta, self.most, TOLERANCE if self.tolerance is None else self.tolerance)

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        if self.variant == "corrected":
            return super().estimate(records, model)
        if self.scheme not in (None, "forward"):
            raise CannotFit("the printed form has forward differences")
        tolerance = PRINTED_TOLERANCE if self.tolerance is None else self.tolerance
        return printed_fit(records, model, PrintedLearning(self.beta, self.most, tolerance, self.p0, self.degrees))

    def partial_fit(self, chunk: Record, model: Model, scale_with: Sequence[Record] | None = None) -> Estimate | None:
        """As `RecursiveMethod.partial_fit`; BadInput for the printed variant, which only runs on whole records."""
        if self.variant == "as_printed":
            raise BadInput("the printed variant of fci-ls does not run online")
        return super().partial_fit(chunk, model, scale_with)
