"""Is the page's advice good?  Its rule is asked in fresh situations, and what it names is compared with all methods.

What the regret of an advice is, `EXPLAINED` says.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...bench.situations import SEEDS, Situation
from ..numbers import MISSING, number, percent
from ..tables import Column, Table, field, make_table, markdown
from .contest import Contest
from .standings import CASES, median

GOOD = 1.3
"""Regret below which an advice is good."""
FLOOR = 0.01
EXPLAINED = (
    "The regret of an advice is the error of the method that it names over the least error of all methods there; it is "
    "infinite (a dash) where that method fails or diverges. Errors are medians over "
    f"{SEEDS} draws of the noise. A method that does not apply is passed over. "
    f"Errors below {FLOOR:g} of what the record varies by count as {FLOOR:g}: nobody needs the difference."
)
CONDITIONS = ("case", "noise", "disturbance", "model", "sampling", "excitation")
"""What the page is asked with, the most important first."""
LEAST_SHIPS = 2
"""Ships that an answer must rest on, else a condition is left open."""
KNOWN, UNKNOWN, _ = CASES


@dataclass(frozen=True)
class Advice:
    """What the page names in a situation: a method, and the selection that it was asked with."""

    method: str
    chosen: Mapping[str, str]


@dataclass(frozen=True)
class Tested:
    """A situation, the advice, its error, the best method with the least error, and the regret."""

    situation: Situation
    advice: Advice
    error: float
    best: str
    least: float

    @property
    def regret(self) -> float:
        """The advised method's error over the least, neither below `FLOOR`."""
        return max(self.error, FLOOR) / max(self.least, FLOOR)


def advise(board: Contest, wanted: Mapping[str, str], applies: Sequence[str]) -> Advice | None:
    """The method that the page ranks first for what somebody has, as somebody would ask.

    The page is asked suite by suite: the case, then as many of the wanted conditions as the suite's problems have, each
    by its own text or the nearest one.  The suite with the most of them counts, of several the one with most problems.

    Parameters
    ----------
    wanted : case, and conditions (`contest.DIMENSIONS`) -> text.
    applies : methods that can be used with the records; the first of them in the ranking is named.
    """
    found = [_asked(board.where({"suite": suite}), wanted) for suite in board.problems["suite"].astype(str).unique()]
    ranked = [(own, chosen) for own, chosen in found if len(own.order()) > 1]
    if not ranked:
        return None
    own, chosen = max(ranked, key=lambda pair: (len(pair[1]), len(pair[0].problems)))
    names = [place.method for place in own.order() if not place.partial]
    method = next((name for name in names if name in applies), names[0])
    return Advice(method, chosen)


def tested(board: Contest, fresh: Contest, situations: Sequence[Situation]) -> list[Tested]:
    """The advice of a board in those of the situations that are in the contest of their runs."""
    found = [_tested(board, fresh, one) for one in situations]
    return [one for one in found if one is not None]


def _tested(board: Contest, fresh: Contest, one: Situation) -> Tested | None:
    at = _problems_of(fresh, one)
    if at.size != 1 or np.isnan(fresh.errors[at[0]]).all():
        return None
    errors, row = fresh.errors[at[0]], fresh.problems.iloc[at[0]]
    applies = [method for method, error in zip(fresh.methods, errors, strict=True) if not np.isnan(error)]
    advice = advise(board, {name: str(row[name]) for name in CONDITIONS}, applies)
    if advice is None:
        return None
    least = int(np.nanargmin(errors))
    error = errors[fresh.methods.index(advice.method)] if advice.method in applies else np.inf
    return Tested(one, advice, float(error), fresh.methods[least], float(errors[least]))


def summary(found: Sequence[Tested]) -> str:
    """The share of good advice in one sentence, with a 95 % interval (Wilson)."""
    from scipy.stats import binomtest

    if not found:
        return "No situation could be judged."
    good = sum(one.regret < GOOD for one in found)
    low, high = binomtest(good, len(found)).proportion_ci(method="wilson")
    return (
        f"In {len(found)} fresh situations the method that this page names errs less than {GOOD:g} times the least "
        f"error of all methods in {percent(good / len(found))} [{percent(low)}, {percent(high)}]; median regret "
        f"{number(median([one.regret for one in found]))}."
    )


