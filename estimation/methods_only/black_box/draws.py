"""Draws of learnt functions from what their regressors say of their own uncertainty: Gaussian processes and forests."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ....models.linear_algebra import finite
from .compiled import Packed, forest, kernel_sums

AROUND, FARTHEST = 100, 2.0
"""Points besides the training rows at which a Gaussian process is drawn: rows moved from the middle up to this far."""
JITTER = 1e-9
"""Share of a kernel matrix's diagonal that is added to it before it is inverted."""


def drawn(regressors: Sequence[Any], k: int, count: int, rng: np.random.Generator) -> list[Packed]:
    """At most `count` functions with k outputs of scaled features; none of regressors that state no uncertainty.

    A forest gives its trees, each of which learnt from rows drawn anew.  A Gaussian process is drawn from its posterior
    density at its training rows and at `AROUND` points around them, and interpolated in between; further away a draw
    returns to the mean.  Sources: Breiman 2001, Machine Learning 45, 5; Rasmussen & Williams 2006, eqs 2.23 and 2.24.
    """
    if all(hasattr(one, "estimators_") and hasattr(one, "bootstrap") for one in regressors):
        return _trees(regressors, k, count, rng)
    if all(hasattr(one, "kernel_") and hasattr(one, "X_train_") for one in regressors):
        return _processes(regressors, k, count, rng)
    return []


def _trees(forests: Sequence[Any], k: int, count: int, rng: np.random.Generator) -> list[Packed]:
    d = forests[0].n_features_in_
    chosen = rng.permutation(min(len(one.estimators_) for one in forests))[:count]
    return [forest([one.estimators_[place] for one in forests], d, k) for place in chosen]


def _processes(processes: Sequence[Any], k: int, count: int, rng: np.random.Generator) -> list[Packed]:
    d, found = processes[0].n_features_in_, [_process(one, count, rng) for one in processes]
    return [
        kernel_sums([(scale, points, weights[draw], constant) for scale, points, weights, constant in found], d, k)
        for draw in range(count)
    ]


def _process(one: Any, count: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Draws of a process of q outputs: scales (d,), scaled points (m, d), weights (count, m, q) and constants (q,)."""
    smooth, rows = one.kernel_.k1, one.X_train_
    mean = one.alpha_.reshape(len(rows), -1)
    points = np.vstack([rows, _around(rows, rng)])
    kernel, known = finite(smooth(points)), slice(len(rows))
    noisy = kernel[known, known] + one.kernel_.k2.noise_level * np.eye(len(rows))
    size, vectors = np.linalg.eigh(kernel - kernel[:, known] @ np.linalg.solve(noisy, kernel[known]))
    normal = rng.normal(size=(count, len(points), mean.shape[1]))
    deviations = (vectors * np.sqrt(np.maximum(size, 0.0))) @ normal
    weights = np.linalg.solve(kernel + JITTER * np.diag(np.diag(kernel)), deviations)
    weights[:, known] += mean
    scale = np.sqrt(0.5) / (smooth.k2.length_scale * np.ones(rows.shape[1]))
    constant = np.zeros(mean.shape[1]) + one._y_train_mean
    return scale, points * scale, smooth.k1.constant_value * one._y_train_std * weights, constant


def _around(rows: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Rows (AROUND, d) drawn from the training rows and moved away from their middle."""
    middle = rows.mean(axis=0)
    chosen = rows[rng.integers(len(rows), size=AROUND)]
    return middle + (chosen - middle) * rng.uniform(1.0, FARTHEST, size=(AROUND, 1))
