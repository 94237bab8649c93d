"""Paired comparison of two methods on the same records."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ....reporting.leaderboard.equivalence import holm as stepped_down

LEVEL = 0.05
"""Level of the tests, after Holm's correction."""
MATERIAL = 0.01
"""A median ratio nearer to 1 than this is no difference, however regular it is."""
USELESS = 1.0
"""Error of a constant prediction, in standard deviations: a method with more has failed."""
BETTER, WORSE, EQUAL, BOTH_FAIL = OUTCOMES = ("better", "worse", "no difference", "both fail")


def paired(own: np.ndarray, other: np.ndarray, lost: float) -> dict[str, float]:
    """Errors (n,) of a method and of its baseline on the same n records; `lost` is the error of a run that failed.

    error, baseline : medians;  ratio : median of own/other;  won : share of records with the smaller error, ties as
    half;  effect : matched-pairs rank-biserial correlation, 1 where the method always has the smaller error;
    p : two-sided Wilcoxon signed-rank test on the logarithms (Pratt's ranks);  failed, baseline_failed : shares.
    """
    difference = np.log(own / other)
    return {
        "error": float(np.median(own)),
        "baseline": float(np.median(other)),
        "ratio": float(np.exp(np.median(difference))),
        "won": float(np.mean(difference < 0.0) + 0.5 * np.mean(difference == 0.0)),
        "effect": _rank_biserial(difference),
        "p": _wilcoxon(difference),
        "failed": float(np.mean(own >= lost)),
        "baseline_failed": float(np.mean(other >= lost)),
    }


def _wilcoxon(difference: np.ndarray) -> float:
    from scipy.stats import wilcoxon

    if not difference.any():
        return 1.0
    found: Any = wilcoxon(difference, zero_method="pratt", method="asymptotic")
    return float(found.pvalue)


def _rank_biserial(difference: np.ndarray) -> float:
    from scipy.stats import rankdata

    ranks = np.asarray(rankdata(np.abs(difference)))
    ranks[difference == 0.0] = 0.0
    total = float(ranks.sum())
    return float((ranks[difference < 0.0].sum() - ranks[difference > 0.0].sum()) / total) if total else 0.0


def holm(p: Mapping[str, float]) -> dict[str, float]:
    """Adjusted p values (Holm 1979, Scand. J. Statist. 6, 65): each may be compared with the level by itself."""
    return dict(zip(p, stepped_down([*p.values()]).tolist(), strict=True))


def outcome(adjusted: float, ratio: float, error: float, baseline: float) -> str:
    """What a comparison shows, at `LEVEL` and beyond `MATERIAL`; error, baseline : medians of both."""
    if min(error, baseline) > USELESS:
        return BOTH_FAIL
    if adjusted >= LEVEL or abs(np.log(ratio)) <= np.log1p(MATERIAL):
        return EQUAL
    return BETTER if ratio < 1.0 else WORSE
