"""Compiled predictions and free runs of learnt functions (numba; imported only when they run).

A learnt function is `compiled.Packed`: a form and two flat arrays, whose layout is said at each form.
"""

from __future__ import annotations

import numpy as np
from numba import types

from ....models.compilation import A1, A2, I1, JIT, b1, f8, i8, njit
from ....models.drivers import RHS, rk4_sample
from .compiled import KERNELS, NETWORKS, OUTSIDE, TERMS


@njit(types.void(I1, A1, A1, A1, A1), **JIT)
def _trees(ints, floats, x, rounded, found):
    """Sum of decision trees and constants b (k,).

    ints : nodes, trees, k, whether features are rounded to single precision first; then feature, left and right
    (nodes,) and roots (trees,).  A leaf is its own successor.  floats : threshold (nodes,), left where x <= threshold;
    value (nodes, k); b (k,).
    """
    nodes, trees, k = ints[0], ints[1], ints[2]
    for i in range(x.size):
        rounded[i] = np.float32(x[i]) if ints[3] else x[i]
    feature, left, right = ints[4 : 4 + nodes], ints[4 + nodes : 4 + 2 * nodes], ints[4 + 2 * nodes : 4 + 3 * nodes]
    value = floats[nodes:]
    for i in range(k):
        found[i] = value[nodes * k + i]
    for root in ints[4 + 3 * nodes : 4 + 3 * nodes + trees]:
        node = root
        while left[node] != node:
            node = left[node] if rounded[feature[node]] <= floats[node] else right[node]
        for i in range(k):
            found[i] += value[node * k + i]


@njit(types.void(I1, A1, A1, A1), **JIT)
def _terms(ints, floats, x, found):
    """Weighted products of features.

    ints : terms, factors of each, k; then factors (terms, factors), see `terms.evaluate`.  floats : weights (terms, k).
    """
    count, width, k = ints[0], ints[1], ints[2]
    found[:k] = 0.0
    for t in range(count):
        term = 1.0
        for m in range(width):
            i = ints[3 + t * width + m]
            if i > x.size:
                term *= abs(x[i - 1 - x.size])
            elif i > 0:
                term *= x[i - 1]
        for i in range(k):
            found[i] += term * floats[t * k + i]


@njit(types.void(I1, A1, A1, A1), **JIT)
def _kernels(ints, floats, x, found):
    """sum_j a_j exp(-|s x - v_j|^2) + b, one after the other.

    ints : how many, then the number of vectors m and of outputs k of each.  floats : for each the scales s (d,), the
    vectors v (m, d), the weights a (m, k) and b (k,).
    """
    d, at, first = x.size, 0, 0
    for part in range(ints[0]):
        m, k = ints[1 + 2 * part], ints[2 + 2 * part]
        vectors, weights = at + d, at + d + m * d
        for i in range(k):
            found[first + i] = floats[weights + m * k + i]
        for j in range(m):
            square = 0.0
            for i in range(d):
                square += (floats[at + i] * x[i] - floats[vectors + j * d + i]) ** 2
            share = np.exp(-square)
            for i in range(k):
                found[first + i] += share * floats[weights + j * k + i]
        at, first = weights + (m + 1) * k, first + k


@njit(types.void(I1, A1, A1, A1, A1), **JIT)
def _networks(ints, floats, x, work, found):
    """Layers of tanh units and a linear last layer, one network after the other.

    ints : networks, then for each its number of layers and its sizes from the features to the outputs.  floats : for
    each layer its weights (d, m) and biases (m,).  work has twice as many elements as the largest layer.
    """
    half = work.size // 2
    at, place, first = 0, 1, 0
    for _ in range(ints[0]):
        layers = ints[place]
        before, after = work[:half], work[half:]
        before[: x.size] = x
        for layer in range(layers):
            d, m = ints[place + 1 + layer], ints[place + 2 + layer]
            for j in range(m):
                total = floats[at + d * m + j]
                for i in range(d):
                    total += before[i] * floats[at + i * m + j]
                after[j] = total if layer == layers - 1 else np.tanh(total)
            at += (d + 1) * m
            before, after = after, before
        for j in range(ints[place + 1 + layers]):
            found[first + j] = before[j]
        first, place = first + ints[place + 1 + layers], place + 2 + layers


