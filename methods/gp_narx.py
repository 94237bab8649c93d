"""Gaussian-process regression of difference equations with lags."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from ..estimation.methods_only.tuning.space import Integer
from .learner import NarxLearner

if TYPE_CHECKING:
    from ..models.model import Model


class GpNarx(NarxLearner):
    """Gaussian-process regression in NARX form.

    The increments of the outputs over a step are Gaussian processes of their and the inputs' last values, with a
    squared-exponential kernel of one length scale for each feature, plus white noise; the scales have the largest
    marginal likelihood.  Sources: Rasmussen & Williams 2006, section 5.4; Kocijan et al. 2005, Math. Comput. Model.
    Dyn. Syst. 11(4), 411.  At most 400 rows, evenly spaced over the records, are used, and 100 of them for the scales
    (subset of data: the cost grows with the cube of their number).  Free runs propagate the mean.

    Parameters
    ----------
    stride : step in samples; input_lags : values of the inputs.  None: chosen by free runs.
    trials : option values tried; None: 4.
    seed : of the search.
    """

    name = "gp-narx"
    title = "Gaussian process of a difference equation with lags, on a subset of rows"
    rows = 400
    usual_trials = 4
    search_space: ClassVar = {"stride": Integer(2, 16, log=True), "input_lags": Integer(1, 2)}
    usual: ClassVar = {"stride": 6, "input_lags": 1}

    def __init__(
        self, stride: int | None = None, input_lags: int | None = None, trials: int | None = None, seed: int = 0
    ) -> None:
        self.stride, self.input_lags, self.trials, self.seed = stride, input_lags, trials, seed

    def regressor(self, model: Model, symbols: tuple[str, ...]) -> Any:
        from ..estimation.methods_only.black_box.gaussian_process import gaussian_process

        return gaussian_process(len(symbols))
