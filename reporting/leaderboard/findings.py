"""Findings of the published leaderboard: sentences computed from stored results, each with its figures and command.

A finding is None where the results do not hold what it needs.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..numbers import duration, number, percent
from . import profiles, tuners
from .answer import headlines
from .contest import Contest
from .grey_black import grey_against_black
from .standings import CELL, Frame, Series, median, of_own_models
from .statistics import Statistics

OUTLIERS, SLOW = "low,outliers=10%", 16
"""Levels that findings compare with the plain ones."""


@dataclass(frozen=True)
class BoardFinding:
    """A sentence with its figures, and the command that makes the runs."""

    text: str
    command: str


def findings(of: Statistics, every: Statistics | None = None) -> list[BoardFinding]:
    """All findings that the results allow, in reading order.

    Parameters
    ----------
    of : the main suite.
    every : all suites, for what is said of conditions; None: the main one.
    """
    ranking: tuple[Callable[[Statistics], BoardFinding | None], ...] = (
        _boxes, _boxes_of_simpler_models, _simpler_models, _bound, _speed,
    )  # fmt: skip
    conditions = (_noise, _disturbance, _outliers, _sampling, _excitation)
    made = [
        *_best(of),
        *(make(of) for make in ranking),
        *(make(every or of) for make in conditions),
        *(make(of) for make in (_failures, _ranking, _hardest)),
    ]
    return [found for found in made if found is not None]


def command(suite: str) -> str:
    """The command that makes the runs of a suite."""
    return f"helmbench run --suite {suite} -o out/{suite}"


def _first(of: Statistics) -> tuple[str, int] | None:
    places = [place for place in of.board.order() if not place.partial]
    return (places[0].method, places[0].index) if places else None


def _best(of: Statistics) -> list[BoardFinding]:
    """Which method, for every case of what is known."""
    if not _first(of):
        return []
    return [BoardFinding(f"Which method, {case}: {text}", command("default")) for case, text in headlines(of.board)]


def _boxes(of: Statistics) -> BoardFinding | None:
    found = of.grey_black
    return BoardFinding(found.sentence(), command("default")) if found else None


def _own_models(of: Statistics) -> np.ndarray:
    """Whether the fitted model of each problem (P,) is the ship's own."""
    return of_own_models(of.board.problems, of.estimates)


def _boxes_of_simpler_models(of: Statistics) -> BoardFinding | None:
    """Grey against black box where the grey box cannot be exact."""
    own = _own_models(of)
    found = grey_against_black(of.board.kept(~own))
    if found is None or own.all():
        return None
    return BoardFinding(found.sentence("Where the fitted model is not the ship's own"), command("default"))


def _simpler_models(of: Statistics) -> BoardFinding | None:
    """What a simpler model costs the first method, on the vessels that were fitted with both."""
    first, own, vessels = _first(of), _own_models(of), of.board.problems["vessel"].astype(str)
    both = sorted(set(vessels[own]) & set(vessels[~own]))
    if first is None or not both:
        return None
    error, at = of.board.errors[:, first[1]], vessels.isin(both).to_numpy()
    exact, simple = median(error[at & own]), median(error[at & ~own])
    if np.isnan(exact) or np.isnan(simple):
        return None
    text = (
        f"With response models instead of the ship's own equations {first[0]} errs {number(simple)} instead of "
        f"{number(exact)} in the median ({', '.join(both)})."
    )
    return BoardFinding(text, command("default"))


def beyond(board: Contest) -> BoardFinding | None:
    """The best grey box against the best black box where both predict something else than they were trained on.

    Parameters
    ----------
    board : of the suite `generalise`.
    """
    found = grey_against_black(board)
    if found is None:
        return None
    return BoardFinding(found.sentence("Beyond the training records"), command("generalise"))


def tuners_compared(board: Contest) -> list[BoardFinding]:
    """Which tuner finds the best options at each budget.

    Parameters
    ----------
    board : of the suite `tuners`.
    """
    return [BoardFinding(budget.sentence(), command(tuners.SUITE)) for budget in tuners.budgets(board)]


def _bound(of: Statistics) -> BoardFinding | None:
    """How near the best method comes to the Cramer-Rao bound at low noise."""
    curves, floor = profiles.noise_curves(of.cells, of.estimates, of.board.methods)
    known = {
        method: curve["low"] / floor["low"] for method, curve in curves.items() if "low" in curve and floor.get("low")
    }
    if not known:
        return None
    near = min(known, key=lambda method: known[method])
    text = (
        f"At low noise {near} comes nearest to the Cramer-Rao floor: its median parameter error is "
        f"{number(known[near])} times the floor ({percent(floor['low'], 2)}); unbiased methods reach about 1."
    )
    return BoardFinding(text, command("default"))


def _speed(of: Statistics) -> BoardFinding | None:
    errors = [median(row) for row in of.board.errors.T]
    times = [median(row) for row in of.board.times.T]
    full = {place.index for place in of.board.order() if not place.partial}
    front = [i for i in profiles.pareto(errors, times) if i in full]
    if len(front) < 2:
        return None
    named = ", ".join(f"{of.board.methods[i]} ({number(errors[i])}, {duration(times[i])})" for i in front)
    return BoardFinding(f"No other method is both faster and more accurate than: {named}.", command("default"))


