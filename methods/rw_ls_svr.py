"""Robust weighted least-squares support vector regression on the model's equations (paper 003)."""

from __future__ import annotations

from typing import Any

from .ls_svr import LsSvr


class RwLsSvr(LsSvr):
    """As `ls-svr`, with outliers removed by the MAD rule and adaptive weights on the errors.

    Parameters
    ----------
    As `LsSvr`.  variant : 'corrected' applies the rule to residuals and iterates weights in |e| to convergence;
    'as_printed' applies it to the highest derivative itself and weights once by signed errors.
    """

    name = "rw-ls-svr"
    title = "robust weighted LS-SVR: MAD rule and adaptive weights (paper 003)"

    def regressor(self, c: float, rough: bool = False) -> Any:
        """The scikit-learn regressor at a value of C; `rough` while C is chosen."""
        from .svr.estimators import RWLSSVR

        corrected = self.variant == "corrected"
        setting: dict[str, Any] = {"max_iter": 10, "tol": 1e-3} if rough else {}
        return RWLSSVR(C=c, standardise=corrected, fit_intercept=not corrected, variant=self.variant, **setting)
