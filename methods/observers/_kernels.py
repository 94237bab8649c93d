"""Compiled recursions of the observers (numba; imported only when one of them runs)."""

from __future__ import annotations

from numba import njit, types

f8 = types.float64
A1, A2 = types.Array(f8, 1, "C"), types.Array(f8, 2, "C")
JIT = {"cache": True, "error_model": "numpy", "nogil": True, "fastmath": {"contract", "nsz", "arcp"}}


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
