"""Finding causes: the files of this folder, and installed entry points."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

from ...checks.base import Check
from ...checks.registry import checks, installed
from ...models.coefficient_groups import stated_groups
from ...models.discovery import by_name, classes_of, known
from ...models.families.extensions import is_made_up
from .base import Cause, NotTestable, StageCause

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ...models.model import Model
    from ..innovations.state import Variant


@lru_cache(maxsize=1)
def all_causes() -> dict[str, Check]:
    """Identifier -> every cause, sorted: those that a diagnosis tests, and those that only `check` looks for.

    Raises
    ------
    BadInput : two causes have the same identifier, or a plug-in cannot be loaded.
    """
    added = [cls for cls in installed() if issubclass(cls, Cause)]
    every: list[type[Check]] = [*classes_of(__package__, Cause), *added]
    own = {name: cls() for name, cls in by_name("cause", every).items()}
    return dict(sorted((checks() | own).items()))


def causes() -> dict[str, Check]:
    """Identifier -> every cause that a diagnosis tests, sorted; BadInput as `all_causes`."""
    return {name: entry for name, entry in all_causes().items() if isinstance(entry, Cause) or entry.is_cause}


def cause(name: str) -> Check:
    """The cause of an identifier; BadInput if there is none."""
    return known("cause", name, causes(), "'helmbench list causes' shows all")


def bank() -> list[Cause]:
    """Causes that are tried against a model."""
    return [c for c in causes().values() if isinstance(c, Cause) and not isinstance(c, StageCause)]


def terms_for(model: Model) -> tuple[str, ...]:
    """Product terms that causes add to a model, for `estimator(..., terms=...)`."""
    if not model.is_3dof:
        return ()
    own = model.family.split("+")
    terms = {c.extension for c in bank() if c.extension is not None and is_made_up(c.extension)}
    return tuple(sorted(terms - set(own)))


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


def causes_of(model: Model) -> dict[str, str]:
    """The cause of every group whose extension of the model is a cause's."""
    by_extension = {cause.extension: cause.id for cause in bank() if cause.extension is not None}
    return {g.id: by_extension[g.extension] for g in stated_groups(model) if g.extension in by_extension}
