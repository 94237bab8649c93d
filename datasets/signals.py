"""Noise, gaps and integrals of series, and changes of channels over windows of samples."""

from __future__ import annotations

from math import comb
from typing import TYPE_CHECKING

import numpy as np

from ..models.errors import CannotFit

if TYPE_CHECKING:
    from .record import Record

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
    third, fifth = noise_in(values, 3, 20), noise_in(values, 5, 20)
    return third if third > 0.0 and fifth > WHITE * third else 0.0


def noise_in(values: np.ndarray, order: int, fewest: int = 1) -> float:
    """White noise (sd) of a series (N,) from its differences of an order, in which a smooth motion vanishes; 0 for
    fewer than so many differences."""
    x = np.diff(values, order)
    x = x[np.isfinite(x)]
    return float(1.4826 * np.median(np.abs(x)) / np.sqrt(comb(2 * order, order))) if x.size >= fewest else 0.0


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


# ---- Changes over windows of samples.

WINDOW, FEWEST = 10, 20
"""Fewest samples over which changes are compared, and fewest changes."""
SHORT = 5
"""Samples missing in a row that are filled in."""
NEAR = 0.15
"""How near to their median half of the ratios must be."""


def integral_over_gaps(values: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Trapezoidal integral (N,) that is nan where values are missing and goes on after them."""
    with np.errstate(all="ignore"):
        steps = np.nan_to_num(np.diff(time) * (values[1:] + values[:-1]) / 2.0)
        return np.where(np.isfinite(values), np.concatenate([[0.0], np.cumsum(steps)]), np.nan)


def over_short_gaps(values: np.ndarray) -> np.ndarray:
    """values (N,) with up to SHORT missing samples in a row filled linearly."""
    known = np.flatnonzero(np.isfinite(values))
    if known.size in (0, values.size):
        return values
    rows = np.arange(values.size)
    after = np.minimum(np.searchsorted(known, rows), known.size - 1)
    before = np.maximum(np.searchsorted(known, rows, side="right") - 1, 0)
    near = (known[after] - known[before] <= SHORT + 1) & (rows > known[0]) & (rows < known[-1])
    return np.where(near, np.interp(rows, known, values[known]), values)


def changes(record: Record, values: np.ndarray) -> np.ndarray:
    """Changes (M,) of a series over windows of WINDOW samples or more, nan where a sample between is missing."""
    window = max(1, min(max(WINDOW, record.n // 40), record.n // 10))
    after_gap = np.concatenate([[False], np.diff(record.time_s) > 1.5 * record.dt])
    gaps = np.concatenate([[0], np.cumsum(~np.isfinite(values) | after_gap)])
    with np.errstate(all="ignore"):
        change = values[window:] - values[:-window]
    return np.where(gaps[window + 1 :] == gaps[1 : record.n + 1 - window], change, np.nan)


def median_ratio(first: np.ndarray, second: np.ndarray) -> float | None:
    """Median ratio of two series of changes (M,) in the windows with the larger changes; None where half of the
    windows do not agree on it."""
    known = np.isfinite(first) & np.isfinite(second) & (second != 0.0)
    if known.sum() < FEWEST:
        return None
    first, second = first[known], second[known]
    large = np.abs(second) >= np.median(np.abs(second))
    with np.errstate(all="ignore"):
        ratio = first[large] / second[large]
        median = float(np.median(ratio))
        agreed = np.mean(np.abs(ratio / median - 1.0) < NEAR)
    return median if np.isfinite(median) and agreed > 0.5 else None
