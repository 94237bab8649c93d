"""Tuners of options compared at equal budgets: the runs of the suite `tuners`, named `tuned:METHOD,tuner=...,trials=N`.

The options that a tuner finds are judged as everything on the board is: by the free-run error on held-out records, of
which the tuner saw nothing.  A problem here is one of the contest with one of the methods; its error is the median over
the tuner's seeds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..numbers import duration, number, p_value
from ..tables import Column, Table, make_table
from .contest import Contest
from .grey_black import FEWEST
from .paired import LEVEL, PairedComparison, compare, log_ratios
from .standings import median

SUITE = "tuners"
"""The suite whose runs compare tuners; they take no part in the ranking of methods."""
PREFIX = "tuned:"


class Tuned(NamedTuple):
    """What a label says: the method with the options that are given, the tuner and the number of trials."""

    method: str
    tuner: str
    trials: int


@dataclass(frozen=True)
class Budget:
    """Tuners with the same number of trials on the same problems.

    Attributes
    ----------
    trials, methods : number of trials, and the methods that were tuned.
    tests : the tuners by mean rank, Friedman's test and signed ranks of every pair.
    errors : tuner -> errors (n,) on the shared problems, infinite where the fit failed or its free run diverged.
    times : tuner -> median CPU time of a fit with its trials, s.
    """

    trials: int
    methods: tuple[str, ...]
    tests: PairedComparison
    errors: Mapping[str, np.ndarray]
    times: Mapping[str, float]

    @property
    def order(self) -> list[str]:
        """The tuners by `excess`, then by mean rank: the errors of problems differ too much for their median."""
        return sorted(self.tests.methods, key=self.excess)

    def excess(self, tuner: str) -> float:
        """Median ratio of the tuner's error to the least of all tuners in the same problem."""
        least = np.min([*self.errors.values()], axis=0)
        return float(np.exp(median(log_ratios(self.errors[tuner], least))))

    def sentence(self) -> str:
        """Which tuner finds the best options, and whether chance alone explains the differences."""
        first, *rest = self.order
        others = ", ".join(f"{tuner} {number(self.excess(tuner))}" for tuner in rest)
        return (
            f"Of tuners at equal budgets ({self.trials} trials), {first} finds options with the least held-out error "
            f"in the median: {number(self.excess(first))} times the least of all tuners in the same problem "
            f"({others}); {self._chance()}"
        )

    def _chance(self) -> str:
        tests = self.tests
        p = "< 0.001" if tests.friedman_p < 0.001 else f"= {p_value(tests.friedman_p)}"
        friedman = f"Friedman p {p} over {tests.n} problems of {len(self.methods)} methods"
        if not tests.friedman_p < LEVEL:
            return f"the differences are not more than chance ({friedman})."
        pairs = [(i, j) for j in range(len(tests.methods)) for i in range(j) if tests.p[i, j] < LEVEL]
        told = ", ".join(f"{tests.methods[i]} before {tests.methods[j]}" for i, j in pairs) or "no pair"
        return f"the differences are more than chance ({friedman}; by mean rank signed ranks tell apart: {told})."


def tuned(label: str) -> Tuned | None:
    """What a label of the contest says of its tuning; None unless it names tuner and trials."""
    name, *options = label.split(",")
    pairs = [option.partition("=") for option in options]
    given = {option: value for option, _, value in pairs}
    tuner, trials = given.pop("tuner", ""), given.pop("trials", "")
    given.pop("tuner_seed", None)
    if not (name.startswith(PREFIX) and tuner and trials.isdigit()):
        return None
    method = ",".join([name.removeprefix(PREFIX), *(f"{option}={value}" for option, value in given.items())])
    return Tuned(method, tuner, int(trials))


def budgets(board: Contest) -> list[Budget]:
    """The comparison at every number of trials with at least three tuners and six problems, by number of trials.

    Compared are the tuners that all methods of that number have.
    """
    places: dict[int, dict[str, dict[str, list[int]]]] = {}
    for place, label in enumerate(board.methods):
        if own := tuned(label):
            by_tuner = places.setdefault(own.trials, {}).setdefault(own.method, {})
            by_tuner.setdefault(own.tuner, []).append(place)
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
    errors = np.concatenate(blocks)
    errors = errors[~np.isnan(errors).any(axis=1) & np.isfinite(errors).any(axis=1)]
    if len(errors) < FEWEST:
        return None
    times = {
        tuner: median(np.concatenate([board.times[:, own[tuner]].ravel() for own in places.values()]))
        for tuner in tuners
    }
    return Budget(trials, tuple(places), compare(errors, tuners), dict(zip(tuners, errors.T, strict=True)), times)


def tuner_table(board: Contest) -> Table:
    """Tuners by budget and error; no row where the contest does not compare any."""
    rows = [(budget, tuner) for budget in budgets(board) for tuner in budget.order]
    columns = [
        Column("trials", lambda row: str(row[0].trials), lambda row: row[0].trials),
        Column("tuner", lambda row: row[1]),
        _number("error over the least", lambda budget, tuner: budget.excess(tuner)),
        _number("median error", lambda budget, tuner: median(budget.errors[tuner])),
        _number("mean rank", lambda budget, tuner: float(budget.tests.mean_ranks[budget.tests.methods.index(tuner)])),
        Column("CPU time", lambda row: duration(row[0].times[row[1]]), lambda row: row[0].times[row[1]]),
    ]
    return make_table(columns, rows, "Tuners at equal budgets", NOTE if rows else "")


NOTE = (
    "Held-out errors of the options found: the median ratio to the least error of all tuners in the same problem, and "
    "the median over problems and methods; CPU time of a fit with all its trials."
)


def _number(title: str, value: Callable[[Budget, str], float]) -> Column:
    return Column(title, lambda row: number(value(*row), 3), lambda row: value(*row))
