"""Tests of methods against each other on the same problems.

Arrays are errors (n problems, m methods) without nan; infinite errors are larger than every other, and equal among
each other.  Benavoli, Corani & Mangili 2016, J. Mach. Learn. Res. 17(5): pairs are tested by signed ranks, since mean
ranks depend on the other methods.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

LEVEL = 0.05
Alternative = Literal["two-sided", "less", "greater"]
EXACT_PAIRS = 50
"""Pairs without ties up to which the distribution of the signed ranks is computed exactly."""


def log_ratios(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """log(first / second) (n,) of positive errors; 0 where both are infinite."""
    with np.errstate(all="ignore"):
        return np.where(np.isinf(first) & np.isinf(second), 0.0, np.log(first) - np.log(second))


def signed_rank(ratios: np.ndarray, alternative: Alternative = "two-sided") -> float:
    """p of the Wilcoxon signed-rank test on log ratios (n,), infinite ones included; 1 where all are zero.

    Zeros are left out.  Exact up to `EXACT_PAIRS` ratios without ties, else by the normal approximation with ties
    taken into account, without correction for continuity.
    """
    from scipy.stats import rankdata, wilcoxon

    d = ratios[np.abs(ratios) > 1e-12]
    if not d.size:
        return 1.0
    ranks = rankdata(np.abs(d).round(9))
    ties = np.unique(ranks).size < ranks.size
    method = "exact" if d.size <= EXACT_PAIRS and not ties else "asymptotic"
    found = wilcoxon(np.sign(d) * ranks, method=method, correction=False, alternative=alternative)
    return float(np.asarray(found)[1])


def holm(p: Sequence[float] | np.ndarray) -> np.ndarray:
    """p-values (m,) adjusted for their number by Holm's step-down procedure (1979, Scand. J. Stat. 6, 65)."""
    p = np.asarray(p, dtype=float)
    order = np.argsort(p, kind="stable")
    stepped = np.minimum(1.0, np.maximum.accumulate(p[order] * (p.size - np.arange(p.size))))
    adjusted = np.empty_like(p)
    adjusted[order] = stepped
    return adjusted
