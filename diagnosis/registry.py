"""Finding diagnosers: those of this package, installed entry points, and files of the user's own.

A diagnoser is a class with a `name` and a `title` that has one method,
`diagnose(model, train, held_out, options) -> Diagnosis`.
"""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from abc import ABC, abstractmethod
from importlib.metadata import entry_points
from typing import TYPE_CHECKING, Any

from ..methods.registry import load_file
from ..models.errors import BadInput
from ..models.suggestions import suggestion

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..datasets.record import Record
    from ..models.model import Model
    from .options import Options
    from .result import Diagnosis

GROUP = "helmbench.diagnosers"
"""Entry-point group by which other packages add diagnosers."""
FOLDER = ".baselines"
"""Files of this package that define diagnosers are found."""


class Diagnoser(ABC):
    """One way to diagnose; subclasses set `name` and `title`."""

    name = ""
    title = ""

    @abstractmethod
    def diagnose(
        self, model: Model, train: Sequence[Record], held_out: Sequence[Record], options: Options
    ) -> Diagnosis:
        """What the model gets wrong about the training records, and the gain on the held-out ones.

        Raises
        ------
        CannotFit : if the records lack what it needs.
        """


def diagnosers() -> dict[str, type[Diagnoser]]:
    """Identifier -> class of every diagnoser, sorted.

    Raises
    ------
    BadInput : if two have the same identifier, or a plug-in cannot be loaded.
    """
    found: dict[str, type[Diagnoser]] = {}
    for cls in [*_own(), *_installed()]:
        if found.setdefault(cls.name, cls) is not cls:
            raise BadInput(f"diagnoser {cls.name!r} is defined twice", file=cls.__module__)
    return dict(sorted(found.items()))


def find(text: str) -> type[Diagnoser]:
    """The class that `text` names: an identifier or `path.py:Class`; BadInput if there is none."""
    if ".py:" in text:
        path, _, name = text.rpartition(":")
        return _checked(getattr(load_file(path), name, None), text)
    known = diagnosers()
    if text not in known:
        hint = suggestion(text, known, f"known: {', '.join(known)}; or path.py:Class")
        raise BadInput(f"unknown diagnoser {text!r}", hint=hint)
    return known[text]


def _own() -> list[type[Diagnoser]]:
    package = importlib.import_module(FOLDER, __package__)
    modules = [
        importlib.import_module(f"{package.__name__}.{entry.name}") for entry in pkgutil.iter_modules(package.__path__)
    ]
    return [
        cls
        for module in modules
        for _, cls in inspect.getmembers(module, inspect.isclass)
        if issubclass(cls, Diagnoser) and cls.name and cls.__module__ == module.__name__
    ]


def _installed() -> list[type[Diagnoser]]:
    found = []
    for point in entry_points(group=GROUP):
        try:
            found.append(_checked(point.load(), point.value))
        except BadInput:
            raise
        except Exception as error:  # whatever a foreign package raises while it is imported
            raise BadInput(f"diagnoser plug-in cannot be loaded: {error}", file=point.value) from error
    return found


def _checked(cls: Any, where: str) -> type[Diagnoser]:
    if not (isinstance(cls, type) and issubclass(cls, Diagnoser) and cls.name):
        raise BadInput("not a subclass of helmbench.diagnosis.registry.Diagnoser with a name", file=where)
    return cls
