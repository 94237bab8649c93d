"""scikit-learn's Gaussian process with a limited search for its kernel, and its perceptron with few iterations."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel
from sklearn.neural_network import MLPRegressor

from .scaled import evenly_spaced

ITERATIONS, SUBSET = 15, 100
"""Steps of the search, and rows whose likelihood is searched."""


def limited(objective: Callable[..., Any], start: np.ndarray, bounds: np.ndarray) -> tuple[np.ndarray, float]:
    """Parameters near the largest marginal likelihood, after a few steps of L-BFGS-B."""
    from scipy.optimize import minimize

    found = minimize(objective, start, method="L-BFGS-B", jac=True, bounds=bounds, options={"maxiter": ITERATIONS})
    return found.x, float(found.fun)


class QuickGaussianProcess(GaussianProcessRegressor):
    """A Gaussian process whose kernel is searched on some of the rows, evenly spaced, and then conditioned on all.

    Length scales at their bounds are no reason to warn: such a feature does not count.
    """

    def fit(self, X: Any, y: Any) -> QuickGaussianProcess:
        some = evenly_spaced(len(X), SUBSET)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)
            super().fit(X[some], y[some])
            self.set_params(kernel=self.kernel_, optimizer=None)
            super().fit(X, y)
        return self


def kernel_with_noise(n_features: int) -> Any:
    """A smooth Gaussian-process kernel with a length scale for each feature, plus white noise.

    scikit-learn's default kernel has no noise.
    """
    scales: Any = np.full(n_features, 3.0)
    smooth = ConstantKernel(1.0, (1e-3, 1e4)) * RBF(scales, (1e-1, 1e3))
    return smooth + WhiteKernel(1e-2, (1e-10, 1e1))


def gaussian_process(n_features: int) -> QuickGaussianProcess:
    """A new regressor with one length scale for each feature."""
    search: Any = limited
    return QuickGaussianProcess(kernel_with_noise(n_features), optimizer=search)


MOST_STEPS = 100
"""L-BFGS iterations of a perceptron."""


class Perceptron(MLPRegressor):
    """A perceptron of tanh units; stopping early is part of its regularisation, so it is no reason to warn."""

    def __init__(self, hidden_layer_sizes: Any = (10,), alpha: Any = 0.1, random_state: int = 0) -> None:
        super().__init__(
            hidden_layer_sizes=hidden_layer_sizes,
            activation="tanh",
            solver="lbfgs",
            alpha=alpha,
            max_iter=MOST_STEPS,
            random_state=random_state,
        )

    def fit(self, X: Any, y: Any, sample_weight: Any = None) -> Perceptron:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)
            super().fit(X, y, sample_weight)
        return self
