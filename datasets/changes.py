"""Changes of channels over windows of samples, and how two series of changes compare."""

from __future__ import annotations

import numpy as np

from .record import Record

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
