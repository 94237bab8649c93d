"""Results as text: JSON for machines, tables for the terminal, files of a folder."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..models.errors import BadInput

if TYPE_CHECKING:
    from ..estimation.estimate import Estimate


def json_text(value: Any) -> str:
    """A value as indented JSON; what is not a finite number is null."""
    from ..bench.store import plain

    return json.dumps(plain(value), indent=1, allow_nan=False)


def write_together(folder: Path, writers: Mapping[str, Callable[[Path], object]]) -> tuple[Path, ...]:
    """Write files of a folder, which is made if need be: all of them or none.

    writers : name of the file -> function that writes it to a path.

    Raises
    ------
    BadInput : the folder cannot be made or written to.
    """
    from ..datasets.files import replace_together

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


def titles_text(titles: Mapping[str, str]) -> str:
    """Identifiers and their titles in two columns."""
    from ..reporting.tables import Cell, Table, console

    return console(Table(("", ""), tuple((Cell(name), Cell(title)) for name, title in titles.items())))


def parameters_text(estimate: Estimate) -> str:
    """The parameters of an estimate with their standard errors, as a table."""
    from ..reporting.identification import parameter_table
    from ..reporting.tables import console

    return console(parameter_table(estimate), indent="  ")


def scores_text(scores: Mapping[str, Any]) -> str:
    """Errors of free runs and of one-step predictions by channel, as a table."""
    from ..reporting.identification import score_table
    from ..reporting.tables import console

    return console(score_table(scores), indent="  ")
