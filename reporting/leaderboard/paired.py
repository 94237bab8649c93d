"""Tests of methods against each other on the same problems.

Arrays are errors (n problems, m methods) without nan; infinite errors are larger than every other, and equal among
each other.  Demsar 2006, J. Mach. Learn. Res. 7, 1-30; Benavoli, Corani & Mangili 2016, J. Mach. Learn. Res. 17(5).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
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


@dataclass(frozen=True)
class PairedComparison:
    """All methods of a block against each other.

    Attributes
    ----------
    methods : best mean rank first;  mean_ranks : (m,) of them;  n : problems.
    friedman_p : that all methods are equal; nan for fewer than three methods or two problems.
    p : (m, m), Holm-corrected signed-rank tests.
    groups : runs (first, last) of neighbouring places that no test tells apart, none inside another.
    critical_difference : of mean ranks, Nemenyi's at `LEVEL`; nan for fewer than two methods.
    """

    methods: tuple[str, ...]
    mean_ranks: np.ndarray
    n: int
    friedman_p: float
    p: np.ndarray
    groups: tuple[tuple[int, int], ...]
    critical_difference: float


def compare(errors: np.ndarray, methods: Sequence[str]) -> PairedComparison:
    """Friedman's test, and every pair by signed ranks with Holm's correction."""
    from scipy.stats import rankdata

    n, m = errors.shape
    mean = rankdata(errors, axis=1).mean(axis=0) if n else np.full(m, np.nan)
    order = np.lexsort((np.array(methods, dtype=str), mean.round(9)))
    errors, mean, names = errors[:, order], mean[order], tuple(str(methods[int(i)]) for i in order)
    pairs = list(combinations(range(m), 2))
    raw = holm([signed_rank(log_ratios(errors[:, i], errors[:, j])) if n else 1.0 for i, j in pairs])
    p = np.ones((m, m))
    for (i, j), value in zip(pairs, raw, strict=True):
        p[i, j] = p[j, i] = value
    return PairedComparison(names, mean, n, friedman(errors), p, _groups(p), critical_difference(n, m))


def friedman(errors: np.ndarray) -> float:
    """p that all methods are equal, by Friedman's test with ties; nan for fewer than three methods or two problems."""
    from scipy.stats import friedmanchisquare, rankdata

    n, m = errors.shape
    if n < 2 or m < 3:
        return float("nan")
    ranks = rankdata(errors, axis=1)
    if np.all(ranks == ranks[:, :1]):
        return 1.0
    return float(friedmanchisquare(*ranks.T).pvalue)


def critical_difference(n: int, m: int, level: float = LEVEL) -> float:
    """Nemenyi's difference of two of m mean ranks over n problems that is significant at the level."""
    from scipy.stats import studentized_range

    if n < 1 or m < 2:
        return float("nan")
    return float(studentized_range.ppf(1.0 - level, m, np.inf) / np.sqrt(2.0) * np.sqrt(m * (m + 1) / (6.0 * n)))


def _groups(p: np.ndarray) -> tuple[tuple[int, int], ...]:
    """Longest runs of neighbours in which every pair has p >= `LEVEL`."""
    m, found = len(p), []
    for first in range(m):
        last = first
        while last + 1 < m and (p[first : last + 1, last + 1] >= LEVEL).all():
            last += 1
        if last > first and not any(a <= first and last <= b for a, b in found):
            found.append((first, last))
    return tuple(found)
