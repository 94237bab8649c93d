"""Which methods are as good as another one: a signed-rank test with a region of practical equivalence.

A method is as good where its error is shown to be below `NEAR` times that of the best, and worse where it is shown to
be above; else it is not settled.  Each is a one-sided Wilcoxon test of log(error ratio / NEAR) at `LEVEL`.  That no
difference is found is no sign of equality: few problems settle nothing.

Problems of one ship are no independent draws.  From `LEAST` ships on, each ship counts once, with the median over its
problems.  For fewer ships, problems are the sample, the sentence is about these ships only, and it must hold for each
of them.  For a single problem its seeds are the sample.  Schuirmann 1987, J. Pharmacokinet. Biopharm. 15, 657-680
(one-sided tests against a margin); Berger 1982, Technometrics 24, 295-300 (a claim for each of several groups).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from .contest import Contest
from .standings import median

# ---- Tests of methods against each other on the same problems.
# Arrays are errors (n problems, m methods) without nan; infinite errors are larger than every other, and equal among
# each other. Benavoli, Corani & Mangili 2016, J. Mach. Learn. Res. 17(5): pairs are tested by signed ranks, since
# mean ranks depend on the other methods.

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


NEAR = 1.25
"""Errors up to this multiple of the best are equal in practice."""
LEAST = 5
"""Sample below which no one-sided signed-rank test can have p < 0.05."""
SINGLE = {"ships": "ship", "problems": "problem", "seeds of one problem": "seed of one problem"}
EQUAL, WORSE, OPEN, FEW = "as good", "worse", "not settled", "too few"


@dataclass(frozen=True)
class Rival:
    """A method against the best one.

    Attributes
    ----------
    error_ratio : its error over the best's, median of the sample.
    verdict : `EQUAL`, `WORSE`, `OPEN`, or `FEW` where the sample is too small for any verdict.
    p : of the verdict's test; of a method that is not settled that of being as good; nan without a test.
    speed : median ratio of the times of a fit, best / its.
    sample : what was tested, such as `9 ships`.
    least_p : the smallest p that an exact signed-rank test of this sample can have.
    """

    method: str
    index: int
    error_ratio: float
    verdict: str
    p: float
    speed: float
    sample: str
    least_p: float


def rivals(board: Contest) -> list[Rival]:
    """The other methods of the first group against the best, in the order of the ranking."""
    places = [place for place in board.order() if not place.partial]
    return [against(board, places[0].index, place.index) for place in places[1:]]


def against(board: Contest, best: int, other: int) -> Rival:
    """One method against another, both by their indices."""
    groups, unit = samples(board, best, other)
    values = np.concatenate(groups) if groups else np.empty(0)
    ratio = _exp(median(values))
    verdict, p = (FEW, float("nan")) if min((g.size for g in groups), default=0) < LEAST else _verdict(groups)
    if verdict == EQUAL and not max(ratio, _shown(board, best, other)) <= NEAR:
        verdict = OPEN
    told = f"{values.size} {unit if values.size != 1 else SINGLE[unit]}"
    least_p = max((0.5**group.size for group in groups), default=1.0)
    return Rival(board.methods[other], other, ratio, verdict, p, _speed(board, best, other), told, least_p)


def samples(board: Contest, best: int, other: int) -> tuple[list[np.ndarray], str]:
    """Log ratios of the errors other / best in independent groups, and what each of them is of."""
    first, second = board.errors[:, best], board.errors[:, other]
    both = ~np.isnan(first) & ~np.isnan(second)
    ratios, ships = log_ratios(second[both], first[both]), board.problems["vessel"].astype(str).to_numpy()[both]
    names = list(dict.fromkeys(ships))
    if len(names) >= LEAST:
        return [
            np.nan_to_num([median(ratios[ships == name]) for name in names], posinf=np.inf, neginf=-np.inf)
        ], "ships"
    if ratios.size == 1:
        one, two = board.runs[both][0, best], board.runs[both][0, other]
        known = ~np.isnan(one) & ~np.isnan(two)
        return [log_ratios(two[known], one[known])], "seeds of one problem"
    return [ratios[ships == name] for name in names], "problems"


def _verdict(groups: list[np.ndarray]) -> tuple[str, float]:
    """What holds in each of the groups: the largest of their p-values counts."""
    margin = np.log(NEAR)
    less, more = (max(signed_rank(group - margin, way) for group in groups) for way in ("less", "greater"))
    return (WORSE, more) if more < LEVEL else (EQUAL if less < LEVEL else OPEN, less)


def _shown(board: Contest, best: int, other: int) -> float:
    """The ratio of the median errors that a reader sees, over the problems that both have."""
    one, two = board.errors[:, best], board.errors[:, other]
    both = ~np.isnan(one) & ~np.isnan(two)
    return _exp(float(log_ratios(np.array([median(two[both])]), np.array([median(one[both])]))[0]))


def _exp(value: float) -> float:
    with np.errstate(over="ignore"):
        return float(np.exp(value))


def _speed(board: Contest, best: int, other: int) -> float:
    times = board.times[:, [best, other]]
    times = times[~np.isnan(times).any(axis=1) & (times > 0.0).all(axis=1)]
    return median(times[:, 0] / times[:, 1])
