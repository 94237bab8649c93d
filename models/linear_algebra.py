"""Guards of linear algebra."""

from __future__ import annotations

import numpy as np


def finite(matrix: np.ndarray) -> np.ndarray:
    """The matrix itself, for decompositions: some builds of LAPACK never return from one that is not finite.

    Raises
    ------
    LinAlgError : a number is not finite.
    """
    if not np.isfinite(matrix).all():
        raise np.linalg.LinAlgError("a matrix is not finite")
    return matrix


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
    return np.linalg.pinv(finite(matrix * outer), rcond=rcond, hermitian=True) * outer
