"""Finding scores: every file of this folder."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from ...models.discovery import modules_in
from .base import Outcome, ScoreFunction


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
