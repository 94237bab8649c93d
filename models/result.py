"""What the results of all commands share: text, page, picture in a notebook, files.

A result stands where it is made.  The room above that says what it holds is imported when a user asks for it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from importlib import import_module
from os import PathLike
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias

from .files import content_writer, write_together
from .plain import json_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .model import Model

FilePath: TypeAlias = "str | PathLike[str]"


def above(module: str) -> ModuleType:
    """A module of helmbench that is above the room of a result: 'reporting.runs'."""
    return import_module(f"{__name__.partition('.')[0]}.{module}")


class Result:
    """A result with text, in the terminal and in a notebook.

    room : the module of `reporting` that makes its page.
    pictured : what the picture in a notebook shows; empty: there is none.
    """

    room: ClassVar[str]
    pictured: ClassVar[str] = ""

    if TYPE_CHECKING:

        def plot(self) -> Figure: ...

    def summary(self) -> str:
        """The result in a few lines of text."""
        return above("reporting.media").terminal(page_of(self))

    def _repr_html_(self) -> str:
        from .figure import picture

        return above("reporting.media").notebook(page_of(self)) + (
            picture(self.plot, self.pictured) if self.pictured else ""
        )


def page_of(result: Result) -> Any:
    """What a result says, as blocks for every medium (`reporting.page.Page`)."""
    return above(f"reporting.{result.room}").page(result)


class FileResult(Result):
    """A result with text, page, picture and files.

    files : names of its document and page, and of the models beside them.
    """

    files: ClassVar[tuple[str, ...]]

    if TYPE_CHECKING:

        def to_json(self) -> dict[str, Any]: ...

    def _models(self) -> Mapping[str, Model]:
        """Models that are written beside document and page, by name of the file."""
        return {}

    def to_html(self) -> str:
        """The page of the result: one self-contained HTML document."""
        return above("reporting.media").html(page_of(self))

    def write(self, folder: FilePath) -> tuple[Path, ...]:
        """Write the document (JSON), the page (HTML) and the models of the result into a folder: all of them or none.

        Returns
        -------
        The paths of the files.

        Raises
        ------
        BadInput : the folder cannot be written to.
        """
        document, page = self.files[:2]
        writers = {document: content_writer(json_text(self.to_json()) + "\n"), page: content_writer(self.to_html())}
        models = {name: _model_writer(name, model) for name, model in self._models().items()}
        return write_together(Path(folder), writers | models)


class RunsResult(FileResult):
    """A result that holds runs along records."""

    def plot(self, record: str | None = None) -> Figure:
        """Draw the measured channels of a record and the runs along it over time.

        Parameters
        ----------
        record : name of a record of the result; None: the first held-out one, else the first.

        Returns
        -------
        A matplotlib figure, not attached to pyplot: save it with `savefig`.  Angles are in degrees.

        Raises
        ------
        BadInput : there is no such record.
        """
        records = page_of(self).records()
        return above("reporting.runs").figure_of(records, record, self.room.partition(".")[0])


def _model_writer(name: str, model: Model) -> Callable[[Path], None]:
    """A function that writes a model to a path, the stem of its file's name as identifier."""

    def write(place: Path) -> None:
        from .model import model_to_json

        model_to_json(replace(model, id=Path(name).stem), place)

    return write
