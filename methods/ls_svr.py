"""Least-squares support vector regression on the model's equations, plain and robust (paper 003)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, ClassVar

from ..datasets.record import Record
from ..estimation.methods_only.svr.regression import FILTER, BuildRegressor, fit_svr, ls_svr, rows_by_scheme, rw_ls_svr
from ..estimation.methods_only.svr.tuning import TUNERS, Tuner
from ..estimation.methods_only.tuning.space import Real
from ..estimation.regression.schemes import SCHEMES
from ..estimation.results.fit import Fit
from ..models.model import Model
from .base import Method
from .options import POSITIVE, option, words


def _check_tuner(name: str, value: Any) -> None:
    if not callable(value):
        words("tuner", TUNERS)(name, value)


CONSTANT: Any = option(
    None,
    "regularisation constant; None chooses it from 1e-2 .. 1e10 by the error on the last 40 % of each record",
    POSITIVE,
    Real(1e-2, 1e10, log=True),
)
TUNER: Any = option(
    "grid",
    "'grid' (25 values), or a function of (objective, low, high) that returns "
    "`helmbench.estimation.methods_only.svr.tuning.TunedConstant`",
    _check_tuner,
)


class LsSvr(Method):
    """Least-squares support vector regression with a linear kernel on the model's equations."""

    name = "ls-svr"
    title = "least-squares support vector regression, linear kernel (paper 003)"
    variants = ("corrected", "as_printed")
    regressor: ClassVar[Callable[[str], BuildRegressor]] = staticmethod(ls_svr)
    C: float | None = CONSTANT
    scheme: str = option(
        FILTER,
        "'svf' (state-variable filter, its corner frequency chosen as in `svf-ls`), or a scheme of "
        "`helmbench.estimation.regression.schemes`",
        words("difference scheme", (FILTER, *SCHEMES)),
    )
    tuner: str | Tuner = TUNER
    variant: str = option(
        "corrected",
        "'corrected' standardises the regressors, has no intercept (eq 29 has none) and fits all rows once C is "
        "chosen; 'as_printed' regularises in SI units, with intercept, and fits the first 60 % only",
    )

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        corrected = self.variant == "corrected"
        rows, extra = rows_by_scheme(records, model, self.scheme, physical=not corrected)
        return fit_svr(rows, self.regressor(self.variant), self.C, self.tuner, corrected, extra)


class RwLsSvr(LsSvr):
    """As `ls-svr`, with outliers removed by the MAD rule and adaptive weights on the errors."""

    name = "rw-ls-svr"
    title = "robust weighted LS-SVR: MAD rule and adaptive weights (paper 003)"
    regressor = staticmethod(rw_ls_svr)
    variant: str = option(
        "corrected",
        "'corrected' applies the rule to residuals and iterates weights in |e| to convergence; 'as_printed' applies it "
        "to the highest derivative itself and weights once by signed errors.  Otherwise as in `ls-svr`",
    )
