"""Whitening of series that are measured with white noise on a random walk (the local-level model)."""

from __future__ import annotations

import numpy as np

LONGEST_GAP = 5
"""Samples that may be lost of a channel before its integral starts anew after them."""


def whitened_steps(series: np.ndarray, joined: np.ndarray, white: float, walk: np.ndarray) -> np.ndarray:
    """Steps of series (m, T) between samples, whitened: their noise has unit variance and is uncorrelated.

    The noise of a step is e[k] - e[k - 1] + w[k], e white with standard deviation `white`, w with `walk` (T - 1,): its
    covariance is tridiagonal, and its Cholesky factor bidiagonal.

    joined (T - 1,) : steps that count; where one does not, the series starts anew.

    Returns
    -------
    (m, J) for the J steps that count.
    """
    from scipy.linalg import cholesky_banded, solve_banded

    steps = np.diff(series, axis=1)[:, joined]
    place = np.flatnonzero(joined)
    if not place.size:
        return steps
    bands = np.empty((2, place.size))
    bands[0] = 2.0 * white**2 + walk[place] ** 2
    bands[1, :-1] = np.where(np.diff(place) == 1, -(white**2), 0.0)
    bands[1, -1] = 0.0
    factor = cholesky_banded(bands, lower=True)
    return solve_banded((1, 0), factor, steps.T).T
