"""Multilayer perceptrons of difference equations with lags."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from ..estimation.methods_only.tuning.space import Integer, Real
from .learner import STRIDE, NarxLearner

if TYPE_CHECKING:
    from ..models.model import Model


class Mlp(NarxLearner):
    """Multilayer perceptron in NARX form: one hidden layer of tanh units, trained by L-BFGS on one-step errors.

    Sources: Narendra & Parthasarathy 1990, IEEE Trans. Neural Networks 1(1), 4; for ships Moreira & Guedes Soares 2003,
    Ocean Engineering 30, 1669.  At most 800 rows, evenly spaced, are used.

    Parameters
    ----------
    stride : step in samples; input_lags : values of the inputs; units : of the hidden layer; alpha : penalty on the
        weights.  None: chosen by free runs.
    trials : option values tried; None: 4.
    seed : of the search and of the initial weights.
    """

    name = "mlp"
    title = "multilayer perceptron of a difference equation with lags"
    rows = 800
    usual_trials = 4
    search_space: ClassVar = {
        "stride": STRIDE,
        "input_lags": Integer(1, 2),
        "units": Integer(4, 24, log=True),
        "alpha": Real(1e-5, 10.0, log=True),
    }
    usual: ClassVar = {"stride": 4, "input_lags": 1, "units": 10, "alpha": 0.1}

    def __init__(
        self,
        stride: int | None = None,
        input_lags: int | None = None,
        units: int | None = None,
        alpha: float | None = None,
        trials: int | None = None,
        seed: int = 0,
    ) -> None:
        self.stride, self.input_lags, self.units = stride, input_lags, units
        self.alpha, self.trials, self.seed = alpha, trials, seed

    def regressor(self, model: Model, symbols: tuple[str, ...]) -> Any:
        from ..estimation.methods_only.black_box.perceptron import Perceptron

        return Perceptron((int(self.units or 1),), alpha=self.alpha, random_state=self.seed)
