"""scikit-learn's perceptron, trained by a fixed number of L-BFGS iterations."""

from __future__ import annotations

import warnings
from typing import Any

from sklearn.exceptions import ConvergenceWarning
from sklearn.neural_network import MLPRegressor

ITERATIONS = 100


class Perceptron(MLPRegressor):
    """A perceptron of tanh units; stopping early is part of its regularisation, so it is no reason to warn."""

    def __init__(self, hidden_layer_sizes: Any = (10,), alpha: Any = 0.1, random_state: int = 0) -> None:
        super().__init__(
            hidden_layer_sizes=hidden_layer_sizes,
            activation="tanh",
            solver="lbfgs",
            alpha=alpha,
            max_iter=ITERATIONS,
            random_state=random_state,
        )

    def fit(self, X: Any, y: Any, sample_weight: Any = None) -> Perceptron:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)
            super().fit(X, y, sample_weight)
        return self
