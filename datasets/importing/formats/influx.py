"""InfluxDB's annotated CSV: blocks of rows below annotations, long or with a column a field."""

from __future__ import annotations

import csv
import re
from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TypeAlias

from ..cell_texts import Texts
from ..instruments import UNITS
from ..names import joined
from ..raw import RawColumn, RawTable, Rejected, usable, with_faults

ANNOTATION = re.compile(r"#(datatype|group|default)\b", re.IGNORECASE)
TIME, FIELD, VALUE, MEASUREMENT = "_time", "_field", "_value", "_measurement"
OWN = ("", "result", "table", "_start", "_stop", TIME, FIELD, VALUE, MEASUREMENT)
"""Columns of InfluxDB itself; the others of a block in long form are tags."""
MOST_SERIES, FEWEST = 200, 3
GENERIC = ("value", "values", "val", "data")
"""Names of a field that say nothing: that of the measurement does."""


Block: TypeAlias = tuple[list[str], list[tuple[int, list[str]]]]
"""The names of a block, and its rows with their line numbers."""


def read_influx(text: str, path: Path) -> list[RawTable] | None:
    """A table for every series, None where the text begins neither with annotations nor with a header of InfluxDB;
    BadInput where no block has times and values."""
    first = text[:4000].lstrip("\ufeff\r\n ").partition("\n")[0]
    if ANNOTATION.match(first) is None and not {TIME, VALUE} <= {name.strip() for name in first.split(",")}:
        return None
    faults: list[Rejected] = []
    found = [table for block in _blocks(text, faults) for table in _tables(block, path)]
    hint = "export it with a header, as annotated CSV"
    return with_faults(usable(found, path, "no block with times and values", hint), faults)


def _blocks(text: str, faults: list[Rejected]) -> list[Block]:
    """The blocks of a file; a new one begins behind annotations or a blank line."""
    blocks: list[Block] = []
    waiting = True
    for number, line in enumerate(text.lstrip("\ufeff").splitlines(), start=1):
        if not line.strip(" ,\r") or ANNOTATION.match(line):
            waiting = True
            continue
        cells = next(csv.reader([line[:20000]]), [])
        if waiting and (TIME in cells or not blocks):
            blocks.append(([cell.strip() for cell in cells], []))
        elif blocks and len(cells) == len(blocks[-1][0]):
            blocks[-1][1].append((number, cells))
        else:
            faults.append((number, f"{len(cells)} cells under {len(blocks[-1][0]) if blocks else 0} columns", line))
        waiting = False
    return blocks


def _tables(block: Block, path: Path) -> Iterator[RawTable]:
    names, rows = block
    if TIME not in names or not rows:
        return
    if VALUE in names and FIELD in names:
        yield from _long(block, path)
        return
    columns = [(name, [cells[i] for _, cells in rows]) for i, name in enumerate(names) if name not in OWN]
    made = [RawColumn(name, "", Texts(cells)) for name, cells in columns if any(cells)]
    if made:
        times = _times([cells[names.index(TIME)] for _, cells in rows])
        yield RawTable.of(path, (times, *made), "InfluxDB", rows=[number for number, _ in rows])


def _long(block: Block, path: Path) -> Iterator[RawTable]:
    """A table for every field of every measurement and set of tags."""
    names, rows = block
    place = {name: i for i, name in enumerate(names)}
    tags = [i for name, i in place.items() if name not in OWN]
    groups: dict[tuple[str, ...], list[tuple[int, list[str]]]] = defaultdict(list)
    for number, cells in rows:
        measurement = cells[place[MEASUREMENT]] if MEASUREMENT in place else ""
        groups[measurement, cells[place[FIELD]], *(cells[i] for i in tags)].append((number, cells))
    several = [k for k, i in enumerate(tags) if len({key[2 + k] for key in groups}) > 1]
    for (measurement, name, *values), own in list(groups.items())[:MOST_SERIES]:
        if len(own) < FEWEST:
            continue
        unit = next((v for v, i in zip(values, tags, strict=True) if joined(names[i]) in UNITS), "")
        called = measurement if name.lower() in GENERIC and measurement else name
        sheet = " ".join(dict.fromkeys(part for part in (measurement, name, *(values[k] for k in several)) if part))
        column = RawColumn(called, unit, Texts([cells[place[VALUE]] for _, cells in own]))
        times = _times([cells[place[TIME]] for _, cells in own])
        yield RawTable.of(path, (times, column), f"{len(own)} values", sheet, [number for number, _ in own])


def _times(cells: Sequence[str]) -> RawColumn:
    return RawColumn("time", "", Texts(cells), source="InfluxDB states it: UTC")
