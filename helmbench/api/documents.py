"""Results as text: JSON for machines, tables for the terminal, files of a folder."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..models.errors import BadInput
from ..models.plain import plain

if TYPE_CHECKING:
    from ..methods.options import Option
    from ..models.model import Model


def json_text(value: Any) -> str:
    """A value as indented JSON; what is not a finite number is null."""
    return json.dumps(plain(value), indent=1, allow_nan=False)


def write_together(folder: Path, writers: Mapping[str, Callable[[Path], object]]) -> tuple[Path, ...]:
    """Write files of a folder, which is made if need be: all of them or none.

    writers : name of the file -> function that writes it to a path.

    Raises
    ------
    BadInput : the folder cannot be made or written to.
    """
    from ..models.files import replace_together

    created = not folder.exists()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInput(f"cannot be made ({error.strerror or error})", file=folder) from None
    try:
        replace_together({folder / name: write for name, write in writers.items()})
    except BaseException:
        if created:
            folder.rmdir()
        raise
    return tuple(folder / name for name in writers)


def refuse_existing(paths: Iterable[Path]) -> None:
    """BadInput if one of the files exists."""
    from ..models.files import refuse_existing as refuse

    refuse(paths)


def titles_text(titles: Mapping[str, str]) -> str:
    """Identifiers and their titles in two columns."""
    from ..reporting.tables import Cell, Table, console

    return console(Table(("", ""), tuple((Cell(name), Cell(title)) for name, title in titles.items())))


def options_text(options: Sequence[Option]) -> str:
    """Options of a method with default, meaning, allowed values and searched range, a block each."""
    lines: list[str] = []
    for option in options:
        lines.append(f"{option.name}={option.default}")
        lines += [f"    {option.meaning}"] if option.meaning else []
        lines += [f"    allowed: {option.range}"] if option.range else []
        lines += [f"    tuning searches {option.searched}"] if option.searched else []
    return "\n".join(lines) or "no options"


def content_writer(content: str | bytes) -> Callable[[Path], object]:
    """A function that writes the content to a path, text as UTF-8."""

    def write(place: Path) -> None:
        place.write_bytes(content.encode() if isinstance(content, str) else content)

    return write


def model_writer(name: str, model: Model) -> Callable[[Path], None]:
    """A function that writes a model to a path, the stem of its file's name as identifier."""

    def write(place: Path) -> None:
        from ..models.model import model_to_json

        model_to_json(replace(model, id=Path(name).stem), place)

    return write
