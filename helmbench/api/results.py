"""What the results of all commands share: text, page, picture in a notebook, files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

from .documents import content_writer, json_text, model_writer, write_together

if TYPE_CHECKING:
    from ..models.model import Model
    from .arguments import Path as FilePath


class Told:
    """A result with text, in the terminal and in a notebook.

    room : where in `reporting` its text is made.
    """

    room: ClassVar[str]

    @classmethod
    def of(cls, found: Any) -> Self:
        """The same result with what its class adds."""
        return cls(**{entry.name: getattr(found, entry.name) for entry in fields(found)})

    def summary(self) -> str:
        """The result in a few lines of text."""
        return self._reporting("text").terminal(self)

    def _repr_html_(self) -> str:
        return self._reporting("text").notebook(self)

    def _reporting(self, part: str) -> Any:
        return import_module(f"helmbench.reporting.{self.room}.{part}")


class Result(Told):
    """A result with text, page, picture and files.

    files : names of its document and page.  pictured : what the picture in a notebook shows.
    """

    files: ClassVar[tuple[str, str]]
    pictured: ClassVar[str]

    if TYPE_CHECKING:

        def to_json(self) -> dict[str, Any]: ...

        def plot(self) -> Any: ...

    def _models(self) -> Mapping[str, Model]:
        """Models that are written beside document and page, by name of the file."""
        return {}

    def to_html(self) -> str:
        """The page of the result: one self-contained HTML document."""
        return self._reporting("page").html(self)

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

    def _repr_html_(self) -> str:
        from ..models.figure import picture

        return super()._repr_html_() + picture(self.plot, self.pictured)
