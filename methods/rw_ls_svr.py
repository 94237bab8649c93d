"""Robust weighted least-squares support vector regression on the model's equations (paper 003)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from ..estimation.methods_only.svr.regression import (
    FILTER,
    check_svr_options,
    check_svr_scheme,
    fit_svr,
    rows_by_scheme,
    rw_ls_svr,
)
from ..estimation.methods_only.tuning.space import Real
from .base import Method

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..estimation.methods_only.svr.tuning import Tuner
    from ..estimation.results.fit import Fit
    from ..models.model import Model


class RwLsSvr(Method):
    """As `ls-svr`, with outliers removed by the MAD rule and adaptive weights on the errors.

    Parameters
    ----------
    C, scheme, tuner : as in `ls-svr`.
    variant : 'corrected' applies the rule to residuals and iterates weights in |e| to convergence; 'as_printed' applies
        it to the highest derivative itself and weights once by signed errors.  Otherwise as in `ls-svr`.
    """

    name = "rw-ls-svr"
    title = "robust weighted LS-SVR: MAD rule and adaptive weights (paper 003)"
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
        return fit_svr(rows, rw_ls_svr(self.variant), self.C, self.tuner, corrected, extra)
