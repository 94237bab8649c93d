"""What formats state of the fields of their messages, read from `fields.yaml`, and tables of such fields."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ....models.data_file import load
from ..raw import RawColumn, RawTable

NUMBERED = re.compile(r"\{(\d+)\.\.(\d+)\}")
BY_NAME = "by name"


class StatedField(NamedTuple):
    """name : of the column of a field.  quantity : in the record's sign convention; 'not used', or '' where the name
    tells it.  unit : '' for none."""

    name: str
    quantity: str
    unit: str


@cache
def stated_fields(program: str) -> dict[str, dict[str, StatedField]]:
    """Message of a program -> field -> what its format states of it."""
    messages = load(Path(__file__).with_suffix(".yaml"))[program]
    return {str(message): dict(_numbered(fields)) for message, fields in messages.items()}


def _numbered(fields: Mapping[str | int, str]) -> Iterator[tuple[str, StatedField]]:
    """(field, what is stated of it), one for every number of fields that are alike."""
    for field, said in fields.items():
        quantity, unit, *name = (part.strip() for part in said.split("|"))
        called = name[0] if name else quantity.replace("_", " ")
        several = NUMBERED.search(str(field))
        for number in range(int(several[1]), int(several[2]) + 1) if several else (0,):
            own = StatedField(called.format(number), "" if quantity == BY_NAME else quantity, unit)
            yield NUMBERED.sub(str(number), str(field)), own


def table_of_fields(
    path: Path,
    fields: Mapping[str, StatedField],
    values: Mapping[str, np.ndarray],
    time: RawColumn,
    done: str,
    sheet: str = "",
    rows: Sequence[int] | None = None,
) -> RawTable | None:
    """The table of a message: its time and the fields (N,) that hold numbers, stated by whom the time is; None where
    none does.

    rows : lines of the file, of each row.
    """
    held = {name: values[name] for name in fields if name in values and np.isfinite(values[name]).any()}
    columns = [RawColumn(f.name, f.unit, own, f.quantity, time.source) for n, own in held.items() for f in (fields[n],)]
    return RawTable.of(path, (time, *columns), done, sheet, rows) if columns else None
