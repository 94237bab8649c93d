"""Joint state and parameter estimation by an unscented Kalman filter.

As `ekf` in everything but the prediction: the joint density goes through one RK4 sample step at sigma points (Julier &
Uhlmann 1997; scaled form of Wan & van der Merwe 2000) instead of along the tangent.  No sensitivities are needed.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..models.errors import BadInput
from .ekf import Belief, Ekf, Noise, Pass, start_vector
from .series import Series
from .tuning.space import Real

if TYPE_CHECKING:
    from ..models.model import Model


def unscented_run(
    model: Model, series: Series, belief: Belief, noise: Noise, alpha: float, beta: float
) -> tuple[Belief, np.ndarray, np.ndarray, float]:
    """One record through the filter: belief after it, path (N, p), innovations (N, c), negative log likelihood."""
    from ..models.simulate import substeps
    from . import _ukf_kernels

    n, p = len(model.states), len(model.coordinates)
    z, covariance = start_vector(model, series, belief)
    theta = np.concatenate([belief.coefficients, model.constants])
    path, innovations = np.empty((len(series.outputs), p)), np.empty_like(series.outputs)
    cost = _ukf_kernels.unscented(
        model.kernels.rhs, z, theta, covariance, belief.origin, np.ascontiguousarray(belief.factor),
        series.inputs, series.outputs, np.round(series.index + series.part).astype(np.int64), series.columns,
        series.dt, substeps(model, series.dt), noise.process, noise.sensor[series.columns], alpha, beta,
        path, innovations,
    )  # fmt: skip
    after = belief._replace(mean=z[n:], covariance=covariance[n:, n:])
    return after, path, innovations, cost if np.isfinite(z).all() else np.inf


class Ukf(Ekf):
    """Joint unscented Kalman filter, iterated as `ekf` is.

    Parameters
    ----------
    passes, inflation : as in `Ekf`.
    alpha : distance of the sigma points in units of sqrt(m) standard deviations, m being the size of the joint vector.
    beta : weight of the mean's shift in the covariance; 2 for Gaussian densities.

    Starting values, sensor and process noise, and the initial states between passes are those of `Ekf`.
    """

    name = "ukf"
    title = "joint state and parameter unscented Kalman filter"
    search_space: ClassVar = {"inflation": Real(0.1, 1000.0, log=True), "alpha": Real(1e-3, 1.0, log=True)}

    def __init__(self, passes: int = 4, inflation: float = 5.0, alpha: float = 0.1, beta: float = 2.0) -> None:
        super().__init__(passes, inflation)
        self.alpha, self.beta = alpha, beta

    def check_options(self) -> None:
        super().check_options()
        if not 0.0 < self.alpha <= 1.0:
            raise BadInput(f"alpha is {self.alpha!r}, a number above 0 and up to 1 is needed")
        if not self.beta >= 1.0:
            raise BadInput(f"beta is {self.beta!r}, at least 1 is needed")

    def joint_pass(self, model: Model, series: Sequence[Series], belief: Belief, noise: Noise) -> Pass:
        """All records in turn, the belief about the coefficients carried over."""
        paths, innovations, cost = [], [], 0.0
        for s in series:
            belief, path, errors, own = unscented_run(model, s, belief, noise, self.alpha, self.beta)
            paths.append(path)
            innovations.append(errors)
            cost += own
        return Pass(belief, np.concatenate(paths), innovations, cost if np.isfinite(cost) else np.inf)
