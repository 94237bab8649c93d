"""Noise, gaps and integrals of series."""

from __future__ import annotations

import numpy as np

from ..models.errors import CannotFit

WHITE = 0.6
"""Least ratio of noise as seen in fifth and in third differences: a smooth motion has much less in the fifth."""


def sensor_sd(values: np.ndarray) -> float:
    """Standard deviation of white noise on a smooth series (N,), from its third differences.

    Robust (median absolute deviation), so kinks and outliers do not count; 0 for fewer than 8 differences.
    """
    third = np.diff(values, 3)
    third = third[np.isfinite(third)]
    if third.size < 8:
        return 0.0
    spread = 1.4826 * np.median(np.abs(third)) or np.std(third)  # coarsely quantised series have a median of 0
    return float(spread / np.sqrt(20.0))


def white_noise(values: np.ndarray) -> float:
    """Standard deviation of white noise on a series (N,); 0 where what is left of it is motion or rounding."""
    third, fifth = _spread(values, 3, 20.0), _spread(values, 5, 252.0)
    return third if third > 0.0 and fifth > WHITE * third else 0.0


def _spread(values: np.ndarray, order: int, weight: float) -> float:
    x = np.diff(values, order)
    x = x[np.isfinite(x)]
    return float(1.4826 * np.median(np.abs(x)) / np.sqrt(weight)) if x.size >= 20 else 0.0


def bridged(values: np.ndarray, time_s: np.ndarray) -> np.ndarray:
    """values (N,) with gaps filled linearly, and at the ends by the nearest value; the same array if it has no gap.

    Raises
    ------
    CannotFit : no value is finite.
    """
    known = np.isfinite(values)
    if not known.any():
        raise CannotFit("an input channel has no samples")
    if known.all():
        return np.asarray(values, float)
    return np.interp(time_s, time_s[known], values[known])


def lagged(values: np.ndarray, lag_s: float, step_s: float) -> np.ndarray:
    """What follows values (N,) at even steps with a time constant, z_dot = (x - z)/T, from the first of them; the
    values themselves where T = 0."""
    from scipy.signal import lfilter

    if lag_s == 0.0:
        return values
    share = 1.0 - np.exp(-step_s / lag_s)
    return lfilter([share], [1.0, share - 1.0], values, zi=[(1.0 - share) * values[0]])[0]


def integral(rates: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Integrals (..., T) of rates (..., T), 0 at the start."""
    steps = np.diff(time) * (rates[..., 1:] + rates[..., :-1]) / 2.0
    return np.concatenate([np.zeros((*rates.shape[:-1], 1), rates.dtype), np.cumsum(steps, axis=-1)], axis=-1)
