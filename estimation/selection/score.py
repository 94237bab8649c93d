"""The score of units that took no part in a fit, and the standard error of a difference of two.

    score = 1/2 sum_c log sum_k (s_kc + f_kc)

s_kc are sums of squared errors of left-out unit k in channel c, f_kc those of an error that counts as none: the score
is the sum over channels of the logarithm of the root mean square error.  A fall by .05 is five percent in one channel.
Source: concentrated likelihood, Seber and Wild 1989, section 5.1; jackknife, Efron and Stein 1981.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

TINY = 1e-300


class Fall(NamedTuple):
    """By how much the score falls, and its jackknife standard error over units."""

    gain: float
    error: float


def share_of_errors(gain: float, error: float) -> tuple[float, float]:
    """Share by which errors fall with a fall of their logarithm, negative where they rise, and its standard error."""
    left = float(np.exp(-gain))
    return 1.0 - left, left * error


def score(squares: np.ndarray) -> np.ndarray:
    """Score (...) of squares (..., K, C), eq. 8 of docs/mathematics/pieces.md."""
    return 0.5 * np.log(np.maximum(squares.sum(axis=-2), TINY)).sum(axis=-1)


def jackknife(values: np.ndarray) -> np.ndarray:
    """Standard error (...) of a statistic from its values (K, ...) without each of K units; infinite for one.

    Eq. 9 of docs/mathematics/pieces.md.
    """
    n = len(values)
    if n < 2:
        return np.full(values.shape[1:], np.inf)
    return np.sqrt((n - 1.0) / n * np.sum((values - values.mean(axis=0)) ** 2, axis=0))


def fall(old: np.ndarray, new: np.ndarray, floor: np.ndarray) -> Fall:
    """Fall of the score from squares `old` to `new`, (K, C) each, with the squares of no error, floor (K, C)."""
    both = np.stack([old + floor, new + floor])
    without = both.sum(axis=1, keepdims=True) - both  # sums without each unit, (2, K, C)
    each = 0.5 * np.log(np.maximum(without, TINY)).sum(axis=2)
    before, after = score(both)
    return Fall(float(before - after), float(jackknife(each[0] - each[1])))