def _noise(of: Statistics) -> BoardFinding | None:
    return _levels(of, "noise", "low", "high", ("low noise", "high noise"), "noise")


def _disturbance(of: Statistics) -> BoardFinding | None:
    wind = next((level for level in of.board.problems["disturbance"].unique() if level.startswith("wind")), None)
    return _levels(of, "disturbance", "none", wind, ("calm water", f"{wind} while training"), "disturbances")


def _outliers(of: Statistics) -> BoardFinding | None:
    return _levels(of, "noise", "low", OUTLIERS, ("no outliers", "10 % outliers"), "outliers")


def _sampling(of: Statistics) -> BoardFinding | None:
    return _levels(of, "thinning", 1, SLOW, ("all samples", f"every {SLOW}th sample"), "sampling")


def _excitation(of: Statistics) -> BoardFinding | None:
    """The manoeuvre from which most is learned, where several are compared on the same held-out records."""
    problems = of.board.problems
    alone = problems[~problems["train"].str.contains(r"\+[A-Za-z_]", regex=True)]
    shared = alone.groupby(["vessel", "model", "held_out"], observed=True)["train"].nunique()
    blocks = shared[shared > 2].index
    if not len(blocks):
        return None
    keep = problems.set_index(["vessel", "model", "held_out"]).index.isin(blocks) & problems.index.isin(alone.index)
    board = of.board.kept(keep)
    levels = _medians_by(board.problems["excitation"], board.errors)
    order = sorted(levels, key=lambda text: levels[text])
    text = (
        f"Of single manoeuvres, {order[0]} teaches most (median prediction error {number(levels[order[0]])} over all "
        f"methods), {order[-1]} least ({number(levels[order[-1]])})."
    )
    return BoardFinding(text, command("excitation"))


def _failures(of: Statistics) -> BoardFinding | None:
    lost = {place.method: place.imputed / place.problems for place in of.board.order()}
    worst = max(lost, key=lambda method: lost[method], default="")
    if not lost or not lost[worst] > 0.0:
        return None
    never = sum(share == 0.0 for share in lost.values())
    text = (
        f"{worst} gives no finite prediction in {percent(lost[worst])} of its problems, the largest share; "
        f"{never} of {len(lost)} methods always give one."
    )
    return BoardFinding(text, command("default"))


def _ranking(of: Statistics) -> BoardFinding | None:
    told = next((text for text in of.statements() if text.startswith("The first method stays")), None)
    return BoardFinding(told, command("default")) if told else None


def _hardest(of: Statistics) -> BoardFinding | None:
    first = _first(of)
    if first is None:
        return None
    own = _own_models(of)
    every = _medians_by(of.board.problems["vessel"][own], of.board.errors[own, first[1]])
    known = {vessel: error for vessel, error in every.items() if not np.isnan(error)}
    if len(known) < 2:
        return None
    hard = max(known, key=lambda vessel: known[vessel])
    text = (
        f"With the ships' own equations {first[0]} has its largest median prediction error on {hard} "
        f"({number(known[hard])})."
    )
    return BoardFinding(text, command("default"))


def _medians_by(levels: Series, errors: np.ndarray) -> dict[str, float]:
    """Median error of the problems (P, ...) at each level; nan where nothing is known."""
    return {str(level): median(errors[(levels == level).to_numpy()]) for level in levels.unique()}


def _levels(
    of: Statistics, factor: str, plain: object, other: object, words: tuple[str, str], suite: str
) -> BoardFinding | None:
    """Which method predicts best at a level of a factor, and at the plain one; `words` name the plain and the other."""
    block = [name for name in CELL if name != factor]
    cells: Frame = of.cells[of.cells["nrmse"].notna()]
    one, two = (cells.loc[cells[factor] == level, [*block, "label", "nrmse"]] for level in (plain, other))
    both = one.merge(two, on=[*block, "label"], suffixes=("_a", "_b"))
    both = both[np.isfinite(both["nrmse_a"]) & (both["nrmse_a"] > 0.0)]
    most = both.groupby("label", observed=True).size()
    if not len(most) or len(most[most >= 0.9 * most.max()]) < 3:
        return None
    kept = both[both["label"].isin(most[most >= 0.9 * most.max()].index)]
    errors = kept.groupby("label", observed=True)[["nrmse_a", "nrmse_b"]].median()
    best = errors["nrmse_b"].idxmin()
    calm = errors["nrmse_a"].idxmin()
    text = (
        f"With {words[1]}, {best} predicts best: median error {number(errors.loc[best, 'nrmse_b'])} against "
        f"{number(errors.loc[best, 'nrmse_a'])} with {words[0]} ({int(most.max())} problems; with {words[0]}, {calm} "
        f"is best with {number(errors.loc[calm, 'nrmse_a'])})."
    )
    return BoardFinding(text, command(suite))
