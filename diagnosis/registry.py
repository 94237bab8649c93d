"""Finding diagnosers: those of this package, installed entry points, and files of the user's own.

A diagnoser is a class with a `name` and a `title` that has one method,
`diagnose(model, train, held_out, options) -> Diagnosis`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

from ..models.discovery import by_name, class_in_file, classes_of, known, plug_ins

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..datasets.record import Record
    from ..models.model import Model
    from .options import Options
    from .result import Diagnosis

GROUP = "helmbench.diagnosers"
"""Entry-point group by which other packages add diagnosers."""
FOLDER = "baselines"
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
    own = classes_of(f"{__package__}.{FOLDER}", Diagnoser, "name")
    return by_name("diagnoser", [*own, *plug_ins(GROUP, "diagnoser", Diagnoser, "name")], "name")


def find(text: str) -> type[Diagnoser]:
    """The class that `text` names: an identifier or `path.py:Class`; BadInput if there is none."""
    if ".py:" in text:
        return class_in_file(text, Diagnoser, "name")
    every = diagnosers()
    return known("diagnoser", text, every, f"known: {', '.join(every)}; or path.py:Class")
