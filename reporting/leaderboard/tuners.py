"""Tuners of options compared at equal budgets: the runs of the suite `tuners`, named `tuned:METHOD,tuner=...,trials=N`.

The options that a tuner finds are judged as everything on the board is: by the free-run error on held-out records, of
which the tuner saw nothing.  A problem here is one of the contest with one of the methods; its error is the median over
the tuner's seeds.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..numbers import duration, number
from ..tables import Table, field, make_table, numeric
from .contest import Contest
from .equivalence import LEVEL, holm, log_ratios, signed_rank
from .findings import FEWEST
from .standings import median

SUITE = "tuners"
"""The suite whose runs compare tuners; they take no part in the ranking of methods."""
PREFIX = "tuned:"
COLUMNS = (
    numeric("trials", "trials"),
    field("tuner"),
    numeric("error over the least", "excess"),
    numeric("median error", "error"),
    numeric("CPU time", "time", duration),
)
NOTE = (
    "Held-out errors of the options found: the median ratio to the least error of all tuners in the same problem, and "
    "the median over problems and methods; CPU time of a fit with all its trials."
)


@dataclass(frozen=True)
class Budget:
    """Tuners with the same number of trials on the same problems.

    Attributes
    ----------
    trials, methods : number of trials, and the methods that were tuned.
    errors : tuner -> errors (n,) on the shared problems, infinite where the fit failed or its free run diverged; the
        tuners by `excess`, since the errors of problems differ too much for their median.
    times : tuner -> median CPU time of a fit with its trials, s.
    """

    trials: int
    methods: tuple[str, ...]
    errors: Mapping[str, np.ndarray]
    times: Mapping[str, float]

    def rows(self) -> list[dict[str, Any]]:
        """Rows of `tuner_table`, the tuner with the least excess first."""
        return [
            {"trials": self.trials, "tuner": name, "excess": excess(self.errors, name), "error": median(own)}
            | {"time": self.times[name]}
            for name, own in self.errors.items()
        ]

    def sentence(self) -> str:
        """Which tuner finds the best options, and which others signed ranks tell apart from it (Holm-corrected)."""
        first, *rest = self.errors
        others = ", ".join(f"{tuner} {number(excess(self.errors, tuner))}" for tuner in rest)
        p = holm([signed_rank(log_ratios(self.errors[tuner], self.errors[first])) for tuner in rest])
        told = ", ".join(tuner for tuner, value in zip(rest, p, strict=True) if value < LEVEL) or "none"
        return (
            f"Of tuners at equal budgets ({self.trials} trials), {first} finds options with the least held-out error "
            f"in the median: {number(excess(self.errors, first))} times the least of all tuners in the same problem "
            f"({others}); of these, signed ranks over {len(self.errors[first])} problems of {len(self.methods)} "
            f"methods tell apart from it: {told}."
        )


def excess(errors: Mapping[str, np.ndarray], tuner: str) -> float:
    """Median ratio of a tuner's errors (n,) to the least of all tuners in the same problem."""
    return float(np.exp(median(log_ratios(errors[tuner], np.min([*errors.values()], axis=0)))))


def tuned(label: str) -> tuple[str, str, int] | None:
    """Method with the options that are given, tuner and number of trials of a label; None unless it names them."""
    name, *options = label.split(",")
    given = {option: value for option, _, value in (option.partition("=") for option in options)}
    tuner, trials = given.pop("tuner", ""), given.pop("trials", "")
    given.pop("tuner_seed", None)
    if not (name.startswith(PREFIX) and tuner and trials.isdigit()):
        return None
    method = ",".join([name.removeprefix(PREFIX), *(f"{option}={value}" for option, value in given.items())])
    return method, tuner, int(trials)


def budgets(board: Contest) -> list[Budget]:
    """The comparison at every number of trials with at least three tuners and six problems, by number of trials.

    Compared are the tuners that all methods of that number have.
    """
    places: dict[int, dict[str, dict[str, list[int]]]] = {}
    for place, label in enumerate(board.methods):
        if own := tuned(label):
            method, tuner, trials = own
            places.setdefault(trials, {}).setdefault(method, {}).setdefault(tuner, []).append(place)
    found = [_budget(board, trials, places[trials]) for trials in sorted(places)]
    return [budget for budget in found if budget is not None]


def _budget(board: Contest, trials: int, places: Mapping[str, Mapping[str, Sequence[int]]]) -> Budget | None:
    """places : method -> tuner -> columns of the contest, one a seed of the tuner."""
    tuners = sorted(set.intersection(*(set(own) for own in places.values())))
    if len(tuners) < 3:
        return None
    blocks = [
        np.column_stack([np.median(board.errors[:, own[tuner]], axis=1) for tuner in tuners]) for own in places.values()
    ]
    table = np.concatenate(blocks)
    table = table[~np.isnan(table).any(axis=1) & np.isfinite(table).any(axis=1)]
    if len(table) < FEWEST:
        return None
    errors = dict(zip(tuners, table.T, strict=True))
    errors = {tuner: errors[tuner] for tuner in sorted(tuners, key=lambda tuner: excess(errors, tuner))}
    times = {
        tuner: median(np.concatenate([board.times[:, own[tuner]].ravel() for own in places.values()]))
        for tuner in tuners
    }
    return Budget(trials, tuple(places), errors, times)


def tuner_table(board: Contest) -> Table:
    """Tuners by budget and error; no row where the contest does not compare any."""
    rows = [row for budget in budgets(board) for row in budget.rows()]
    return make_table(COLUMNS, rows, "Tuners at equal budgets", NOTE if rows else "")
