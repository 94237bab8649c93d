"""Linear algebra that ends, by one thread: some builds of LAPACK never return from a matrix that holds an infinity.

Every function of a matrix raises LinAlgError where a number of it is not finite, and takes the options of the function
of numpy.linalg that it stands for.
"""

from __future__ import annotations

import sys
from functools import lru_cache
from typing import Any

import numpy as np


@lru_cache(maxsize=1)
def _thread_pools(modules: int) -> Any:
    """The thread pools of the loaded libraries, looked for again (some ms) when there are more modules."""
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


def blas_limited() -> Any:
    """Context with one linear-algebra thread: for matrices as small or narrow as ours a second one only costs time."""
    return _thread_pools(len(sys.modules)).limit(limits=1)


def finite(matrix: np.ndarray) -> np.ndarray:
    """The matrix itself, for decompositions.

    Raises
    ------
    LinAlgError : a number is not finite.
    """
    if not np.isfinite(matrix).all():
        raise np.linalg.LinAlgError("a matrix is not finite")
    return matrix


def lstsq(matrix: np.ndarray, values: np.ndarray, rcond: float | None = None) -> np.ndarray:
    """Solution (k,) or (k, m) of least squares and least size of matrix (n, k) and values (n,) or (n, m)."""
    return np.linalg.lstsq(finite(matrix), values, rcond=rcond)[0]


def ridge(matrix: np.ndarray, values: np.ndarray, penalty: float) -> np.ndarray:
    """Solution (k, m) of least squares of matrix (n, k) and values (n, m), and of penalty times the solution."""
    k = matrix.shape[1]
    return lstsq(np.vstack([matrix, penalty * np.eye(k)]), np.vstack([values, np.zeros((k, values.shape[1]))]))


def pinv(matrix: np.ndarray, **options: Any) -> np.ndarray:
    """Pseudo-inverse (..., k, n) of a matrix (..., n, k)."""
    return np.linalg.pinv(finite(matrix), **options)


def svd(matrix: np.ndarray, **options: Any) -> Any:
    """Singular value decomposition of a matrix (..., n, k)."""
    return np.linalg.svd(finite(matrix), **options)


def matrix_rank(matrix: np.ndarray) -> Any:
    """Rank (...) of a matrix (..., n, k)."""
    return np.linalg.matrix_rank(finite(matrix))


def condition_number(matrix: np.ndarray) -> float:
    """Ratio of the largest to the least singular value of a matrix (n, k)."""
    return float(np.linalg.cond(finite(matrix)))


def information_inverse(matrix: np.ndarray, rcond: float) -> np.ndarray:
    """Pseudo-inverse (k, k) of an information matrix, computed in units that make its diagonal one.

    A parameter that changes nothing (0 on the diagonal) has no covariance: its row is zero.

    Raises
    ------
    LinAlgError : a number is not finite.
    """
    diagonal = np.diag(matrix)
    scale = np.where(diagonal > 0.0, 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0)), 0.0)
    outer = np.outer(scale, scale)
    return pinv(matrix * outer, rcond=rcond, hermitian=True) * outer
