"""Linear difference equations with lags."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from ..estimation.methods_only.tuning.space import Real
from .learner import LAGS, STRIDE, NarxLearner

if TYPE_CHECKING:
    from ..models.model import Model


class Arx(NarxLearner):
    """Linear autoregression with inputs (ARX), all outputs at once.

    With outputs z (u, v, r; r of a response model), inputs w and step h,

        (z(t + h) - z(t)) / h = A_1 z(t) + ... + A_na z(t - (na - 1) h) + B_1 w(t) + ... + B_nb w(t - (nb - 1) h) + c

    by ridge regression on averaged samples (`helmbench.estimation.methods_only.black_box.rows`).  Source: Ljung 1999,
    System Identification, section 4.2; the order is chosen by free runs as Nelles 2001 advises, not by one-step errors.

    Parameters
    ----------
    stride : h in samples; output_lags, input_lags : na and nb; alpha : ridge penalty.  None: chosen by free runs.
    trials : option values tried; None: 12.
    seed : of the search.
    """

    name = "arx"
    title = "linear difference equation with lags (ARX)"
    search_space: ClassVar = {
        "stride": STRIDE,
        "output_lags": LAGS,
        "input_lags": LAGS,
        "alpha": Real(1e-9, 1e-1, log=True),
    }
    usual: ClassVar = {"stride": 4, "output_lags": 1, "input_lags": 2, "alpha": 1e-6}

    def __init__(
        self,
        stride: int | None = None,
        output_lags: int | None = None,
        input_lags: int | None = None,
        alpha: float | None = None,
        trials: int | None = None,
        seed: int = 0,
    ) -> None:
        self.stride, self.output_lags, self.input_lags = stride, output_lags, input_lags
        self.alpha, self.trials, self.seed = alpha, trials, seed

    def regressor(self, model: Model, symbols: tuple[str, ...]) -> Any:
        from ..estimation.methods_only.black_box.terms import TermRegression, monomials

        return TermRegression(monomials(len(symbols), 1), alpha=self.alpha or 0.0)
