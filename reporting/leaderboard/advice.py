"""Is the page's advice good?  Its rule is asked in fresh situations, and what it names is compared with all methods.

What the regret of an advice is, `EXPLAINED` says.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ...bench.situations import SEEDS, Situation
from ...models.model import resolve
from ..numbers import MISSING, number, percent
from ..tables import Table, make_table, markdown, numeric
from ..tables import field as column
from .answer import FLOOR, GOOD, shortlist
from .contest import Contest
from .standings import CASES, median

UNKNOWN = "output-error"
"""The advice where a ship's equations and particulars are unknown: no rule tried was shown to be better, see
docs/how-to/read-the-leaderboard.md."""
PARTICULARS = "particulars, corrected"
"""The advice where her equations are unknown and her particulars known: their simulation, corrected by the training
records (`calibrate`)."""
EXPLAINED = (
    "The regret of an advice is the error of the method that it names over the least error of all methods there; it is "
    "infinite (a dash) where that method fails or diverges. Errors are medians over "
    f"{SEEDS} draws of the noise. A method that does not apply is passed over. "
    f"Errors below {FLOOR:g} of what the record varies by count as {FLOOR:g}: nobody needs the difference. The page "
    "also lists a few methods to compare: of these the one is taken that errs least on one more record, another "
    "manoeuvre with the same sensors in the same weather, for each draw of the noise. "
    f"Where the ship's equations are unknown, the advice is {UNKNOWN}, whatever the page ranks first, or, where her "
    "file states the particulars of hull, rudder and propeller, the simulation that they give, corrected by the "
    f"training records ({PARTICULARS}: `helmbench calibrate --model ship.yaml`), which counts as one of the methods."
)
CONDITIONS = ("case", "noise", "disturbance", "model", "sampling", "excitation")
"""What the page is asked with, the most important first."""
PLAIN_RULES = ("output-error", "grey-gp")
"""Methods that somebody could always take: an advice that is no better than each of them is worth nothing."""
KNOWN = {
    (False, False): "Own equations",
    (True, True): f"Other equations and known particulars (the advice is {PARTICULARS})",
    (True, False): f"Other equations (the advice is {UNKNOWN}, whatever ranks first)",
}
"""What is known of a ship, by whether other equations are fitted and whether the advice is `PARTICULARS`."""
LEAST_SHIPS = 2
"""Ships that an answer must rest on, else a condition is left open."""


@dataclass(frozen=True)
class Advice:
    """What the page names in a situation: a method, a few to compare, and the selection that it was asked with."""

    method: str
    listed: tuple[str, ...]
    chosen: Mapping[str, str]


@dataclass(frozen=True)
class Tested:
    """A situation, the advice, its error, that of the method chosen from the list, and the best one with its error.

    plain : method of `PLAIN_RULES` -> its error there, infinite where it does not apply.
    """

    situation: Situation
    advice: Advice
    error: float
    chosen_error: float
    best: str
    least: float
    plain: Mapping[str, float] = field(default_factory=dict)

    @property
    def regret(self) -> float:
        """The advised method's error over the least, neither below `FLOOR`."""
        return self._over_least(self.error)

    @property
    def regret_without_floor(self) -> float:
        """The same with errors as they are."""
        return self.error / self.least if np.isfinite(self.error) else np.inf

    @property
    def chosen_regret(self) -> float:
        """The same of the method that was chosen from the list."""
        return self._over_least(self.chosen_error)

    def plain_regret(self, method: str) -> float:
        """The same of a method of `PLAIN_RULES`."""
        return self._over_least(self.plain.get(method, np.inf))

    def _over_least(self, error: float) -> float:
        return max(error, FLOOR) / max(self.least, FLOOR)


def advise(board: Contest, wanted: Mapping[str, str], applies: Sequence[str]) -> Advice | None:
    """The method to take for what somebody has, as somebody would ask: the one that the page ranks first or, where the
    ship's equations are unknown, `UNKNOWN`.

    The page is asked suite by suite: the case, then as many of the wanted conditions as the suite's problems have, each
    by its own text or the nearest one.  The suite with the most of them counts, of several the one with most problems.

    Parameters
    ----------
    wanted : case, and conditions (`contest.DIMENSIONS`) -> text.
    applies : methods that can be used with the records, of which one is named.
    """
    found = [_asked(board.where({"suite": suite}), wanted) for suite in board.problems["suite"].astype(str).unique()]
    ranked = [(own, chosen) for own, chosen in found if len(own.order()) > 1]
    if not ranked:
        return None
    own, chosen = max(ranked, key=lambda pair: (len(pair[1]), len(pair[0].problems)))
    names = [place.method for place in own.order() if not place.partial]
    usable = [name for name in names if name in applies]
    if not usable:
        return Advice(names[0], (names[0],), chosen)
    plain = wanted.get("case") == CASES[1] and UNKNOWN in applies
    return Advice(UNKNOWN if plain else usable[0], tuple(shortlist(own, usable)[0]), chosen)


