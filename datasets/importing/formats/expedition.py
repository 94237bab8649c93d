"""Logs of the racing program Expedition: pairs of channel number and value."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import numpy as np

from ....models.errors import BadInput
from ..layout import distinct
from ..raw import RawColumn, RawTable, Rejected, with_faults
from .fields import StatedField, stated_fields


def read_expedition(text: str, path: Path) -> list[RawTable] | None:
    """The channels of the own boat (0), None where the text is no log of Expedition; BadInput where it holds no
    numbers."""
    if not re.match(r"!?\s*boat\s*,\s*utc\s*,", text[:200], re.IGNORECASE):
        return None
    lines = list(csv.reader(text.splitlines()))
    names, places = [c.strip() for c in lines[0]], [c.strip() for c in lines[1]] if len(lines) > 1 else []
    named = {place: name for name, place in zip(names[1:], places[1:], strict=False) if place.isdigit()}
    rows: list[tuple[int, dict[str, float]]] = []
    faults: list[Rejected] = []
    for number, cells in enumerate(lines[2:], start=3):
        if not cells or cells[0].lstrip().startswith("!"):
            continue
        row = _row(cells)
        if row is None:
            faults.append((number, "no pairs of channel and value", ",".join(cells)))
        elif cells[0].strip() == "0":
            rows.append((number, row))
    used = [place for place in named if any(place in row for _, row in rows)]
    if "0" not in used or len(used) < 2:
        raise BadInput("no rows with a time and a channel", file=path)
    names = zip(used, distinct([named[place] for place in used]), strict=True)
    columns = [_column(name, np.array([row.get(place, np.nan) for _, row in rows])) for place, name in names]
    return with_faults([RawTable.of(path, columns, "Expedition", rows=[number for number, _ in rows])], faults)


def _row(cells: list[str]) -> dict[str, float] | None:
    """Channel number -> value of a line; None where it is none."""
    pairs = cells[1:]
    try:
        return {pairs[i].strip(): float(pairs[i + 1]) for i in range(0, len(pairs) - 1, 2) if pairs[i].strip()}
    except ValueError:
        return None


def _column(name: str, numbers: np.ndarray) -> RawColumn:
    key = name.lower()
    if key == "utc":
        return RawColumn(name, "", numbers, "time", "Expedition states it: days in UTC")
    _, known, unit = stated_fields("Expedition")["channel"].get(key, StatedField(name, "", ""))
    return RawColumn(name, unit, numbers, known, "Expedition states it" if known else "")