@njit(types.void(i8, I1, A1, A1, A1, A1), **JIT)
def _value(form, ints, floats, x, work, found):
    """The outputs (k,) of a packed function at features x (d,)."""
    if form == TERMS:
        _terms(ints, floats, x, found)
    elif form == KERNELS:
        _kernels(ints, floats, x, found)
    elif form == NETWORKS:
        _networks(ints, floats, x, work, found)
    else:
        _trees(ints, floats, x, work, found)


@njit(types.void(i8, I1, A1, A2, A1, A2), **JIT)
def rows(form, ints, floats, x, work, found):
    """Outputs (B, k) of a packed function at rows x (B, d)."""
    for row in range(x.shape[0]):
        _value(form, ints, floats, x[row], work, found[row])


@njit(b1(A2, A1, A1), **JIT)
def _scale(scaling, x, scaled):
    """Write features x (d,) scaled by mean and scale (2, d); false where they are far from all training rows."""
    for i in range(x.size):
        scaled[i] = (x[i] - scaling[0, i]) * scaling[1, i]
        if abs(scaled[i]) > OUTSIDE:
            return False
    return True


@njit(b1(i8, I1, A1, A2, A1, A1, A1, A1), **JIT)
def _unscaled(form, ints, floats, scaling, y_scale, x, work, found):
    """As `_value` of features scaled by `_scale`, results times y_scale (k,); false far away.

    The first d elements of work are the scaled features.
    """
    scaled = work[: x.size]
    if not _scale(scaling, x, scaled):
        return False
    _value(form, ints, floats, scaled, work[x.size :], found)
    for i in range(y_scale.size):
        found[i] *= y_scale[i]
    return True


@njit(types.void(i8, I1, A1, A2, A1, A1, i8, f8, A2, A2), **JIT)
def difference_run(form, ints, floats, scaling, y_scale, work, lags, step_s, driven, z):
    """Outputs z (K, k) from its first row under lagged inputs (K, nu lags): z' = z + step f; nan where it diverges."""
    k, known = z.shape[1], z.shape[1] * lags
    x, rate = np.empty(known + driven.shape[1]), np.empty(k)
    for j in range(lags):
        x[j * k : (j + 1) * k] = z[0]
    z[1:] = np.nan
    for step in range(z.shape[0] - 1):
        x[known:] = driven[step]
        if not _unscaled(form, ints, floats, scaling, y_scale, x, work, rate):
            return
        for i in range(known - 1, k - 1, -1):
            x[i] = x[i - k]
        for i in range(k):
            x[i] = z[step, i] + step_s * rate[i]
        if not np.isfinite(x[:k]).all():
            return
        z[step + 1] = x[:k]


@njit(types.void(i8, I1, A1, A2, A1, A1, f8, I1, RHS, A1, f8, i8, A2, A2), **JIT)
def hybrid_run(form, ints, floats, scaling, y_scale, work, share, columns, rhs, theta, dt, substeps, inputs, states):
    """States (N, n) from the first row: RK4 of the model plus share dt f(states[columns], inputs).

    Rows from where it diverges on are nan: what is far from all training rows is not recorded.
    """
    n, nu, k = states.shape[1], inputs.shape[1], columns.size
    x, features, rate, steps = states[0].copy(), np.empty(k + nu), np.zeros(k), np.empty(3 * n + nu)
    states[1:] = np.nan
    for row in range(states.shape[0] - 1):
        if share != 0.0:
            for i in range(k):
                features[i] = x[columns[i]]
            features[k:] = inputs[row]
            if not _unscaled(form, ints, floats, scaling, y_scale, features, work, rate):
                return
        rk4_sample(rhs, x, inputs[row], inputs[row + 1], theta, dt, substeps, steps)
        for i in range(k):
            x[columns[i]] += share * dt * rate[i]
            features[i] = x[columns[i]]
        features[k:] = inputs[row + 1]
        if not np.isfinite(x).all() or (share != 0.0 and not _scale(scaling, features, work)):
            return
        states[row + 1] = x
