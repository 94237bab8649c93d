"""Fitted regressors as plain arrays, for free runs, which predict one row at a time.

scikit-learn's `predict` takes up to milliseconds per call, even for one row.  The forms here take some microseconds;
each is only used where it agrees with `predict` on rows of the training set.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from ....models.linear_algebra import finite

NETWORKS, TERMS, KERNELS, TREES = range(4)
OUTSIDE = 1e3
"""Standard deviations from the training rows beyond which nothing is predicted: the run has diverged."""


AGREEMENT = 1e-9
"""Relative and absolute difference up to which a form agrees with `predict`."""
ROUNDING = 10.0 * float(np.finfo(float).eps)
"""Difference that is allowed besides, relative to the terms of a sum: two orders of summation differ by as much."""


class Packed(NamedTuple):
    """A learnt function with k outputs: its form, and two arrays whose layout `_kernels` says at each form.

    work : numbers of memory that an evaluation takes.  size : of the terms of a sum, which may be far larger than the
    sum; zero where they are not.
    """

    form: int
    ints: np.ndarray
    floats: np.ndarray
    outputs: int
    work: int = 0
    size: float = 0.0

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """Outputs (B, k) at features (B, d)."""
        from ._kernels import rows

        found = np.empty((len(x), self.outputs))
        rows(self.form, self.ints, self.floats, np.ascontiguousarray(x, float), np.empty(self.work), found)
        return found


def _packed(form: int, ints: Sequence[Any], floats: Sequence[Any], outputs: int, work: int = 0) -> Packed:
    """A packed function of numbers and arrays in the order of its form."""
    return Packed(
        form,
        np.concatenate([np.ravel(part) for part in ints]).astype(np.int64),
        np.concatenate([np.ravel(part) for part in floats]).astype(float),
        outputs,
        work,
    )


def _check(found: object, wanted: object) -> None:
    """Raise ValueError where arrays do not have the shapes of a form: compiled code does not look."""
    if found != wanted:
        raise ValueError(f"{found} instead of {wanted}")


def compiled(regressors: Sequence[Any], x: np.ndarray) -> Packed | None:
    """A fast form of fitted regressors, checked on rows x (N, d); None if no form agrees."""
    expected = stacked(regressors, x)
    for form in (_affine, _terms, _kernel, _ridge_kernel, _gaussian_process, _network, forest, _boosted):
        try:
            found = form(regressors, x.shape[1], expected.shape[1])
            if found is not None and _agree(found, x, expected):
                return found
        except (AttributeError, IndexError, KeyError, TypeError, ValueError):
            continue  # the regressors do not have this form
    return None


def _agree(found: Packed, x: np.ndarray, expected: np.ndarray) -> bool:
    """Whether a form gives the expected outputs (N, k) at rows x (N, d), up to the rounding of its terms."""
    return np.allclose(found(x), expected, rtol=AGREEMENT, atol=AGREEMENT + ROUNDING * found.size)


def stacked(regressors: Sequence[Any], x: np.ndarray) -> np.ndarray:
    """Predictions (N, k) by scikit-learn itself, of one regressor for all outputs or of one for each."""
    return np.column_stack([np.asarray(one.predict(x), float).reshape(len(x), -1) for one in regressors])


def _affine(regressors: Sequence[Any], d: int, k: int) -> Packed:
    """Straight lines: networks without hidden layers."""
    w = [np.atleast_2d(one.coef_) for one in regressors]
    b = [np.ravel(one.intercept_) * np.ones(len(rows)) for one, rows in zip(regressors, w, strict=True)]
    return _layers([[(np.vstack(w).T, np.concatenate(b))]], d, k)


def _network(regressors: Sequence[Any], d: int, k: int) -> Packed | None:
    if any(one.activation != "tanh" for one in regressors):
        return None
    return _layers([list(zip(one.coefs_, one.intercepts_, strict=True)) for one in regressors], d, k)


def _layers(networks: Sequence[Sequence[tuple[np.ndarray, np.ndarray]]], d: int, k: int) -> Packed:
    """Networks of layers with weights (d, m) and biases (m,)."""
    sizes = [[len(layers[0][0]), *(len(b) for _, b in layers)] for layers in networks]
    for own, layers in zip(sizes, networks, strict=True):
        _check([own[0], *(w.shape for w, _ in layers)], [d, *pairwise(own)])
    _check(sum(own[-1] for own in sizes), k)
    ints = [len(networks), *([len(own) - 1, *own] for own in sizes)]
    floats = [part for layers in networks for layer in layers for part in layer]
    return _packed(NETWORKS, ints, floats, k, 2 * max(map(max, sizes)))


def _terms(regressors: Sequence[Any], d: int, k: int) -> Packed:
    (one,) = regressors
    _check([one.terms_.max(initial=0) <= 2 * d, one.weights_.shape], [True, (len(one.terms_), k)])
    return _packed(TERMS, [*one.terms_.shape, k, one.terms_], [one.weights_], k)


def _kernel(regressors: Sequence[Any], d: int, k: int) -> Packed:
    """Support vector machines."""
    outputs = [(one._gamma, one.support_vectors_, one.dual_coef_.T, one.intercept_) for one in regressors]
    return kernel_sums([_isotropic(*output) for output in outputs], d, k)


def _ridge_kernel(regressors: Sequence[Any], d: int, k: int) -> Packed:
    """Kernel ridge regression."""
    outputs = [(one.gamma, one.X_fit_, one.dual_coef_.reshape(len(one.X_fit_), -1), 0.0) for one in regressors]
    return kernel_sums([_isotropic(*output) for output in outputs], d, k)


def _isotropic(gamma: float, vectors: np.ndarray, weights: np.ndarray, b: Any):
    scale = np.full(vectors.shape[1], np.sqrt(gamma))
    return scale, vectors * scale, weights, np.zeros(weights.shape[1]) + b


def _gaussian_process(regressors: Sequence[Any], d: int, k: int) -> Packed:
    """Gaussian processes with a constant times a squared exponential, plus noise."""
    outputs = []
    for one in regressors:
        smooth = one.kernel_.k1
        scale = np.sqrt(0.5) / (smooth.k2.length_scale * np.ones(one.X_train_.shape[1]))
        weights = smooth.k1.constant_value * one.alpha_.reshape(len(one.X_train_), -1) * one._y_train_std
        outputs.append((scale, one.X_train_ * scale, weights, np.zeros(weights.shape[1]) + one._y_train_mean))
    return kernel_sums(outputs, d, k)


def kernel_sums(outputs: Sequence[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]], d: int, k: int) -> Packed:
    """Kernel sums of scales (d,), vectors (m, d), weights (m, k) and constants (k,)."""
    shapes = [weights.shape for _, _, weights, _ in outputs]
    for (m, own), (scale, vectors, _, b) in zip(shapes, outputs, strict=True):
        _check([scale.shape, vectors.shape, b.shape], [(d,), (m, d), (own,)])
    _check(sum(own for _, own in shapes), k)
    size = max(float(np.abs(weights).sum(axis=0).max()) for _, _, weights, _ in outputs)
    found = _packed(KERNELS, [len(outputs), *shapes], [part for output in outputs for part in output], k)
    return found._replace(size=size)


def forest(regressors: Sequence[Any], d: int, k: int) -> Packed:
    """Single trees and means of them (random forests, extra trees)."""
    parts = []
    for place, one in enumerate(regressors):
        trees = [tree.tree_ for tree in getattr(one, "estimators_", [one])]
        for tree in trees:
            value = np.zeros((tree.node_count, k))
            values = tree.value[:, :, 0] / len(trees)
            value[:, place : place + values.shape[1]] = values
            leaf = tree.children_left < 0
            feature = np.where(leaf, 0, tree.feature)
            parts.append((feature, tree.threshold, tree.children_left, tree.children_right, leaf, value))
    return _joined(parts, np.zeros(k), d, single=True)


def _boosted(regressors: Sequence[Any], d: int, k: int) -> Packed:
    """Histogram gradient boosting."""
    parts, b = [], np.zeros(k)
    for place, one in enumerate(regressors):
        b[place] = float(np.ravel(one._baseline_prediction)[0])
        for stage in one._predictors:
            nodes = stage[0].nodes
            value = np.zeros((len(nodes), k))
            value[:, place] = nodes["value"]
            ends = (nodes["left"].astype(np.int64), nodes["right"].astype(np.int64))
            leaf = nodes["is_leaf"].astype(bool)
            parts.append((nodes["feature_idx"], nodes["num_threshold"], *ends, leaf, value))
    return _joined(parts, b, d, single=False)


def _joined(parts: Sequence[tuple], b: np.ndarray, d: int, single: bool) -> Packed:
    """All trees in one set of arrays; `single`: features are rounded to single precision first."""
    counts = [len(part[0]) for part in parts]
    roots = np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.int64)
    left, right = [], []
    for root, count, (_, _, to_left, to_right, leaf, _) in zip(roots, counts, parts, strict=True):
        own = root + np.arange(count)
        left.append(np.where(leaf, own, root + to_left))
        right.append(np.where(leaf, own, root + to_right))
    feature, threshold, value = (np.concatenate([part[i] for part in parts]) for i in (0, 1, 5))
    _check(feature.max() < d, True)
    ints = [len(feature), len(roots), len(b), single, feature, *left, *right, roots]
    return _packed(TREES, ints, [threshold, value, b], len(b), d)


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
