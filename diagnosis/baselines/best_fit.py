"""Diagnoser `best-fit`: output error without a test and without a penalty."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..causes.registry import testable
from ..prepared import prepared
from ..registry import Diagnoser
from .conclusion import Chosen, conclude
from .output_error import FreeRuns, cost, rms
from .residual_bic import fit_cause

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model
    from ..options import Options
    from ..result import Diagnosis


class BestFit(Diagnoser):
    """Every cause of the bank is fitted by least squares to the free runs, and the one that fits best is named.

    It always names one: no test says whether anything is wrong, and nothing is charged for further parameters.
    """

    name = "best-fit"
    title = "naive: free-run output error, the cause that fits best, without a test"

    def diagnose(
        self, model: Model, train: Sequence[Record], held_out: Sequence[Record], options: Options
    ) -> Diagnosis:
        """Fit every cause to the free runs and name the one of the least error."""
        clock = time.perf_counter(), time.process_time()
        options = options.checked(model)
        train, held_out = prepared(train, model, options), prepared(held_out, model, options)
        runs = FreeRuns(model, train)
        base, only = runs.base(), options.causes()
        weight = 1.0 / rms(base.residuals)
        bank, _ = testable(runs.est)
        fits = [Chosen(c, *fit_cause(runs, base, c, v)) for c, v in bank.items() if (not only or c in only) and v[0]]
        chosen = sorted(fits, key=lambda one: cost(one.fit.residuals, weight))[:1]
        reason = "the least error of free runs of the training records"
        return conclude(runs, held_out, chosen, "named" if chosen else "adequate", reason, options, clock)
