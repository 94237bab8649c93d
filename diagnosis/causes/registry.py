"""Finding causes: the files of this folder, and installed entry points."""

from __future__ import annotations

import importlib
import pkgutil
from functools import lru_cache
from importlib.metadata import entry_points
from typing import TYPE_CHECKING, Any

from ...models.errors import BadInput
from ...models.families.extensions import is_term
from ...models.suggestions import suggestion
from ._check import CheckCause
from ._records import RecordCause
from ._stage import StageCause
from .base import Cause, NotTestable

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ...models.model import Model
    from ..state import Variant

GROUP = "helmbench.causes"
"""Entry-point group by which other packages add causes."""


@lru_cache(maxsize=1)
def all_causes() -> dict[str, Cause]:
    """Identifier -> every cause, sorted: those that a diagnosis tests, and those that only `check` looks for.

    Raises
    ------
    BadInput : two causes have the same identifier, or a plug-in cannot be loaded.
    """
    found: dict[str, Cause] = {}
    for cls in [*_own(), *_installed()]:
        if cls.id in found:
            raise BadInput(f"cause {cls.id!r} is defined twice", file=cls.__module__)
        found[cls.id] = cls()
    return dict(sorted(found.items()))


def causes() -> dict[str, Cause]:
    """Identifier -> every cause that a diagnosis tests, sorted; BadInput as `all_causes`."""
    return {name: entry for name, entry in all_causes().items() if not isinstance(entry, CheckCause)}


def check_causes() -> dict[str, CheckCause]:
    """Identifier -> every cause that only `check` looks for, sorted; BadInput as `all_causes`."""
    return {name: entry for name, entry in all_causes().items() if isinstance(entry, CheckCause)}


def cause(name: str) -> Cause:
    """The cause of an identifier; BadInput if there is none."""
    known = causes()
    if name not in known:
        raise BadInput(f"unknown cause {name!r}", hint=suggestion(name, known, "'helmbench list causes' shows all"))
    return known[name]


def record_causes() -> list[RecordCause]:
    """Causes that make whole columns mean something else, in the order in which they are looked for."""
    return sorted((c for c in causes().values() if isinstance(c, RecordCause)), key=lambda c: (c.rank, c.id))


def bank() -> list[Cause]:
    """Causes that are tried against a model."""
    return [c for c in causes().values() if not isinstance(c, StageCause)]


def terms_for(model: Model) -> tuple[str, ...]:
    """Product terms that causes add to a model, for `estimator(..., terms=...)`."""
    if not model.is_3dof:
        return ()
    own = model.family.split("+")
    found = {c.extension for c in bank() if c.extension is not None and is_term(c.extension)}
    return tuple(sorted(found - set(own)))


def testable(est: Estimator) -> tuple[dict[Cause, tuple[Variant, ...]], dict[Cause, str]]:
    """Variants of the causes that model and channels can carry, and for the others why not."""
    can: dict[Cause, tuple[Variant, ...]] = {}
    cannot: dict[Cause, str] = {}
    for entry in bank():
        try:
            can[entry] = tuple(entry.variants(est))
        except NotTestable as reason:
            cannot[entry] = str(reason)
    later = (c for c in causes().values() if isinstance(c, StageCause) and not isinstance(c, RecordCause))
    return can, cannot | {entry: entry.stage for entry in later}


def _own() -> list[type[Cause]]:
    package = importlib.import_module(__name__.rpartition(".")[0])
    modules = [
        importlib.import_module(f"{package.__name__}.{entry.name}")
        for entry in pkgutil.iter_modules(package.__path__)
        if not entry.name.startswith("_")
    ]
    return [cls for module in modules for cls in causes_in(module)]


def causes_in(module: Any) -> list[type[Cause]]:
    """The causes that a module defines itself (not those it imports)."""
    return [
        value
        for value in vars(module).values()
        if isinstance(value, type)
        and issubclass(value, Cause)
        and "id" in vars(value)
        and value.__module__ == module.__name__
    ]


def _installed() -> list[type[Cause]]:
    found = []
    for point in entry_points(group=GROUP):
        try:
            cls = point.load()
        except Exception as error:  # whatever a foreign package raises while it is imported
            raise BadInput(f"cause plug-in cannot be loaded: {error}", file=point.value) from error
        if not (isinstance(cls, type) and issubclass(cls, Cause)):
            raise BadInput("not a subclass of helmbench.diagnosis.causes.base.Cause", file=point.value)
        found.append(cls)
    return found
