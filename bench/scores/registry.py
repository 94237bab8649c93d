"""Finding scores: every file of this folder."""

from __future__ import annotations

import pkgutil
from functools import lru_cache
from importlib import import_module
from typing import Any

from .base import Outcome, Score

MACHINERY = ("base", "registry")


@lru_cache(maxsize=1)
def scores() -> dict[str, Score]:
    """Function's name -> its score, in the order of the columns."""
    found: dict[str, Score] = {}
    package = import_module(__name__.rpartition(".")[0])
    for entry in pkgutil.iter_modules(package.__path__):
        if entry.name not in MACHINERY:
            own = vars(import_module(f"{package.__name__}.{entry.name}")).values()
            found |= {item.compute.__name__: item for item in own if isinstance(item, Score)}
    return dict(sorted(found.items(), key=lambda item: (item[1].rank, item[0])))


def score_columns() -> dict[str, str]:
    """Name -> type of every score's columns."""
    return {name: kind for score in scores().values() for name, kind in score.columns.items()}


def compute(outcome: Outcome) -> dict[str, Any]:
    """Values of every score's columns."""
    return {name: value for score in scores().values() for name, value in score.compute(outcome).items()}