def advices(board: Contest, fresh: Contest, situations: Sequence[Situation]) -> dict[Situation, Advice]:
    """The advice of a board in those of the situations that are in the contest of their runs."""
    found = {}
    for one in situations:
        if (at := _problem_of(fresh, one)) is not None:
            applies = [name for name, error in zip(fresh.methods, fresh.errors[at], strict=True) if not np.isnan(error)]
            row = fresh.problems.iloc[at]
            advice = advise(board, {name: str(row[name]) for name in CONDITIONS}, applies)
            found |= {one: advice} if advice else {}
    return found


def unknown(one: Situation) -> bool:
    """Whether other equations than the ship's own are fitted."""
    return one.model != "own"


def tested(
    advised: Mapping[Situation, Advice],
    fresh: Contest,
    checks: Contest,
    corrected: Mapping[Situation, Sequence[float]] | None = None,
) -> list[Tested]:
    """What advices are worth in the contest of all methods; what their lists hold is chosen by that of the checks.

    corrected : the error of each draw of the noise by `PARTICULARS`, where these are known and the equations are not.
    """
    by_particulars = {one: median(np.array(errors)) for one, errors in (corrected or {}).items()}
    return [_tested(fresh, checks, one, advice, by_particulars.get(one)) for one, advice in advised.items()]


def _tested(fresh: Contest, checks: Contest, one: Situation, advice: Advice, corrected: float | None) -> Tested:
    (at,), place = _places(fresh, one, held_out="+".join(one.held_out)), _check_of(checks, one)
    errors = fresh.errors[at]
    known = {name: float(value) for name, value in zip(fresh.methods, errors, strict=True) if not np.isnan(value)}
    if corrected is not None:
        known, advice = known | {PARTICULARS: corrected}, replace(advice, method=PARTICULARS)
    best = min(known, key=known.__getitem__)
    error, plain = known.get(advice.method, np.inf), {name: known.get(name, np.inf) for name in PLAIN_RULES}
    chosen = (
        np.nan if place is None else _chosen(fresh.runs[at], fresh.methods, checks.runs[place], checks.methods, advice)
    )
    chosen_error = error if np.isnan(chosen) else chosen
    return Tested(one, advice, error, chosen_error, best, known[best], plain)


def _chosen(
    runs: np.ndarray, methods: Sequence[str], checks: np.ndarray, checked: Sequence[str], advice: Advice
) -> float:
    """Median over draws of the noise of the error of the listed method with the least error on the check record.

    runs, checks : errors (M, S) of `methods` in the situation, and of `checked` on its check record; nan without any.
    """
    names = [name for name in advice.listed if name in methods]
    if not names:
        return np.nan
    none = np.full(runs.shape[1], np.inf)
    shown = np.array([checks[checked.index(name)] if name in checked else none for name in names])
    best = np.argmin(np.where(np.isnan(shown), np.inf, shown), axis=0)
    return median(runs[[methods.index(name) for name in names]][best, np.arange(runs.shape[1])])


def summary(tested: Sequence[Tested]) -> str:
    """The shares of good advice, with 95 % intervals (Wilson), and the plain rules beside it."""
    if not tested:
        return "No situation could be judged."
    return (
        f"In {len(tested)} fresh situations the method that is advised errs less than {GOOD:g} times the least "
        f"error of all methods in {_good([one.regret for one in tested])}. Without the floor, below "
        f"which errors count as {FLOOR:g}, it does so in {_good([one.regret_without_floor for one in tested])}. "
        f"The best on one more record of the methods that it lists does so in "
        f"{_good([one.chosen_regret for one in tested])}. {_plain_rules(tested)}"
    )


def _plain_rules(tested: Sequence[Tested]) -> str:
    """The plain rules beside the advice, for each kind of what is known of the ship."""
    parts = []
    for kind in dict.fromkeys(KNOWN.values()):
        if own := [one for one in tested if KNOWN[unknown(one.situation), one.advice.method == PARTICULARS] == kind]:
            rules = [("the advice", [one.regret for one in own])]
            rules += [(f"always {name}", [one.plain_regret(name) for one in own]) for name in PLAIN_RULES]
            told = "; ".join(f"{name} {_good(regrets)}" for name, regrets in rules)
            parts.append(f"{kind}, {len(own)} situations: {told}.")
    return " ".join(parts)