def report(found: Sequence[Tested], seed: int) -> str:
    """The page of the test as Markdown."""
    kinds = sorted({one.situation.kind for one in found})
    by_kind = [(kind, [one for one in found if one.situation.kind == kind]) for kind in kinds]
    parts = ["# The advice tested", summary(found), EXPLAINED]
    parts += ["## By kind of situation", markdown(_kinds(by_kind)), "## Situations", markdown(_situations(found))]
    return "\n\n".join([*parts, f"Drawn with seed {seed}; every run is in the folder."]) + "\n"


def _kinds(by_kind: Sequence[tuple[str, list[Tested]]]) -> Table:
    rows = [
        {
            "kind": kind,
            "n": len(own),
            "good": sum(o.regret < GOOD for o in own),
            "median": median([o.regret for o in own]),
        }
        for kind, own in by_kind
    ]
    columns = [
        field("kind"),
        Column("situations", lambda row: str(row["n"]), lambda row: row["n"]),
        Column(f"regret below {GOOD:g}", lambda row: percent(row["good"] / row["n"]), lambda row: row["good"]),
        Column("median regret", lambda row: number(row["median"]), lambda row: row["median"]),
    ]
    return make_table(columns, rows)


def _situations(found: Sequence[Tested]) -> Table:
    rows = [
        {
            "ship": one.situation.vessel,
            "model": one.situation.model,
            "train": " + ".join(one.situation.train),
            "predict": " + ".join(one.situation.held_out),
            "noise": one.situation.noise,
            "disturbance": one.situation.disturbance,
            "asked": ", ".join(text for name, text in one.advice.chosen.items() if name != "case"),
            "advice": f"{one.advice.method} ({number(one.error)})",
            "best": f"{one.best} ({number(one.least)})",
            "regret": one.regret,
        }
        for one in sorted(found, key=lambda one: -one.regret)
    ]
    names = ("ship", "model", "train", "predict", "noise", "disturbance", "asked", "advice", "best")
    columns = [*map(field, names), Column("regret", lambda row: _told(row["regret"]), lambda row: row["regret"])]
    return make_table(columns, rows)


def _told(regret: float) -> str:
    return number(regret) if np.isfinite(regret) else MISSING


def _asked(board: Contest, wanted: Mapping[str, str]) -> tuple[Contest, dict[str, str]]:
    """The problems left after as many conditions as there are any for, and these conditions."""
    chosen: dict[str, str] = {}
    for name, text in wanted.items():
        level = nearest(board.problems[name].astype(str).unique(), text)
        if name == "case":
            board = board.where({"case": text})
        elif level is not None:
            own = board.where({name: level})
            if own.problems["vessel"].nunique() >= LEAST_SHIPS and len(own.order()) > 1:
                board, chosen[name] = own, level
    return board, chosen


def nearest(levels: Sequence[str], text: str) -> str | None:
    """The text among the levels, else that of the same kind that is nearest in its first number; None: none is.

    The kind of a noise is what it takes away, that of a disturbance is its name.
    """
    if text in levels:
        return text
    near = [level for level in levels if _kind(level) == _kind(text) != ""]
    return min(near, key=lambda level: (abs(_first_number(level) - _first_number(text)), level), default=None)


def _kind(text: str) -> str:
    head, comma, rest = text.partition(",")
    return rest if comma else head.partition(":")[0] if ":" in head else ""


def _first_number(text: str) -> float:
    digits = text.partition(":")[2].partition("@")[0]
    return float(digits) if digits.replace(".", "", 1).isdigit() else 0.0


def _problems_of(fresh: Contest, one: Situation) -> np.ndarray:
    own, rows = fresh.problems, {"vessel": one.vessel, "train": "+".join(one.train), "held_out": "+".join(one.held_out)}
    rows |= {"noise": one.noise, "disturbance": one.disturbance}
    keep = np.ones(len(own), dtype=bool)
    for name, text in rows.items():
        keep &= (own[name].astype(str) == text).to_numpy()
    keep &= (own["case"].astype(str) == (KNOWN if one.model == "own" else UNKNOWN)).to_numpy()
    if one.model != "own":
        keep &= (own["model"].astype(str) == one.model).to_numpy()
    return np.flatnonzero(keep)


def as_rows(found: Sequence[Tested]) -> list[dict[str, Any]]:
    """Plain values, one row a situation, for machines."""
    return [
        {**vars(one.situation), "advised": one.advice.method, "error": one.error, "best": one.best, "least": one.least}
        | {"regret": one.regret}
        for one in found
    ]
