"""Logs of autopilots as text: dataflash logs of ArduPilot, in which FMT lines name the fields of the messages that
follow, and MAVLink messages."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ....models.number_texts import DECIMAL
from ..cells import PLAIN
from ..raw import RawTable, Rejected, usable, with_faults
from .autopilots import ARDUPILOT, ardupilot_tables, instance, seconds
from .object_tables import number_of, tables_of_rows

FORMAT = re.compile(r"FMT,\s*\d+,\s*\d+,\s*(?P<kind>\w{1,4}),\s*(?P<format>\w+)?,\s*(?P<names>.*)")


def looks_like_dataflash(text: str) -> bool:
    """Whether a text begins as a dataflash log."""
    lines = [line for line in text[:4000].splitlines() if line.strip()][:10]
    return sum(FORMAT.match(line) is not None for line in lines) >= min(3, max(len(lines) - 1, 1))


def read_dataflash(text: str, path: Path) -> list[RawTable]:
    """A table for every known kind of message; BadInput where there is none."""
    names: dict[str, list[str]] = {}
    rows: dict[str, list[dict[str, float]]] = defaultdict(list)
    faults: list[Rejected] = []
    parameters: dict[str, float] = {}
    count = 0
    for number, line in enumerate(text.splitlines(), start=1):
        if match := FORMAT.match(line):
            names[match["kind"]] = [name.strip() for name in match["names"].split(",")]
            continue
        kind, *cells = [cell.strip() for cell in line.split(",")]
        if kind == "PARM" and (value := _parameter(cells)):
            parameters |= value
        if kind not in ARDUPILOT or kind not in names:
            continue
        count += 1
        row = _row(names[kind], cells)
        if row is None:
            faults.append((number, f"not the fields of {kind}", line))
        else:
            rows[instance(kind, row)].append(row)
    return with_faults(ardupilot_tables(rows, parameters, path), faults, count)


def _parameter(cells: list[str]) -> dict[str, float]:
    """Name and value of a parameter, wherever they stand in its line; nothing where they do not."""
    name = next((i for i, cell in enumerate(cells) if re.match(r"[A-Z]", cell)), len(cells))
    return {cells[name]: float(cells[name + 1])} if name + 1 < len(cells) and PLAIN.fullmatch(cells[name + 1]) else {}


def _row(names: list[str], cells: list[str]) -> dict[str, float] | None:
    """Field -> number of a message; None where it has other fields or no time."""
    if len(cells) != len(names):
        return None
    row = {name: number_of(cell) for name, cell in zip(names, cells, strict=True)}
    return row if np.isfinite(seconds(row)) else None


# ---- MAVLink messages, one a line: as mavlogdump prints them, a stamp, the name of the message, its fields in
# braces; as Mission Planner writes them, a stamp, the name among other cells, then names and values in turn.

LINE = re.compile(
    r"(?P<stamp>\d{4}-\d\d-\d\d \d\d:\d\d:\d\d(?:\.\d+)?): (?P<name>[A-Z][A-Z0-9_]+) \{(?P<fields>.*)\}\s*$"
)
CELLS = re.compile(
    r"(?P<stamp>\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(?:\.\d+)?),.{0,80}?,mavlink_(?P<name>\w+?)_t,(?P<fields>.*)"
)
NUMBER = re.compile(DECIMAL)
FIELD = re.compile(rf"(?P<name>\w+) : (?P<number>{DECIMAL})(?=,|$)")


def looks_like_mavlink_text(text: str) -> bool:
    """Whether most of the first lines are messages."""
    lines = [line for line in text[:20000].splitlines()[:50] if line.strip()][:-1]
    return len(lines) > 2 and sum(
        LINE.match(line) is not None or CELLS.match(line) is not None for line in lines
    ) > 0.8 * len(lines)


def read_mavlink_text(text: str, path: Path) -> list[RawTable]:
    """A table for every kind of message; BadInput where none holds numbers."""
    return usable(tables_of_rows(list(_rows(text)), path), path, "no message with numbers found")


def _rows(text: str) -> Iterator[tuple[int, dict[str, Any]]]:
    for number, line in enumerate(text.splitlines(), start=1):
        match = LINE.match(line) if len(line) < 5000 else None
        if match is not None:
            fields = {found["name"]: float(found["number"]) for found in FIELD.finditer(match["fields"])}
            yield number, {"timestamp": match["stamp"], "type": match["name"]} | fields
        elif len(line) < 5000 and (match := CELLS.match(line)):
            cells = match["fields"].split(",")
            pairs = zip(cells[::2], cells[1::2], strict=False)
            fields = {name: float(value) for name, value in pairs if name and NUMBER.fullmatch(value)}
            yield number, {"timestamp": match["stamp"], "type": match["name"].upper()} | fields