def _count(regrets: Sequence[float]) -> int:
    return sum(regret < GOOD for regret in regrets)


def _good(regrets: Sequence[float]) -> str:
    from scipy.stats import binomtest

    good = _count(regrets)
    low, high = binomtest(good, len(regrets)).proportion_ci(method="wilson")
    share = percent(good / len(regrets))
    return f"{share} [{percent(low)}, {percent(high)}], median regret {number(median(regrets))}"


def report(tested: Sequence[Tested], drawn: int, seed: int) -> str:
    """The page of the test as Markdown; drawn : number of situations, also of those that could not be judged."""
    kinds = sorted({one.situation.kind for one in tested})
    by_kind = [(kind, [one for one in tested if one.situation.kind == kind]) for kind in kinds]
    parts = ["# The advice tested", summary(tested), EXPLAINED]
    parts += ["## By kind of situation", markdown(_kinds(by_kind)), "## Situations", markdown(_situations(tested))]
    left = drawn - len(tested)
    told = (
        f"; in {left} no method applies to the channels that are measured, or the board has no answer" if left else ""
    )
    parts.append(f"{drawn} situations were drawn with seed {seed}{told}. Every run is in the folder.")
    return "\n\n".join(parts) + "\n"


def _kinds(by_kind: Sequence[tuple[str, list[Tested]]]) -> Table:
    columns = [
        column("kind"),
        numeric("situations", "n", str),
        numeric(f"named: regret below {GOOD:g}", "named", percent),
        numeric("median", "median"),
        numeric("without the floor", "raw", percent),
        numeric(f"chosen from the list: regret below {GOOD:g}", "chosen", percent),
        numeric("median", "median_chosen"),
    ]
    rows = []
    for kind, own in by_kind:
        named, chosen = [one.regret for one in own], [one.chosen_regret for one in own]
        shares = {"named": named, "chosen": chosen, "raw": [one.regret_without_floor for one in own]}
        shares = {name: _count(regrets) / len(own) for name, regrets in shares.items()}
        rows.append({"kind": kind, "n": len(own), "median": median(named), "median_chosen": median(chosen)} | shares)
    return make_table(columns, rows)


def _situations(tested: Sequence[Tested]) -> Table:
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
            "list": f"{', '.join(one.advice.listed)} ({number(one.chosen_error)})",
            "best": f"{one.best} ({number(one.least)})",
            "regret": one.regret,
        }
        for one in sorted(tested, key=lambda one: -one.regret)
    ]
    names = ("ship", "model", "train", "predict", "noise", "disturbance", "asked", "advice", "list", "best")
    return make_table([*map(column, names), numeric("regret", "regret", _if_finite)], rows)


def _if_finite(regret: float) -> str:
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


def _problem_of(fresh: Contest, one: Situation) -> int | None:
    """Place of the situation's problem among those with an error; None: there is none, or more than one."""
    found = _places(fresh, one, held_out="+".join(one.held_out))
    return int(found[0]) if found.size == 1 and not np.isnan(fresh.errors[found[0]]).all() else None


def _check_of(checks: Contest, one: Situation) -> int | None:
    """Place of the problem of the situation's record to choose by; None: it was not run."""
    found = [at for at in _places(checks, one) if str(checks.problems["held_out"].iloc[at]).startswith(one.check)]
    return int(found[0]) if found else None


def _places(board: Contest, one: Situation, **more: str) -> np.ndarray:
    """Places of the problems with the ship, model, training records and conditions of a situation."""
    family = resolve(one.vessel).family if one.model == "own" else one.model
    rows = {"vessel": one.vessel, "model": family, "train": "+".join(one.train), "noise": one.noise}
    rows |= {"disturbance": one.disturbance} | more
    keep = np.ones(len(board.problems), dtype=bool)
    for name, text in rows.items():
        keep &= (board.problems[name].astype(str) == text).to_numpy()
    return np.flatnonzero(keep)


def as_rows(tested: Sequence[Tested]) -> list[dict[str, Any]]:
    """Plain values, one row a situation, for machines."""
    return [
        {**vars(one.situation), "advised": one.advice.method, "error": one.error, "best": one.best, "least": one.least}
        | {"regret": one.regret, "listed": one.advice.listed, "chosen_error": one.chosen_error}
        for one in tested
    ]
