"""Parameters of largest likelihood: Gauss-Newton steps between steps of the noise."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...models.linear_algebra import lstsq
from ..filters.innovations.derivatives import columns
from ..filters.innovations.noise_fit import fit_noise

if TYPE_CHECKING:
    from ..filters.innovations.estimator import Estimator, Innovations
    from ..filters.innovations.settings import Parameter, Setting


def refit(
    est: Estimator,
    s: Setting,
    parameters: Sequence[Parameter],
    most: int = 6,
    prior: np.ndarray | None = None,
    tolerance: float = 0.05,
) -> tuple[Setting, Innovations]:
    """Parameters and noise of largest likelihood near a setting.

    prior : (m,) precisions of Gaussian priors about zero.
    """
    s, now = fit_noise(est, s, 2)
    for iteration in range(most):
        before = now.log_likelihood
        if now.diverged:
            break
        s, now = gauss_newton(est, s, now, parameters, prior)
        s, now = fit_noise(est, s, 2 if iteration == most - 1 else 1)
        if now.log_likelihood - before < tolerance:
            break
    return s, now


def gauss_newton(
    est: Estimator, s: Setting, now: Innovations, parameters: Sequence[Parameter], prior: np.ndarray | None = None
) -> tuple[Setting, Innovations]:
    """One step of the parameters with the noise held, halved until the penalised likelihood rises."""
    if not parameters:
        return s, now
    d = columns(est, s, parameters)
    fisher, gradient = d @ d.T, -d @ now.e.ravel()
    values = np.array([est.value(s, p) for p in parameters])
    weight = np.zeros(values.size) if prior is None else prior
    fisher, gradient = fisher + np.diag(weight), gradient - weight * values
    scale = np.sqrt(np.diag(fisher)) + 1e-30
    matrix = fisher / np.outer(scale, scale) + 1e-9 * np.eye(scale.size)
    change = lstsq(matrix, gradient / scale) / scale
    penalty = 0.5 * float(np.sum(weight * values**2))
    for power in range(6):
        trial = s
        for p, value, step in zip(parameters, values, change * 0.5**power, strict=True):
            trial = est.at(trial, p, value + step)
        moved = np.array([est.value(trial, p) for p in parameters])
        there = est.evaluate(trial, traced=True)
        if there.log_likelihood - 0.5 * np.sum(weight * moved**2) > now.log_likelihood - penalty:
            return trial, there
    return s, now
