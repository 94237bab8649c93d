"""A score: a function of an outcome, with its columns; every file of this folder holds one or more."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from ...estimation.estimates.estimate import Estimate
from ...models.discovery import modules_in
from ..kinds.identification.problems import FitTask

LAST = 10_000


@dataclass(frozen=True, eq=False)
class Outcome:
    """One estimate and what it is compared with.

    Attributes
    ----------
    problem : records (training and held out), blank model and true parameters.
    estimate : what the method returned.
    parameters : rows of the parameter table, without their keys.
    prediction : errors of predicted held-out records, as `estimation.run.prediction.prediction_scores` gives them.
    """

    problem: FitTask
    estimate: Estimate
    parameters: Sequence[Mapping[str, Any]]
    prediction: Mapping[str, Any]

    @property
    def identifiable(self) -> list[Mapping[str, Any]]:
        """Rows of identifiable parameters with a true value other than zero."""
        return [row for row in self.parameters if row["identifiable"] and row["rel_error"] is not None]


@dataclass(frozen=True, eq=False)
class ScoreFunction:
    """A function of an outcome that returns values of its columns; columns that it leaves out stay empty.

    `columns` is name -> type (string, int, float, bool); columns stand in the order of `rank`, those of a score without
    one last.
    """

    compute: Callable[[Outcome], Mapping[str, Any]]
    columns: Mapping[str, str]
    rank: int


def score(
    columns: Mapping[str, str], rank: int = LAST
) -> Callable[[Callable[[Outcome], Mapping[str, Any]]], ScoreFunction]:
    """Decorator that makes a function a score."""
    return lambda function: ScoreFunction(function, columns, rank)


# ---- Finding scores: every file of this folder.


@lru_cache(maxsize=1)
def scores() -> dict[str, ScoreFunction]:
    """Function's name -> its score, in the order of the columns."""
    every = (
        item for module in modules_in(__package__) for item in vars(module).values() if isinstance(item, ScoreFunction)
    )
    found = {item.compute.__name__: item for item in every}
    return dict(sorted(found.items(), key=lambda item: (item[1].rank, item[0])))


def score_columns() -> dict[str, str]:
    """Name -> type of every score's columns."""
    return {name: kind for score in scores().values() for name, kind in score.columns.items()}


def compute(outcome: Outcome) -> dict[str, Any]:
    """Values of every score's columns."""
    return {name: value for score in scores().values() for name, value in score.compute(outcome).items()}
