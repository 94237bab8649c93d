"""Finding scores: every file of this folder."""

from __future__ import annotations

from functools import lru_cache
from importlib import import_module
from pathlib import Path
from typing import Any

from .base import Outcome, Score

MACHINERY = ("__init__", "base", "registry")


@lru_cache(maxsize=1)
def scores() -> dict[str, Score]:
    """Function's name -> its score, in the order of the columns."""
    found: dict[str, Score] = {}
    for path in sorted(Path(__file__).parent.glob("*.py")):
        if path.stem not in MACHINERY:
            own = vars(import_module(f".{path.stem}", __package__)).values()
            found |= {item.compute.__name__: item for item in own if isinstance(item, Score)}
    return dict(sorted(found.items(), key=lambda item: (item[1].rank, item[0])))


def score_columns() -> dict[str, str]:
    """Name -> type of every score's columns."""
    return {name: kind for score in scores().values() for name, kind in score.columns.items()}


def compute(outcome: Outcome) -> dict[str, Any]:
    """Values of every score's columns."""
    return {name: value for score in scores().values() for name, value in score.compute(outcome).items()}
