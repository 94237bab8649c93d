"""Finding checks: the files of this room's folders, and installed entry points."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from collections.abc import Iterator
from functools import lru_cache
from importlib.metadata import entry_points
from typing import Any, TypeVar

from ..models.errors import BadInput
from ..models.suggestions import suggestion
from .base import Check, FileCheck, SensorError
from .columns._base import ColumnCheck

GROUP = "helmbench.causes"
"""Entry-point group by which other packages add checks and causes of a diagnosis."""
FOLDERS = ("files", "columns", "sensors")
C = TypeVar("C", bound=Check)


@lru_cache(maxsize=1)
def checks() -> dict[str, Check]:
    """Identifier -> every check, sorted.

    Raises
    ------
    BadInput : two checks have the same identifier, or a plug-in cannot be loaded.
    """
    found: dict[str, Check] = {}
    for cls in [*_own(), *(cls for cls in installed() if issubclass(cls, FileCheck | ColumnCheck | SensorError))]:
        if cls.id in found:
            raise BadInput(f"check {cls.id!r} is defined twice", file=cls.__module__)
        found[cls.id] = cls()
    return dict(sorted(found.items()))


def check_of(name: str) -> Check:
    """The check of an identifier; BadInput if there is none."""
    known = checks()
    if name not in known:
        raise BadInput(f"unknown check {name!r}", hint=suggestion(name, known, "'helmbench list causes' shows all"))
    return known[name]


def file_checks() -> list[FileCheck]:
    """Checks of one record's file, in the order in which they are looked for."""
    return sorted((c for c in checks().values() if isinstance(c, FileCheck)), key=lambda c: (c.rank, c.id))


def column_checks() -> list[ColumnCheck]:
    """Checks of what whole columns mean, in the order in which they are looked for."""
    return sorted((c for c in checks().values() if isinstance(c, ColumnCheck)), key=lambda c: (c.rank, c.id))


def sensor_errors() -> list[SensorError]:
    """Sensor errors that show between channels."""
    return [c for c in checks().values() if isinstance(c, SensorError)]


def _own() -> Iterator[type[Check]]:
    for folder in FOLDERS:
        package = importlib.import_module(f".{folder}", __package__)
        for entry in pkgutil.iter_modules(package.__path__):
            if not entry.name.startswith("_"):
                yield from classes_in(importlib.import_module(f"{package.__name__}.{entry.name}"), Check)


def classes_in(module: Any, base: type[C]) -> list[type[C]]:
    """The concrete subclasses of `base` that a module defines itself (not those it imports)."""
    return [
        value
        for value in vars(module).values()
        if isinstance(value, type)
        and issubclass(value, base)
        and hasattr(value, "id")
        and not inspect.isabstract(value)
        and value.__module__ == module.__name__
    ]


@lru_cache(maxsize=1)
def installed() -> tuple[type[Check], ...]:
    """Classes that other packages add.

    Raises
    ------
    BadInput : one cannot be loaded, or is neither a check nor a cause.
    """
    found = []
    for point in entry_points(group=GROUP):
        try:
            cls = point.load()
        except Exception as error:  # whatever a foreign package raises while it is imported
            raise BadInput(f"cause plug-in cannot be loaded: {error}", file=point.value) from error
        if not (isinstance(cls, type) and issubclass(cls, Check)):
            raise BadInput("not a subclass of helmbench.checks.base.Check or of a cause", file=point.value)
        found.append(cls)
    return tuple(found)
