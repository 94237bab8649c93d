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
    """sum_i a_i exp(-gamma |x - v_i|^2) + b of each output: vectors (m, d), weights (m,), gamma and b."""

    outputs: tuple[tuple[np.ndarray, np.ndarray, float, float], ...]

    def __call__(self, x: np.ndarray) -> np.ndarray:
        return np.column_stack([self._one(x, *output) for output in self.outputs])

    @staticmethod
    def _one(x: np.ndarray, vectors: np.ndarray, weights: np.ndarray, gamma: float, b: float) -> np.ndarray:
        found = np.empty(len(x))
        for start in range(0, len(x), 256):
            difference = x[start : start + 256, None, :] - vectors[None, :, :]
            square = np.einsum("ijk,ijk->ij", difference, difference)
            found[start : start + 256] = np.exp(-gamma * square) @ weights + b
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
    depth: int
    b: np.ndarray
    single: bool
    """Whether features are rounded to single precision first."""

    def __call__(self, x: np.ndarray) -> np.ndarray:
        x = x.astype(np.float32).astype(float) if self.single else x
        return np.vstack([self._block(x[start : start + 256]) for start in range(0, len(x), 256)])

    def _block(self, x: np.ndarray) -> np.ndarray:
        rows = np.arange(len(x))[:, None]
        node = np.tile(self.roots, (len(x), 1))
        for _ in range(self.depth):
            node = np.where(x[rows, self.feature[node]] <= self.threshold[node], self.left[node], self.right[node])
        return self.value[node].sum(axis=1) + self.b


def compiled(regressors: Sequence[Any], x: np.ndarray) -> Callable[[np.ndarray], np.ndarray] | None:
    """A fast form (B, d) -> (B, k) of fitted regressors, checked on rows x (N, d); None if no form agrees."""
    expected = stacked(regressors, x)
    for form in (_affine, _kernel, _forest, _boosted):
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


def _kernel(regressors: Sequence[Any], k: int) -> Kernel:
    outputs = [
        (one.support_vectors_, np.ravel(one.dual_coef_), float(one._gamma), float(one.intercept_[0]))
        for one in regressors
    ]
    return Kernel(tuple(outputs))


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
            parts.append(
                (feature, tree.threshold, tree.children_left, tree.children_right, leaf, value, tree.max_depth)
            )
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
            leaf, depth = nodes["is_leaf"].astype(bool), int(nodes["depth"].max())
            parts.append((nodes["feature_idx"], nodes["num_threshold"], *ends, leaf, value, depth))
    return _joined(parts, b, single=False)


def _joined(parts: Sequence[tuple], b: np.ndarray, single: bool) -> Trees:
    """All trees in one set of arrays."""
    counts = [len(part[0]) for part in parts]
    roots = np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.int64)
    left, right = [], []
    for root, count, (_, _, to_left, to_right, leaf, *_) in zip(roots, counts, parts, strict=True):
        own = root + np.arange(count)
        left.append(np.where(leaf, own, root + to_left))
        right.append(np.where(leaf, own, root + to_right))
    feature, threshold = (np.concatenate([part[i] for part in parts]) for i in (0, 1))
    value = np.concatenate([part[5] for part in parts])
    ends = np.concatenate(left).astype(np.int64), np.concatenate(right).astype(np.int64)
    depth = max(part[6] for part in parts)
    return Trees(feature.astype(np.int64), threshold.astype(float), *ends, value, roots, depth, b, single)
