"""Finding causes: the files of this folder, and installed entry points."""

from __future__ import annotations

import importlib
import pkgutil
from functools import lru_cache
from typing import TYPE_CHECKING

from ...checks.base import Check
from ...checks.registry import checks, classes_in, installed
from ...models.errors import BadInput
from ...models.families.extensions import is_made_up
from ...models.suggestions import suggestion
from ._stage import StageCause
from .base import Cause, NotTestable

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ...models.model import Model
    from ..candidate import Variant


@lru_cache(maxsize=1)
def all_causes() -> dict[str, Check]:
    """Identifier -> every cause, sorted: those that a diagnosis tests, and those that only `check` looks for.

    Raises
    ------
    BadInput : two causes have the same identifier, or a plug-in cannot be loaded.
    """
    found: dict[str, Check] = {}
    for cls in [*_own(), *(cls for cls in installed() if issubclass(cls, Cause))]:
        if cls.id in found:
            raise BadInput(f"cause {cls.id!r} is defined twice", file=cls.__module__)
        found[cls.id] = cls()
    return dict(sorted((checks() | found).items()))


def causes() -> dict[str, Check]:
    """Identifier -> every cause that a diagnosis tests, sorted; BadInput as `all_causes`."""
    return {name: entry for name, entry in all_causes().items() if isinstance(entry, Cause) or entry.named}


def cause(name: str) -> Check:
    """The cause of an identifier; BadInput if there is none."""
    known = causes()
    if name not in known:
        raise BadInput(f"unknown cause {name!r}", hint=suggestion(name, known, "'helmbench list causes' shows all"))
    return known[name]


def bank() -> list[Cause]:
    """Causes that are tried against a model."""
    return [c for c in causes().values() if isinstance(c, Cause) and not isinstance(c, StageCause)]


def terms_for(model: Model) -> tuple[str, ...]:
    """Product terms that causes add to a model, for `estimator(..., terms=...)`."""
    if not model.is_3dof:
        return ()
    own = model.family.split("+")
    found = {c.extension for c in bank() if c.extension is not None and is_made_up(c.extension)}
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
    later = (c for c in causes().values() if isinstance(c, StageCause))
    return can, cannot | {entry: entry.stage for entry in later}


def _own() -> list[type[Cause]]:
    package = importlib.import_module(__name__.rpartition(".")[0])
    modules = [
        importlib.import_module(f"{package.__name__}.{entry.name}")
        for entry in pkgutil.iter_modules(package.__path__)
        if not entry.name.startswith("_")
    ]
    return [cls for module in modules for cls in classes_in(module, Cause)]
