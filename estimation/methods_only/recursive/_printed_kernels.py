"""Compiled recursion of the multi-innovation methods as they are printed.

It stands apart because its matrix products and its solver take seconds to compile, which the corrected methods do not
need.
"""

from __future__ import annotations

import numpy as np
from numba import types

from ....models.compilation import A1, A2, JIT, f8, i8, njit


@njit(types.void(A1, A2, i8, i8, i8, f8, A1, A2, A2), **JIT)
def multi_innovation_as_printed(y, h, first, size, length, omega, theta, p, path):
    """Eq 22 and 23 of paper 004 literally: z = sin(omega E), and P + P Phi (I + Phi'P Phi)^-1 Phi'P."""
    d = theta.size
    for end in range(first + size, y.size + 1, size):
        start = max(0, end - length * size)
        phi = h[start:end]
        z = np.sin(omega * (y[start:end] - phi @ theta))
        projected = phi @ p
        p += projected.T @ np.linalg.solve(np.eye(end - start) + projected @ phi.T, projected)
        theta += p @ (phi.T @ z)
        for k in range(end - size, end):
            for j in range(d):
                path[k - first, j] = theta[j]
