"""Least-squares support vector regression on the model's equations (paper 003)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from ..estimation.methods_only.svr.regression import (
    FILTER,
    check_svr_options,
    check_svr_scheme,
    fit_svr,
    ls_svr,
    rows_by_scheme,
)
from ..estimation.methods_only.tuning.space import Real
from .base import Method

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..estimation.methods_only.svr.tuning import Tuner
    from ..estimation.results.fit import Fit
    from ..models.model import Model


class LsSvr(Method):
    """Least-squares support vector regression with a linear kernel on the model's equations.

    Parameters
    ----------
    C : regularisation constant; None chooses it from 1e-2 .. 1e10 by the error on the last 40 % of each record.
    scheme : 'svf' (state-variable filter, its corner frequency chosen as in `svf-ls`), or a scheme of
        `helmbench.estimation.regression.schemes`.
    tuner : 'grid' (25 values), or a function of (objective, low, high) that returns
        `helmbench.estimation.methods_only.svr.tuning.Tuned`.
    variant : 'corrected' standardises the regressors, has no intercept (eq 29 has none) and fits all rows once C is
        chosen; 'as_printed' regularises in SI units, with intercept, and fits the first 60 % only.
    """

    name = "ls-svr"
    title = "least-squares support vector regression, linear kernel (paper 003)"
    variants = ("corrected", "as_printed")
    search_space: ClassVar = {"C": Real(1e-2, 1e10, log=True)}

    def __init__(
        self, C: float | None = None, scheme: str = FILTER, tuner: str | Tuner = "grid", variant: str = "corrected"
    ) -> None:
        self.C, self.scheme, self.tuner, self.variant = C, scheme, tuner, variant

    def check_options(self) -> None:
        super().check_options()
        check_svr_options(self.C, self.tuner)
        check_svr_scheme(self.scheme)

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        corrected = self.variant == "corrected"
        rows, extra = rows_by_scheme(records, model, self.scheme, physical=not corrected)
        return fit_svr(rows, ls_svr(self.variant), self.C, self.tuner, corrected, extra)
