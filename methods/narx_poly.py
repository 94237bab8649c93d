"""Polynomial difference equations with lags."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from ..estimation.methods_only.tuning.space import Choice, Integer, Real
from .learner import STRIDE, NarxLearner

if TYPE_CHECKING:
    from ..models.model import Model


class NarxPoly(NarxLearner):
    """Polynomial nonlinear autoregression with inputs (NARX).

    The increment of the outputs over a step is a polynomial of their and the inputs' last values
    (`helmbench.estimation.methods_only.black_box.rows`), with ridge regression on its monomials.  Source: Billings
    2013, Nonlinear System Identification, section 2.4.  All monomials are kept and the penalty is chosen by free runs,
    where Billings selects terms by one-step errors.

    Parameters
    ----------
    stride : step in samples; output_lags, input_lags : values of outputs and inputs; degree : of the polynomial, 2 or
        3; alpha : ridge penalty.  None: chosen by free runs.
    trials : option values tried; None: 12.
    seed : of the search.
    """

    name = "narx-poly"
    title = "polynomial difference equation with lags (NARX)"
    search_space: ClassVar = {
        "stride": STRIDE,
        "output_lags": Integer(1, 2),
        "input_lags": Integer(1, 2),
        "degree": Choice(2, 3),
        "alpha": Real(1e-9, 1e-1, log=True),
    }
    usual: ClassVar = {"stride": 4, "output_lags": 1, "input_lags": 1, "degree": 2, "alpha": 1e-4}

    def __init__(
        self,
        stride: int | None = None,
        output_lags: int | None = None,
        input_lags: int | None = None,
        degree: int | None = None,
        alpha: float | None = None,
        trials: int | None = None,
        seed: int = 0,
    ) -> None:
        self.stride, self.output_lags, self.input_lags = stride, output_lags, input_lags
        self.degree, self.alpha, self.trials, self.seed = degree, alpha, trials, seed

    def regressor(self, model: Model, symbols: tuple[str, ...]) -> Any:
        from ..estimation.methods_only.black_box.terms import TermRegression, monomials

        return TermRegression(monomials(len(symbols), self.degree or 2), alpha=self.alpha or 0.0)
