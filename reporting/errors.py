"""Free-run errors of records, and their statistics."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ..diagnosis.result import Trace


@np.errstate(over="ignore", invalid="ignore")
def residual(trace: Trace, name: str, run: str) -> np.ndarray:
    """Measured minus simulated (T,), SI, of the run `before` or `after`; headings wrapped to +- pi."""
    error = trace.measured[name] - getattr(trace, run)[name]
    return error - 2.0 * np.pi * np.round(error / (2.0 * np.pi)) if name == "heading_rad" else error


def rms(values: np.ndarray) -> float:
    """Root mean square of what is finite; nan if nothing is."""
    known = values[np.isfinite(values)]
    if not known.size:
        return math.nan
    largest = float(np.abs(known).max()) or 1.0
    return largest * float(np.sqrt(np.mean((known / largest) ** 2)))  # the square of what is huge is not finite


@np.errstate(over="ignore")
def mean(values: np.ndarray) -> float:
    """Mean of what is finite; nan if nothing is."""
    known = values[np.isfinite(values)]
    return float(known.mean()) if known.size else math.nan


@np.errstate(over="ignore", invalid="ignore")
def correlation(time: np.ndarray, error: np.ndarray, lag_s: float) -> float:
    """Correlation of an error (T,) with itself `lag_s` seconds later; nan for records that are too short."""
    lag = max(1, round(lag_s / float(np.median(np.diff(time)))))
    if lag >= error.size // 2:
        return math.nan
    early, late = error[:-lag], error[lag:]
    known = np.isfinite(early) & np.isfinite(late)
    if known.sum() < 10 or min(np.std(early[known]), np.std(late[known])) == 0.0:
        return math.nan
    return float(np.corrcoef(early[known], late[known])[0, 1])


@np.errstate(over="ignore", invalid="ignore")
def banded(time: np.ndarray, error: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Power spectral density (bands,) of an error (T,), averaged in frequency bands; nan where a band is empty."""
    from scipy.signal import periodogram

    known = np.isfinite(error)
    if known.sum() < 32:
        return np.full(edges.size - 1, np.nan)
    step = float(np.median(np.diff(time)))
    grid = np.arange(time[known][0], time[known][-1], step)
    frequency, density = periodogram(np.interp(grid, time[known], error[known]), 1.0 / step, "hann", detrend="constant")
    place = np.digitize(frequency, edges) - 1
    return np.array([density[place == k].mean() if (place == k).any() else np.nan for k in range(edges.size - 1)])
