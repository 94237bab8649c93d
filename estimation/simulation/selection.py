"""A criterion for choosing among estimates: how well their free runs follow the training records."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...models.linear_algebra import lstsq
from ...models.model import Model
from ..records.series import Series
from . import free_run

Followed = tuple[Series, np.ndarray]
"""A series with the initial state that a free run began from, and what was measured less what ran, (N, c)."""
ROUNDS = 2
"""Gauss-Newton steps of the initial state."""
STEP = 1e-3
"""Step of the difference quotients with respect to an initial state, in its standard deviations."""


def fitted_start(model: Model, series: Series) -> Series:
    """The series with the initial state from which the model's free run follows it best (Gauss-Newton, 2 rounds)."""
    return _followed(model, series)[0]


def _followed(model: Model, series: Series) -> Followed:
    """The free run from `fitted_start`."""
    best = (series, free_run.residuals(model, series, series.start))
    cost = _cost([best])
    for _ in range(ROUNDS):
        start = _improved(model, best)
        tried = (replace(series, start=start), free_run.residuals(model, series, start))
        now = _cost([tried])
        if not now < cost:
            break
        best, cost = tried, now
    return best


def _improved(model: Model, run: Followed) -> np.ndarray:
    """Initial state (n,) after one Gauss-Newton step from that of a run; the old one if a run diverges."""
    series, error = run
    free = np.flatnonzero(series.start_sd > 0.0)
    known = np.isfinite(error)
    mean = (np.where(known, error, 0.0) ** 2).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
    weight = 1.0 / np.maximum(np.sqrt(mean), 1e-300)
    slopes = np.empty((len(free), int(known.sum())))
    for own, state in zip(slopes, free, strict=True):
        step = STEP * series.start_sd[state]
        nearby = series.start.copy()
        nearby[state] += step
        change = free_run.residuals(model, series, nearby)
        np.subtract(error, change, out=change)
        change /= step
        change *= weight
        own[:] = change[known]
    if not (slopes.size and np.isfinite(slopes).all()):
        return series.start
    start = series.start.copy()
    start[free] += lstsq(slopes.T, (error * weight)[known], rcond=1e-10)
    return start


def _cost(runs: Sequence[Followed]) -> float:
    """Negative log likelihood of white residuals whose variances are unknown; inf if a run diverges."""
    total: dict[int, float] = {}
    count: dict[int, int] = {}
    for s, error in runs:
        squares = free_run.sums_of_squares(s, error)  # infinite where the run diverges
        for column, value, outputs in zip(s.columns.tolist(), squares, s.outputs.T, strict=True):
            total[column] = total.get(column, 0.0) + float(value)
            count[column] = count.get(column, 0) + int(np.isfinite(outputs).sum())
    logs = [0.5 * count[c] * np.log(max(total[c] / count[c], 1e-300)) for c in total if count[c]]
    cost = float(np.sum(logs))
    return cost if np.isfinite(cost) else np.inf


def free_run_cost(model: Model, series: Sequence[Series]) -> float:
    """Negative log likelihood of the model's free runs, each from its best initial state; inf if one diverges."""
    return left_out_cost([model] * len(series), series)


def left_out_cost(models: Sequence[Model], series: Sequence[Series]) -> float:
    """As `free_run_cost`, with a model of its own for each series: the one that was fitted without it."""
    if not all(model.known for model in models):
        return np.inf
    return _cost([_followed(model, s) for model, s in zip(models, series, strict=True)])
