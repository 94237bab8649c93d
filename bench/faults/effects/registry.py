"""Finding kinds of effects: every file of this folder."""

from __future__ import annotations

import pkgutil
from functools import lru_cache
from importlib import import_module

from ....models.errors import BadInput
from .base import EffectKind

MACHINERY = ("base", "effect", "registry")


@lru_cache(maxsize=1)
def kinds() -> dict[str, EffectKind]:
    """Identifier -> every kind of effect, in the order in which a suite draws."""
    found: dict[str, EffectKind] = {}
    package = import_module(__name__.rpartition(".")[0])
    for entry in pkgutil.iter_modules(package.__path__):
        if entry.name.startswith("_") or entry.name in MACHINERY:
            continue
        module = import_module(f"{package.__name__}.{entry.name}")
        for cls in vars(module).values():
            if isinstance(cls, type) and issubclass(cls, EffectKind) and cls.__module__ == module.__name__:
                if cls.id in found:
                    raise BadInput(f"effect {cls.id!r} is defined twice", file=module.__file__)
                found[cls.id] = cls()
    return dict(sorted(found.items(), key=lambda item: (item[1].rank, item[0])))


def kind_of(name: str) -> EffectKind:
    """The kind of an identifier; `BadInput` if there is none."""
    known = kinds()
    if name not in known:
        raise BadInput(f"unknown effect {name!r}", hint=f"known are {', '.join(known)}")
    return known[name]


def names_of(group: str) -> tuple[str, ...]:
    """Identifiers of the kinds of a group."""
    return tuple(name for name, kind in kinds().items() if kind.group == group)
