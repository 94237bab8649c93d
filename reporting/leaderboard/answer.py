"""Which method: one sentence a case of knowledge.  The page computes the same in `templates/leaderboard_ranking.js`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..numbers import percent
from .contest import Contest
from .equivalence import EQUAL, FEW, NEAR, WORSE, Rival, rivals
from .standings import CASES, median

FASTER = 1.2
"""A method is faster from this ratio of times on."""
NAMED = 4
"""Methods that are as good which a sentence names."""
GOOD, FLOOR = 1.3, 0.01
"""An error is good below this multiple of the least of all methods; free-run errors below the floor count as it."""
SHORT, ENOUGH = 4, 0.95
"""Most methods of a short list, and the share of problems with a good one among them from which it is whole."""
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
    useless = "" if error < 1.0 or board.criterion != "prediction" else USELESS
    others = rivals(board)
    told = _others(places[0].method, others) if others else ""
    listed = _listed(board) if board.criterion == "prediction" else ""
    return f"{useless}{places[0].method} (error {number(error)}, {number(seconds)} s){told}.{listed}"


def shortlist(board: Contest, methods: Sequence[str]) -> tuple[list[str], float]:
    """The few methods of which one is good in most problems, the first of the ranking first; and the share of these.

    methods : those that may be listed, in the order of the ranking.
    """
    errors = np.where(np.isnan(board.errors), np.inf, np.maximum(board.errors, FLOOR))
    places = [board.methods.index(name) for name in methods]
    least = errors.min(axis=1)
    good = (errors[:, places] < GOOD * least[:, None]) & np.isfinite(least)[:, None]
    chosen, covered = [0], good[:, 0]
    while covered.mean() < ENOUGH and len(chosen) < SHORT:
        gains = (good & ~covered[:, None]).sum(axis=0)
        if not gains.max():
            break
        chosen.append(int(gains.argmax()))
        covered = covered | good[:, chosen[-1]]
    return [methods[place] for place in chosen], float(covered.mean())


def _listed(board: Contest) -> str:
    """Which methods to compare where no single one is good in most problems."""
    names, share = shortlist(board, [place.method for place in board.order() if not place.partial])
    if len(names) < 2:
        return ""
    return (
        f" Compare {', '.join(names)} on a record kept back: one of them errs less than {GOOD:g} times the least in "
        f"{percent(share)} of {len(board.errors)} problems."
    )


def _others(best: str, others: Sequence[Rival]) -> str:
    """What is said of the other methods: exactly one of four."""
    good = [other for other in others if other.verdict == EQUAL]
    if good:
        more = f" and {len(good) - NAMED} more" if len(good) > NAMED else ""
        named = f"{', '.join(other.method for other in good[:NAMED])}{more}"
        return f"; as good (error below {NEAR:g} times, {good[0].sample}): {named}; fast choice: {_fast(best, good)}"
    least = min(others, key=lambda other: round(other.error_ratio, 9))
    near = f"{least.method} errs {number(least.error_ratio)} times as much"
    if all(other.verdict == FEW for other in others):
        most = max(others, key=lambda other: int(other.sample.split()[0]))
        return f"; too few problems ({most.sample}) to say which are as good; the nearest, {near}"
    if least.verdict == WORSE:
        return f"; no other is as good: the nearest, {near} ({least.sample})"
    return f"; none is shown to be as good, and it is not settled: {near} ({least.sample})"


def _fast(best: str, good: Sequence[Rival]) -> str:
    fast = max(good, key=lambda other: round(other.speed, 9))
    if not fast.speed >= FASTER:
        return f"{best} itself"
    return f"{fast.method}, {number(fast.speed)} times as fast with {number(fast.error_ratio)} times the error"


def number(value: float) -> str:
    """Two significant digits, without trailing zeros: `0.012`, `3.4`, `120`."""
    if not np.isfinite(value):
        return "infinitely many" if value > 0.0 else "unknown"
    mantissa, exponent = f"{value:.1e}".split("e")
    power = int(exponent)
    if not -4 <= power <= 6:
        return f"{mantissa}e{power}"
    return f"{float(mantissa) * 10.0**power:.{max(0, 1 - power)}f}"
