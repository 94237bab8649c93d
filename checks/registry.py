"""Finding checks: what this room's files of checks define, and installed entry points."""

from __future__ import annotations

from functools import lru_cache

from ..models.discovery import by_name, classes_in, classes_of, known, plug_ins
from . import columns, sensors
from .base import Check, FileCheck, SensorError

GROUP = "helmbench.causes"
"""Entry-point group by which other packages add checks and causes of a diagnosis."""


@lru_cache(maxsize=1)
def checks() -> dict[str, Check]:
    """Identifier -> every check, sorted.

    Raises
    ------
    BadInput : two checks have the same identifier, or a plug-in cannot be loaded.
    """
    own = [*classes_of(f"{__package__}.files", Check), *classes_in(columns, Check), *classes_in(sensors, Check)]
    added = [cls for cls in installed() if issubclass(cls, FileCheck | SensorError)]
    return {name: cls() for name, cls in by_name("check", [*own, *added]).items()}


def check_of(name: str) -> Check:
    """The check of an identifier; BadInput if there is none."""
    return known("check", name, checks(), "'helmbench list causes' shows all")


def file_checks() -> list[FileCheck]:
    """Checks of one record by itself, in the order in which they are looked for."""
    return sorted((c for c in checks().values() if isinstance(c, FileCheck)), key=lambda c: (c.rank, c.id))


def sensor_errors() -> list[SensorError]:
    """Sensor errors that show between channels."""
    return [c for c in checks().values() if isinstance(c, SensorError)]


@lru_cache(maxsize=1)
def installed() -> tuple[type[Check], ...]:
    """Checks and causes that other packages add; BadInput as `discovery.plug_ins`."""
    return tuple(plug_ins(GROUP, "cause", Check))
