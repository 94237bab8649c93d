"""Finding kinds of effects: every file of this folder."""

from __future__ import annotations

from functools import lru_cache

from ....models.discovery import by_name, classes_of, known
from .base import EffectKind


@lru_cache(maxsize=1)
def kinds() -> dict[str, EffectKind]:
    """Identifier -> every kind of effect, in the order in which a suite draws."""
    found = {name: cls() for name, cls in by_name("effect", classes_of(__package__, EffectKind)).items()}
    return dict(sorted(found.items(), key=lambda item: (item[1].rank, item[0])))


def kind_of(name: str) -> EffectKind:
    """The kind of an identifier; `BadInput` if there is none."""
    return known("effect", name, kinds())


def names_of(group: str) -> tuple[str, ...]:
    """Identifiers of the kinds of a group."""
    return tuple(name for name, kind in kinds().items() if kind.group == group)
