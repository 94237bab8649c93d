"""Arguments of commands: models and records, or what stands for them; wrong numbers are told by their names."""

from __future__ import annotations

import math
from collections.abc import Sequence
from numbers import Integral, Real
from os import PathLike, fspath
from typing import TYPE_CHECKING

from ..datasets.record import Record
from ..models.argument_types import shown
from ..models.errors import BadInput
from ..models.result import FilePath as Path

if TYPE_CHECKING:
    from ..models.model import Model

AUTO = "auto"
"""Stands for every model that the records allow."""
METHOD = "output-error"
"""The method that identifies where none is named."""


def as_model(model: Model | Path) -> Model:
    """The model itself, or the one that an identifier or a path stands for; BadInput where there is none."""
    from ..models.model import Model, resolve

    return model if isinstance(model, Model) else resolve(model)


def as_records(records: Record | Path | Sequence[Record | Path], positive_rudder: str | None = None) -> list[Record]:
    """One record or several, read where they are paths; BadInput where a file cannot be used or has no rudder."""
    from ..datasets.io import read_record

    read = []
    for one in listed(records):
        record = read_record(one, positive_rudder) if isinstance(one, str | PathLike) else one
        try:
            record.rudder()
        except BadInput as error:
            file = fspath(one) if isinstance(one, str | PathLike) else record.name
            raise BadInput(error.message, file=file, column=error.column, hint=error.hint) from error
        read.append(record)
    return read


def listed(records: Record | Path | Sequence[Record | Path]) -> list[Record | Path]:
    """One record or path, or several, as a list."""
    return [records] if isinstance(records, Record | str | PathLike) else list(records)


def labels(records: Record | Path | Sequence[Record | Path]) -> list[str]:
    """What results call the records: paths as they were given, or the records' names."""
    return [one.name if isinstance(one, Record) else fspath(one) for one in listed(records)]


def check_numbers(**given: object) -> None:
    """BadInput, naming the argument, where one is neither None nor a finite number."""
    for name, value in given.items():
        if value is not None and not _is_finite(value):
            raise BadInput(f"{name} is {shown(value)}", hint="give a finite number")


def check_seed(seed: object) -> None:
    """BadInput where a seed is no whole number of at least 0."""
    if isinstance(seed, bool) or not isinstance(seed, Integral) or seed < 0:
        raise BadInput(f"seed is {shown(seed)}", hint="give a whole number of at least 0")


def _is_finite(value: object) -> bool:
    try:
        return not isinstance(value, bool) and isinstance(value, Real) and math.isfinite(value)
    except OverflowError:  # a whole number of hundreds of digits
        return False
