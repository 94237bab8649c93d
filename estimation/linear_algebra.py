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
