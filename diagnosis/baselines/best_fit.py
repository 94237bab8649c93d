"""Diagnoser `best-fit`: output error without a test and without a penalty."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from .conclusion import Chosen, OfFreeRuns, fittable
from .output_error import FilterRuns, cost, rms
from .residual_bic import fit_cause

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model
    from ..options import Options


class BestFit(OfFreeRuns):
    """Every cause of the bank is fitted by least squares to the free runs, and the one that fits best is named.

    It always names one: no test says whether anything is wrong, and nothing is charged for further parameters.
    """

    name = "best-fit"
    title = "naive: free-run output error, the cause that fits best, without a test"

    def choose(
        self, runs: FilterRuns, model: Model, train: Sequence[Record], options: Options
    ) -> tuple[Sequence[Chosen], str, str]:
        """RunFit every cause to the free runs and name the one of the least error."""
        base = runs.base()
        weight = 1.0 / rms(base.residuals)
        fits = [Chosen(c, *fit_cause(runs, base, c, v)) for c, v in fittable(runs, options.causes()).items()]
        chosen = sorted(fits, key=lambda one: cost(one.fit.residuals, weight))[:1]
        return chosen, "named" if chosen else "adequate", "the least error of free runs of the training records"
