"""Compiled predictions of learnt functions (numba; imported only when they run)."""

from __future__ import annotations

from numba import types

from ...models.compilation import A1, A2, I1, JIT, i8, njit

I2 = types.Array(i8, 2, "C")


@njit(types.void(A2, I1, A1, I1, I1, A2, I1, A2), **JIT)
def sum_of_trees(x, feature, threshold, left, right, value, roots, total):
    """Add to total (B, k) the values of the leaves that rows x (B, d) reach from each of the roots (T,).

    Node arrays as in `compiled.Trees`; a leaf is its own successor.
    """
    for row in range(x.shape[0]):
        for root in roots:
            node = root
            while left[node] != node:
                node = left[node] if x[row, feature[node]] <= threshold[node] else right[node]
            for k in range(value.shape[1]):
                total[row, k] += value[node, k]


@njit(types.void(A2, I2, A2, A2), **JIT)
def sum_of_terms(x, factors, weights, total):
    """Add to total (B, k): weights (T, k) times terms with factors (T, m), see `terms.evaluate`, of rows x (B, d)."""
    d = x.shape[1]
    for row in range(x.shape[0]):
        for t in range(factors.shape[0]):
            term = 1.0
            for m in range(factors.shape[1]):
                i = factors[t, m]
                if i > d:
                    term *= abs(x[row, i - 1 - d])
                elif i > 0:
                    term *= x[row, i - 1]
            for k in range(weights.shape[1]):
                total[row, k] += term * weights[t, k]
