"""What the results of all commands share: text, page, picture in a notebook, files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

from .documents import content_writer, json_text, model_writer, write_together

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..models.model import Model
    from ..reporting.page import Page
    from .arguments import Path as FilePath


class Told:
    """A result with text, in the terminal and in a notebook.

    room : the module of `reporting` that makes its page.
    pictured : what the picture in a notebook shows; empty: there is none.
    """

    room: ClassVar[str]
    pictured: ClassVar[str] = ""

    if TYPE_CHECKING:

        def plot(self) -> Figure: ...

    @classmethod
    def of(cls, found: Any) -> Self:
        """The same result with what its class adds."""
        return cls(**{entry.name: getattr(found, entry.name) for entry in fields(found)})

    def summary(self) -> str:
        """The result in a few lines of text."""
        from ..reporting.media import terminal

        return terminal(page_of(self))

    def _repr_html_(self) -> str:
        from ..models.figure import picture
        from ..reporting.media import notebook

        return notebook(page_of(self)) + (picture(self.plot, self.pictured) if self.pictured else "")


def page_of(found: Told) -> Page:
    """What a result says, as blocks for every medium."""
    return import_module(f"helmbench.reporting.{found.room}").page(found)


class Result(Told):
    """A result with text, page, picture and files.

    files : names of its document and page.
    """

    files: ClassVar[tuple[str, str]]

    if TYPE_CHECKING:

        def to_json(self) -> dict[str, Any]: ...

    def _models(self) -> Mapping[str, Model]:
        """Models that are written beside document and page, by name of the file."""
        return {}

    def to_html(self) -> str:
        """The page of the result: one self-contained HTML document."""
        from ..reporting.media import html

        return html(page_of(self))

    def write(self, folder: FilePath) -> tuple[Path, ...]:
        """Write the document (JSON), the page (HTML) and the models of the result into a folder: all of them or none.

        Returns
        -------
        The paths of the files.

        Raises
        ------
        BadInput : the folder cannot be written to.
        """
        document, page = self.files
        writers = {document: content_writer(json_text(self.to_json()) + "\n"), page: content_writer(self.to_html())}
        models = {name: model_writer(name, model) for name, model in self._models().items()}
        return write_together(Path(folder), writers | models)


class RunsResult(Result):
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
        from ..reporting.runs import figure_of

        return figure_of(page_of(self).records(), record, self.room.partition(".")[0])
