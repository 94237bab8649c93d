"""Boosted trees of difference equations with lags."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from ..estimation.methods_only.tuning.space import Integer, Real
from .learner import STRIDE, NarxLearner

if TYPE_CHECKING:
    from ..models.model import Model


class GradientBoosting(NarxLearner):
    """Histogram gradient boosting in NARX form, one regressor for each output.

    Trees cannot extrapolate: outside the training records the increments are those at their edge.  Sources: Friedman
    2001, Ann. Stat. 29(5), 1189; Ke et al. 2017, NeurIPS 30.  `sklearn:lightgbm.LGBMRegressor` is another
    implementation, on accelerations.

    Parameters
    ----------
    stride : step in samples; input_lags : values of the inputs; max_iter, learning_rate, max_leaf_nodes : of the trees.
        None: chosen by free runs.
    trials : option values tried; None: 8.
    seed : of the search and of the trees.
    """

    name = "gradient-boosting"
    title = "boosted trees of a difference equation with lags"
    usual_trials = 8
    search_space: ClassVar = {
        "stride": STRIDE,
        "input_lags": Integer(1, 2),
        "max_iter": Integer(20, 80, log=True),
        "learning_rate": Real(0.05, 0.4, log=True),
        "max_leaf_nodes": Integer(4, 31, log=True),
    }
    usual: ClassVar = {"stride": 4, "input_lags": 1, "max_iter": 40, "learning_rate": 0.2, "max_leaf_nodes": 15}

    def __init__(
        self,
        stride: int | None = None,
        input_lags: int | None = None,
        max_iter: int | None = None,
        learning_rate: float | None = None,
        max_leaf_nodes: int | None = None,
        trials: int | None = None,
        seed: int = 0,
    ) -> None:
        self.stride, self.input_lags, self.max_iter = stride, input_lags, max_iter
        self.learning_rate, self.max_leaf_nodes = learning_rate, max_leaf_nodes
        self.trials, self.seed = trials, seed

    def regressor(self, model: Model, symbols: tuple[str, ...]) -> Any:
        from sklearn.ensemble import HistGradientBoostingRegressor

        names = ("max_iter", "learning_rate", "max_leaf_nodes")
        options: dict[str, Any] = {name: getattr(self, name) for name in names} | {"early_stopping": False}
        return HistGradientBoostingRegressor(random_state=self.seed, **options)
