"""Fitted regressors as plain arrays, for free runs, which predict one row at a time.

scikit-learn's `predict` takes up to milliseconds per call, even for one row.  The forms here take some microseconds;
each is only used where it agrees with `predict` on rows of the training set.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

AGREEMENT = 1e-9
"""Relative and absolute difference up to which a form agrees with `predict`."""


class Affine(NamedTuple):
    """x W + b with w (d, k) and b (k,)."""

    w: np.ndarray
    b: np.ndarray

    def __call__(self, x: np.ndarray) -> np.ndarray:
        return x @ self.w + self.b


class Kernel(NamedTuple):
    """sum_i a_i exp(-|s x - v_i|^2) + b: scales s (d,), vectors v (m, d), weights a (m, k) and b (k,) of outputs."""

    outputs: tuple[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray], ...]

    def __call__(self, x: np.ndarray) -> np.ndarray:
        return np.column_stack([self._one(x, *output) for output in self.outputs])

    @staticmethod
    def _one(x: np.ndarray, scale: np.ndarray, vectors: np.ndarray, weights: np.ndarray, b: np.ndarray) -> np.ndarray:
        found = np.empty((len(x), weights.shape[1]))
        for start in range(0, len(x), 256):
            difference = (x[start : start + 256] * scale)[:, None, :] - vectors[None, :, :]
            square = np.einsum("ijk,ijk->ij", difference, difference)
            found[start : start + 256] = np.exp(-square) @ weights + b
        return found


class Network(NamedTuple):
    """Layers of tanh units and a linear last layer: weights (d, m) and biases (m,) of each."""

    layers: tuple[tuple[np.ndarray, np.ndarray], ...]

    def __call__(self, x: np.ndarray) -> np.ndarray:
        for w, b in self.layers[:-1]:
            x = np.tanh(x @ w + b)
        w, b = self.layers[-1]
        return x @ w + b


class Terms(NamedTuple):
    """Weighted products of features: factors (T, m), see `terms.evaluate`, and weights (T, k)."""

    factors: np.ndarray
    weights: np.ndarray

    def __call__(self, x: np.ndarray) -> np.ndarray:
        from ._kernels import sum_of_terms

        found = np.zeros((len(x), self.weights.shape[1]))
        sum_of_terms(np.ascontiguousarray(x), self.factors, self.weights, found)
        return found


class Trees(NamedTuple):
    """Sum of decision trees with roots (T,), plus a constant b (k,).

    Node arrays: feature, left and right (nodes,), where a leaf is its own successor; threshold (nodes,): left where
    x <= threshold; value (nodes, k).
    """

    feature: np.ndarray
    threshold: np.ndarray
    left: np.ndarray
    right: np.ndarray
    value: np.ndarray
    roots: np.ndarray
    b: np.ndarray
    single: bool
    """Whether features are rounded to single precision first."""

    def __call__(self, x: np.ndarray) -> np.ndarray:
        from ._kernels import sum_of_trees

        x = x.astype(np.float32).astype(float) if self.single else np.ascontiguousarray(x, float)
        found = np.tile(self.b, (len(x), 1))
        sum_of_trees(x, self.feature, self.threshold, self.left, self.right, self.value, self.roots, found)
        return found


def compiled(regressors: Sequence[Any], x: np.ndarray) -> Callable[[np.ndarray], np.ndarray] | None:
    """A fast form (B, d) -> (B, k) of fitted regressors, checked on rows x (N, d); None if no form agrees."""
    expected = stacked(regressors, x)
    for form in (_affine, _terms, _kernel, _ridge_kernel, _gaussian_process, _network, _forest, _boosted):
        try:
            found = form(regressors, expected.shape[1])
            if found is not None and np.allclose(found(x), expected, rtol=AGREEMENT, atol=AGREEMENT):
                return found
        except (AttributeError, IndexError, KeyError, TypeError, ValueError):
            continue  # the regressors do not have this form
    return None


def stacked(regressors: Sequence[Any], x: np.ndarray) -> np.ndarray:
    """Predictions (N, k) by scikit-learn itself, of one regressor for all outputs or of one for each."""
    return np.column_stack([np.asarray(one.predict(x), float).reshape(len(x), -1) for one in regressors])


def _affine(regressors: Sequence[Any], k: int) -> Affine:
    w = [np.atleast_2d(one.coef_) for one in regressors]
    b = [np.ravel(one.intercept_) * np.ones(len(rows)) for one, rows in zip(regressors, w, strict=True)]
    return Affine(np.vstack(w).T.astype(float), np.concatenate(b).astype(float))


def _terms(regressors: Sequence[Any], k: int) -> Terms:
    (one,) = regressors
    return Terms(np.ascontiguousarray(one.terms_), np.ascontiguousarray(one.weights_))


def _kernel(regressors: Sequence[Any], k: int) -> Kernel:
    """Support vector machines."""
    outputs = [(one._gamma, one.support_vectors_, one.dual_coef_.T, one.intercept_) for one in regressors]
    return Kernel(tuple(_isotropic(*output) for output in outputs))


def _ridge_kernel(regressors: Sequence[Any], k: int) -> Kernel:
    """Kernel ridge regression."""
    outputs = [(one.gamma, one.X_fit_, one.dual_coef_.reshape(len(one.X_fit_), -1), 0.0) for one in regressors]
    return Kernel(tuple(_isotropic(*output) for output in outputs))


def _isotropic(gamma: float, vectors: np.ndarray, weights: np.ndarray, b: Any):
    scale = np.full(vectors.shape[1], np.sqrt(gamma))
    return scale, vectors * scale, np.ascontiguousarray(weights), np.zeros(weights.shape[1]) + b


def _gaussian_process(regressors: Sequence[Any], k: int) -> Kernel:
    """Gaussian processes with a constant times a squared exponential, plus noise."""
    outputs = []
    for one in regressors:
        smooth = one.kernel_.k1
        scale = np.sqrt(0.5) / (smooth.k2.length_scale * np.ones(one.X_train_.shape[1]))
        weights = smooth.k1.constant_value * one.alpha_.reshape(len(one.X_train_), -1) * one._y_train_std
        outputs.append((scale, one.X_train_ * scale, weights, np.zeros(weights.shape[1]) + one._y_train_mean))
    return Kernel(tuple(outputs))


def _network(regressors: Sequence[Any], k: int) -> Network | None:
    (one,) = regressors
    return Network(tuple(zip(one.coefs_, one.intercepts_, strict=True))) if one.activation == "tanh" else None


def _forest(regressors: Sequence[Any], k: int) -> Trees:
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
    return _joined(parts, np.zeros(k), single=True)


def _boosted(regressors: Sequence[Any], k: int) -> Trees:
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
    return _joined(parts, b, single=False)


def _joined(parts: Sequence[tuple], b: np.ndarray, single: bool) -> Trees:
    """All trees in one set of arrays."""
    counts = [len(part[0]) for part in parts]
    roots = np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.int64)
    left, right = [], []
    for root, count, (_, _, to_left, to_right, leaf, _) in zip(roots, counts, parts, strict=True):
        own = root + np.arange(count)
        left.append(np.where(leaf, own, root + to_left))
        right.append(np.where(leaf, own, root + to_right))
    feature, threshold = (np.concatenate([part[i] for part in parts]) for i in (0, 1))
    value = np.concatenate([part[5] for part in parts])
    ends = np.concatenate(left).astype(np.int64), np.concatenate(right).astype(np.int64)
    return Trees(feature.astype(np.int64), threshold.astype(float), *ends, value, roots, b, single)
