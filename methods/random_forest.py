"""Random forests of difference equations with lags."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from ..estimation.methods_only.tuning.space import Integer
from .learner import STRIDE, NarxLearner

if TYPE_CHECKING:
    from ..models.model import Model

TREES = 30


class RandomForest(NarxLearner):
    """Random forest in NARX form: the mean of 30 regression trees, each on a bootstrap sample of the rows.

    Source: Breiman 2001, Machine Learning 45, 5.  At most 3,000 rows, evenly spaced, are used.

    Parameters
    ----------
    stride : step in samples; input_lags : values of the inputs; min_samples_leaf : rows in a leaf.
        None: chosen by free runs.
    trials : option values tried; None: 6.
    seed : of the search and of the trees.
    """

    name = "random-forest"
    title = "random forest of a difference equation with lags"
    rows = 3000
    usual_trials = 6
    search_space: ClassVar = {
        "stride": STRIDE,
        "input_lags": Integer(1, 2),
        "min_samples_leaf": Integer(1, 30, log=True),
    }
    usual: ClassVar = {"stride": 4, "input_lags": 1, "min_samples_leaf": 3}

    def __init__(
        self,
        stride: int | None = None,
        input_lags: int | None = None,
        min_samples_leaf: int | None = None,
        trials: int | None = None,
        seed: int = 0,
    ) -> None:
        self.stride, self.input_lags, self.min_samples_leaf = stride, input_lags, min_samples_leaf
        self.trials, self.seed = trials, seed

    def regressor(self, model: Model, symbols: tuple[str, ...]) -> Any:
        from sklearn.ensemble import RandomForestRegressor

        leaf: Any = self.min_samples_leaf
        return RandomForestRegressor(TREES, min_samples_leaf=leaf, random_state=self.seed)
