"""Which method: one sentence a case of knowledge, and how stable the ranking is.

The page computes the same in `templates/leaderboard_ranking.js`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..numbers import percent
from .contest import Contest
from .equivalence import EQUAL, FEW, NEAR, WORSE, Rival, rivals
from .standings import BOOTSTRAP_DRAWS, BOOTSTRAP_SEED, CASES, median

FASTER = 1.2
"""A method is faster from this ratio of times on."""
NAMED = 4
"""Methods that are as good which a sentence names."""
GOOD, FLOOR = 1.3, 0.01
"""An error is good below this multiple of the least of all methods; free-run errors below the floor count as it."""
SHORT, ENOUGH = 5, 0.95
"""Most methods of a short list, and the share of problems with a good one among them from which it is whole."""
FLOORS, LITTLE = ("mean", "straight-line"), 0.5
"""Methods of the kind floor, and the share of their error above which a method has little skill."""
MEAN = 1.0
"""Free-run error of the mean of the record."""
USELESS = "None predicts better than the mean of the record (error 1); least bad: "
NOTHING = "No two methods were compared under these conditions."


def headlines(board: Contest) -> list[tuple[str, str]]:
    """Case of knowledge (`CASES`) and answer, for every case that has problems: they are never put together."""
    present = set(board.problems["case"].astype(str))
    return [(case, sentence(board.where({"case": case}))) for case in CASES if case in present] or [("", NOTHING)]


def answer(board: Contest) -> str:
    """The headlines as lines of text; a single one without its case."""
    found = headlines(board)
    return found[0][1] if len(found) == 1 else "\n".join(f"{begin(case)}: {text}" for case, text in found)


def begin(case: str) -> str:
    """A case as it stands at the beginning of a line."""
    return case[:1].upper() + case[1:]


def sentence(board: Contest) -> str:
    """The best method, those that are as good, and the fast choice among them."""
    places = [place for place in board.order() if not place.partial]
    if not places:
        return NOTHING
    best = places[0].index
    error, seconds = median(board.errors[:, best]), median(board.times[:, best])
    if not np.isfinite(error):
        return "No method predicts these problems with a finite error."
    others = rivals(board)
    told = _others(places[0].method, others) if others else ""
    figures = f"{places[0].method} (error {two_digits(error)}, {two_digits(seconds)} s; {_problems(board, best)})"
    if board.criterion != "prediction":
        return f"{figures}{told}."
    useless = "" if error < MEAN else USELESS
    return f"{useless}{figures}{'' if useless else _little_skill(board, best)}{told}.{_listed(board)}"


def _problems(board: Contest, method: int) -> str:
    """How many problems of how many ships a method's error is the median of."""
    known = ~np.isnan(board.errors[:, method])
    counts = (int(known.sum()), "problem"), (int(board.problems["vessel"][known].nunique()), "ship")
    return " of ".join(f"{count} {word}{'s' if count != 1 else ''}" for count, word in counts)


def _little_skill(board: Contest, best: int) -> str:
    """Against what an error is no great one: the better of the floors, over the problems that both have."""
    if board.methods[best] in FLOORS:
        return ", which identifies nothing"
    found = []
    for name in FLOORS:
        if name in board.methods:
            floor, own = board.errors[:, board.methods.index(name)], board.errors[:, best]
            both = ~np.isnan(floor) & ~np.isnan(own)
            found += [(median(floor[both]), name, median(own[both]))] if both.any() else []
    error, name, own = min(found, default=(np.inf, "", 0.0))
    if not own > LITTLE * error:
        return ""
    return f", which is little skill: {name}, without any identification, errs {two_digits(error)}"


def shortlist(board: Contest, methods: Sequence[str]) -> tuple[list[str], float, int]:
    """A few methods of which one is good in most problems, the first of the ranking first; and what the list is worth.

    methods : those that may be listed, in the order of the ranking.

    The second is the share of problems with a good method in a list made of the problems of all other ships, nan for a
    single ship; the third the number of problems, without those of a single method and those that nobody predicts
    better than by the record's mean.  The list is the shortest with `ENOUGH` of them, else the best of at most `SHORT`.
    """
    errors = np.where(np.isnan(board.errors), np.inf, np.maximum(board.errors, FLOOR))
    useful = (errors.min(axis=1) < MEAN) & ((~np.isnan(board.errors)).sum(axis=1) > 1)
    ships = board.problems["vessel"].to_numpy(str)
    errors, ships = errors[useful], ships[useful]
    if not len(errors):
        return list(methods[:1]), np.nan, 0
    good = errors[:, [board.methods.index(name) for name in methods]] < GOOD * errors.min(axis=1)[:, None]
    listed, each = _covering(good), np.unique(ships)
    sets = [(good[ships == ship], good[ships != ship]) for ship in each] if len(each) > 1 else [(good, good)]
    hits = np.concatenate([np.logical_or.accumulate(own[:, _covering(rest)], axis=1) for own, rest in sets])
    shares = hits.mean(axis=0)
    last = int(np.argmax(np.minimum(shares, ENOUGH)))
    share = float(shares[last]) if len(each) > 1 else np.nan
    return [methods[place] for place in listed[: last + 1]], share, len(good)


def _covering(good: np.ndarray) -> list[int]:
    """At most `SHORT` columns that together are true in many rows (P, M): the first one, then always the one with most.

    A row counts a quarter each time that it is covered, so that the list does not rest on single columns.
    """
    weights, chosen = np.ones(len(good)), [0]
    while len(chosen) < min(SHORT, good.shape[1]):
        weights = np.where(good[:, chosen[-1]], 0.25 * weights, weights)
        gains = weights @ good
        gains[chosen] = -1.0
        chosen.append(int(gains.argmax()))
    return chosen


