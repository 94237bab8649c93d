"""Sizes that may differ between records: mean, interval and test of heterogeneity."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .tails import f_tail, normal_quantile, student_quantile


class Mean(NamedTuple):
    """Mean over records with its interval, the standard deviation between records, and the p-value of equal sizes."""

    value: float
    low: float
    high: float
    between: float
    p_equal: float


def random_effects_mean(values: np.ndarray, spread: np.ndarray, level: float = 0.90, dof: float = np.inf) -> Mean:
    """Mean of sizes (R,) with standard errors (R,), by DerSimonian and Laird, interval by Hartung and Knapp.

    dof : degrees of freedom of each standard error.  The interval is at least as wide as that of equal sizes
    (the modification of Roever, Knapp and Friede 2015, doi 10.1186/s12874-015-0091-1), and for one record its own.
    """
    weight = 1.0 / np.maximum(spread, 1e-300) ** 2
    n, whole = values.size, float(weight.sum())
    fixed = float(weight @ values / whole)
    own = 0.5 * (1.0 + level)
    if n == 1:
        half = float((student_quantile(own, dof) if np.isfinite(dof) else normal_quantile(own)) * spread[0])
        return Mean(fixed, fixed - half, fixed + half, 0.0, 1.0)
    q = float(weight @ (values - fixed) ** 2)
    p = f_tail(q / (n - 1), n - 1, n * dof if np.isfinite(dof) else 1e9)
    between = max(q - (n - 1), 0.0) / (whole - float(weight @ weight) / whole)
    weight = 1.0 / (np.maximum(spread, 1e-300) ** 2 + between)
    mean = float(weight @ values / weight.sum())
    scatter = float(weight @ (values - mean) ** 2) / (n - 1)
    half = float(student_quantile(own, n - 1) * np.sqrt(max(scatter, 1.0) / weight.sum()))
    return Mean(mean, mean - half, mean + half, float(np.sqrt(between)), p)
