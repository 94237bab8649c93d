"""Compiled recursions of the observers (numba; imported only when one of them runs)."""

from __future__ import annotations

from math import isfinite, log

from numba import types

from ...models.compilation import A1, A2, A3, I1, JIT, f8, i8, njit


@njit(types.void(A2, A2, A2, A2, A1, A2), **JIT)
def linear_recursion(a, now, ahead, inputs, x, states):
    """x[k+1] = a x[k] + now u[k] + ahead u[k+1]; a (n, n), now and ahead (n, m), inputs (N, m), states (N, n).

    x (n,) is the state at the first sample and ends as that at the last.
    """
    n, m = now.shape
    for k in range(inputs.shape[0]):
        if k > 0:
            for i in range(n):
                total = 0.0
                for j in range(n):
                    total += a[i, j] * states[k - 1, j]
                for j in range(m):
                    total += now[i, j] * inputs[k - 1, j] + ahead[i, j] * inputs[k, j]
                x[i] = total
        for i in range(n):
            states[k, i] = x[i]


@njit(types.UniTuple(f8, 3)(A2, A2, I1, A1, A2, A1, A2, A2, A3, A3, A2, A2, i8), **JIT)
def kalman(f, q, columns, noise, outputs, x, p, ahead_x, ahead_p, gains, errors, variances, skip):
    """Linear Kalman filter with outputs (N, c), nan = gap, that measure states `columns` with variances `noise` (c,).

    Starts from x (n,) and p (n, n) at the first sample and overwrites them.  What a smoother needs is written to
    ahead_x (N, n), ahead_p (N, n, n), gains (N, c, n), and the innovations' errors and variances (N, c), unless these
    are empty.  Returns the sum of the log variances, that of the squared normalised innovations and their number, all
    without the first `skip`.
    """
    n, count = x.size, 0
    keep = ahead_x.shape[0] > 0
    logs, squares, used = 0.0, 0.0, 0.0
    work, moved, gain = f * 0.0, x * 0.0, x * 0.0
    for k in range(outputs.shape[0]):
        if k > 0:
            for i in range(n):
                moved[i] = 0.0
                for j in range(n):
                    moved[i] += f[i, j] * x[j]
                    total = 0.0
                    for m in range(n):
                        total += f[i, m] * p[m, j]
                    work[i, j] = total
            for i in range(n):
                x[i] = moved[i]
                for j in range(i + 1):
                    total = q[i, j]
                    for m in range(n):
                        total += work[i, m] * f[j, m]
                    p[i, j] = total
                    p[j, i] = total
        if keep:
            for i in range(n):
                ahead_x[k, i] = x[i]
                for j in range(n):
                    ahead_p[k, i, j] = p[i, j]
        for c in range(columns.size):
            value, s = outputs[k, c], columns[c]
            if not isfinite(value):
                if keep:
                    variances[k, c] = -1.0
                continue
            error, variance = value - x[s], p[s, s] + noise[c]
            for i in range(n):
                gain[i] = p[i, s] / variance
            for i in range(n):
                x[i] += gain[i] * error
            for i in range(n):  # Joseph form for one output
                for j in range(n):
                    work[i, j] = p[i, j] - gain[i] * p[s, j]
            for i in range(n):
                for j in range(i + 1):
                    total = work[i, j] - work[i, s] * gain[j] + gain[i] * noise[c] * gain[j]
                    p[i, j] = total
                    p[j, i] = total
            count += 1
            if count > skip:
                logs += log(variance)
                squares += error * error / variance
                used += 1.0
            if keep:
                errors[k, c], variances[k, c] = error, variance
                for i in range(n):
                    gains[k, c, i] = gain[i]
    return logs, squares, used


@njit(types.void(A2, I1, A2, A3, A3, A2, A2, A2), **JIT)
def smooth(f, columns, ahead_x, ahead_p, gains, errors, variances, smoothed):
    """States (N, n) given all outputs, from what `kalman` kept: Rauch-Tung-Striebel in Bryson and Frazier's form.

    The adjoint is computed backwards in time; no covariance is inverted.
    """
    n = f.shape[0]
    adjoint, before = f[0] * 0.0, f[0] * 0.0
    for k in range(ahead_x.shape[0] - 1, -1, -1):
        for c in range(columns.size - 1, -1, -1):
            if variances[k, c] <= 0.0:
                continue
            s, total = columns[c], 0.0
            for i in range(n):
                total += gains[k, c, i] * adjoint[i]
            adjoint[s] -= total + errors[k, c] / variances[k, c]
        for i in range(n):
            total = ahead_x[k, i]
            for j in range(n):
                total -= ahead_p[k, i, j] * adjoint[j]
            smoothed[k, i] = total
        for i in range(n):
            before[i] = 0.0
            for j in range(n):
                before[i] += f[j, i] * adjoint[j]
        for i in range(n):
            adjoint[i] = before[i]