def _listed(board: Contest) -> str:
    """Which methods to compare where no single one is good in most problems."""
    names, share, count = shortlist(board, [place.method for place in board.order() if not place.partial])
    if len(names) < 2:
        return ""
    told = f" Compare {', '.join(names)} on a record kept back"
    if np.isnan(share):
        return f"{told}."
    return (
        f"{told}: of a list made without the ship, one errs less than {GOOD:g} times the least in {percent(share)} of "
        f"{count} problems."
    )


def _others(best: str, others: Sequence[Rival]) -> str:
    """What is said of the other methods: exactly one of four."""
    good = [other for other in others if other.verdict == EQUAL]
    if good:
        more = f" and {len(good) - NAMED} more" if len(good) > NAMED else ""
        named = f"{', '.join(other.method for other in good[:NAMED])}{more}"
        return f"; as good (error below {NEAR:g} times, {_sample(good[0])}): {named}; fast choice: {_fast(best, good)}"
    least = min(others, key=lambda other: round(other.error_ratio, 9))
    near = f"{least.method} errs {two_digits(least.error_ratio)} times as much"
    if all(other.verdict == FEW for other in others):
        most = max(others, key=lambda other: int(other.sample.split()[0]))
        return f"; too few problems ({most.sample}) to say which are as good; the nearest, {near}"
    if least.verdict == WORSE:
        return f"; no other is as good: the nearest, {near} ({_sample(least)})"
    return f"; none is shown to be as good, and it is not settled: {near} ({_sample(least)})"


def _sample(other: Rival) -> str:
    """What a verdict rests on, and how small its p can be."""
    return f"{other.sample}, with which p is {two_digits(other.least_p)} at the least"


def _fast(best: str, good: Sequence[Rival]) -> str:
    fast = max(good, key=lambda other: round(other.speed, 9))
    if not fast.speed >= FASTER:
        return f"{best} itself"
    return f"{fast.method}, {two_digits(fast.speed)} times as fast with {two_digits(fast.error_ratio)} times the error"


def two_digits(value: float) -> str:
    """Two significant digits, without trailing zeros: `0.012`, `3.4`, `120`."""
    if not np.isfinite(value):
        return "infinitely many" if value > 0.0 else "unknown"
    mantissa, exponent = f"{value:.1e}".split("e")
    power = int(exponent)
    if not -4 <= power <= 6:
        return f"{mantissa}e{power}"
    return f"{float(mantissa) * 10.0**power:.{max(0, 1 - power)}f}"


# ---- How stable a ranking is: it is made again from ships drawn with replacement.

FEWEST_SHIPS = 2
MENTIONED = 0.05
"""Share of draws from which on a method that comes first is named."""


def stability(board: Contest) -> tuple[dict[str, float], int, tuple[int, int]] | None:
    """How stable the first group of a contest is; None for fewer than `FEWEST_SHIPS` ships or two methods.

    Returns
    -------
    Method -> share of the draws in which it is first, the most frequent one first; the number of ships; the place
    (low, high) of the first method at 90 %.
    """
    full = [place for place in board.order() if not place.partial]
    ships = board.problems["vessel"].astype(str).to_numpy()
    names = list(dict.fromkeys(ships))
    if len(full) < 2 or len(names) < FEWEST_SHIPS:
        return None
    means = _mean_ranks(board.ranks()[:, [place.index for place in full]], ships == np.array(names)[:, None])
    first = np.bincount(means.argmin(axis=1), minlength=len(full)) / BOOTSTRAP_DRAWS
    place = np.sort(1 + (means < means[:, :1] - 1e-9).sum(axis=1))
    order = [i for i in np.argsort(-first, kind="stable") if first[i] >= MENTIONED or i == 0]
    firsts = {full[i].method: float(first[i]) for i in order}
    tail = BOOTSTRAP_DRAWS // 20
    return firsts, len(names), (int(place[tail]), int(place[-1 - tail]))


def stability_sentences(board: Contest) -> list[str]:
    """What drawing the ships anew says of the first method, for every case of what is known with several ships."""
    told = []
    for case in CASES:
        own = board.where({"case": case})
        if (found := stability(own)) is None:
            continue
        (shares, ships, (low, high)), first = found, own.order()[0].method
        others = [f"{name} ({percent(share)})" for name, share in shares.items() if name != first]
        place = f"place {low}" if low == high else f"places {low} to {high}"
        told.append(
            f"{begin(case)}: Of rankings from {ships} ships drawn with replacement, {first} is first in "
            f"{percent(shares.get(first, 0.0))} ({place} in 90 %){'; else ' * bool(others)}{', '.join(others)}."
        )
    return told


def _mean_ranks(ranks: np.ndarray, of: np.ndarray) -> np.ndarray:
    """Mean ranks (draws, m) of ranks (P, m) over ships drawn with replacement; of (s, P) says which ship's they are.

    Infinite where none of a method's ships is drawn.
    """
    known = ~np.isnan(ranks)
    sums, counts = of @ np.where(known, ranks, 0.0), of @ known.astype(float)
    n = len(of)
    weights = np.random.default_rng(BOOTSTRAP_SEED).multinomial(n, np.full(n, 1.0 / n), size=BOOTSTRAP_DRAWS)
    with np.errstate(all="ignore"):
        means = (weights @ sums) / (weights @ counts)
    return np.where(np.isnan(means), np.inf, means)
