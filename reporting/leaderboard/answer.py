"""Which method: one sentence from a contest.  The page computes the same in `templates/leaderboard_ranking.js`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .contest import Contest
from .paired import LEVEL, holm, log_ratios, signed_rank
from .standings import median

LEAST_PAIRS = 6
"""Pairs below which no signed-rank test can have p < 0.05."""
NEAR, FASTER = 1.25, 1.2
"""An error up to this multiple of the best is near it; a method is faster from this ratio of times on."""
USELESS = "None predicts better than the mean of the record (error 1); least bad: "


@dataclass(frozen=True)
class Rival:
    """A method against the best one: Holm-corrected p, median ratio of errors, median ratio of times (best / its)."""

    method: str
    p: float
    error_ratio: float
    speed: float
    pairs: int


def rivals(board: Contest) -> list[Rival]:
    """The other methods of the first group against the best, in the order of the ranking.

    Pairs are problems; where there are fewer than `LEAST_PAIRS` of them, runs of single seeds.
    """
    places = [place for place in board.order() if not place.partial]
    found = []
    for place in places[1:]:
        first, second = _paired(board, places[0].index, place.index)
        found.append((place, first, second))
    p = holm([signed_rank(second, first) for _, first, second in found])
    return [
        Rival(place.method, float(p[i]), _ratio(second, first), _speed(board, places[0].index, place.index), first.size)
        for i, (place, first, second) in enumerate(found)
    ]


def answer(board: Contest) -> str:
    """The best method and, if there is one, the fastest that is as good."""
    places = [place for place in board.order() if not place.partial]
    if not places:
        return "No two methods were compared under these conditions."
    best = places[0].index
    errors = board.errors[:, best][~np.isnan(board.errors[:, best])]
    error, seconds = median(errors), median(board.times[:, best])
    if not np.isfinite(error):
        return "No method predicts these problems with a finite error."
    useless = "" if error < 1.0 or board.criterion != "prediction" else USELESS
    head = f"{useless}{places[0].method} (error {number(error)}, {number(seconds)} s)"
    others = rivals(board)
    pairs = max((other.pairs for other in others), default=0)
    near = [other for other in others if other.error_ratio <= NEAR]
    if pairs < LEAST_PAIRS:
        few = "1 paired run is" if pairs == 1 else f"{pairs} paired runs are"
        return f"{head}; {few} too few for a test{_near(near)}."
    good = [other for other in near if other.p >= LEVEL]
    if not good:
        least = min(others, key=lambda other: round(other.error_ratio, 9))
        told = f"{least.method} errs {number(least.error_ratio)} times as much"
        if least.p >= LEVEL:
            return f"{head}; {told}, but no test tells the two apart (p {_p(least.p)})."
        return f"{head}; no other is as good: {told} (p {_p(least.p)})."
    fast = max(good, key=lambda other: round(other.speed, 9))
    chosen = fast if fast.speed >= FASTER else good[0]
    more = f"; {len(good) - 1} more {'is' if len(good) == 2 else 'are'} as good" if len(good) > 1 else ""
    return f"{head}; {chosen.method} is as good (p {_p(chosen.p)}){_faster(chosen)}{more}."


def number(value: float) -> str:
    """Two significant digits, without trailing zeros: `0.012`, `3.4`, `120`."""
    if not np.isfinite(value):
        return "infinitely many" if value > 0.0 else "unknown"
    mantissa, exponent = f"{value:.1e}".split("e")
    power = int(exponent)
    if not -4 <= power <= 6:
        return f"{mantissa}e{power}"
    return f"{float(mantissa) * 10.0**power:.{max(0, 1 - power)}f}"


def _paired(board: Contest, best: int, other: int) -> tuple[np.ndarray, np.ndarray]:
    """Errors of both methods on the problems that they share, or on single runs where these are few."""
    first, second = board.errors[:, best], board.errors[:, other]
    if (~np.isnan(first) & ~np.isnan(second)).sum() < LEAST_PAIRS:
        first, second = board.runs[:, best].ravel(), board.runs[:, other].ravel()
    both = ~np.isnan(first) & ~np.isnan(second)
    return first[both], second[both]


def _ratio(errors: np.ndarray, best: np.ndarray) -> float:
    """Median of errors / best; infinite where the method fails."""
    with np.errstate(over="ignore"):
        return float(np.exp(median(log_ratios(errors, best))))


def _speed(board: Contest, best: int, other: int) -> float:
    times = board.times[:, [best, other]]
    times = times[~np.isnan(times).any(axis=1) & (times > 0.0).all(axis=1)]
    return median(times[:, 0] / times[:, 1])


def _near(near: list[Rival]) -> str:
    quick = [other for other in near if other.speed >= FASTER]
    if not quick:
        return ""
    fast = max(quick, key=lambda other: round(other.speed, 9))
    return f"; {fast.method} errs {number(fast.error_ratio)} times as much and is {number(fast.speed)} times as fast"


def _faster(other: Rival) -> str:
    if other.speed >= FASTER:
        return f" and {number(other.speed)} times as fast"
    return f" but {number(1.0 / other.speed)} times as slow" if other.speed <= 1.0 / FASTER else ""


def _p(value: float) -> str:
    return "< 0.001" if value < 0.001 else f"= {value:.{2 if value >= 0.01 else 3}f}"
