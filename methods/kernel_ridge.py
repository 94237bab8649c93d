"""Kernel ridge regression of difference equations with lags."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from ..estimation.methods_only.tuning.space import Integer, Real
from .learner import STRIDE, NarxLearner

if TYPE_CHECKING:
    from ..models.model import Model


class KernelRidgeNarx(NarxLearner):
    """Kernel ridge regression in NARX form, with squared-exponential kernels.

    f(x) = sum_i a_i exp(-gamma |x - x_i|^2) with (K + alpha I) a = y on the rows of
    `helmbench.estimation.methods_only.black_box.rows`.  Least-squares support vector regression (Suykens & Vandewalle
    1999, Neural Processing Letters 9, 293) is the same with an intercept, C = 1 / alpha.  Kernel width and penalty are
    chosen by the error of free runs, not of one step (Espinoza et al. 2006, Computational Intelligence and Complexity,
    113).

    Parameters
    ----------
    stride : step in samples; input_lags : values of the inputs; alpha, gamma : of features and targets of unit size.
        None: chosen by free runs.
    trials : option values tried; None: 12.
    seed : of the search.
    """

    name = "kernel-ridge"
    title = "kernel ridge regression (LS-SVR) of a difference equation with lags"
    rows = 500
    search_space: ClassVar = {
        "stride": STRIDE,
        "input_lags": Integer(1, 2),
        "alpha": Real(1e-5, 10.0, log=True),
        "gamma": Real(3e-3, 0.5, log=True),
    }
    usual: ClassVar = {"stride": 4, "input_lags": 1, "alpha": 0.1, "gamma": 0.03}

    def __init__(
        self,
        stride: int | None = None,
        input_lags: int | None = None,
        alpha: float | None = None,
        gamma: float | None = None,
        trials: int | None = None,
        seed: int = 0,
    ) -> None:
        self.stride, self.input_lags = stride, input_lags
        self.alpha, self.gamma, self.trials, self.seed = alpha, gamma, trials, seed

    def regressor(self, model: Model, symbols: tuple[str, ...]) -> Any:
        from sklearn.kernel_ridge import KernelRidge

        options: dict[str, Any] = {"alpha": self.alpha, "gamma": self.gamma}
        return KernelRidge(kernel="rbf", **options)
