"""Logs of autopilots as text: dataflash logs of ArduPilot, in which FMT lines name the fields of the messages that
follow, and MAVLink messages."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ....models.errors import BadInput
from ....models.number_texts import DECIMAL
from ..cells import PLAIN
from ..raw import RawTable, Rejected, with_faults
from .autopilots import ARDUPILOT, message_table, with_steering
from .object_tables import tables_or_refusal

FORMAT = re.compile(r"FMT,\s*\d+,\s*\d+,\s*(?P<kind>\w{1,4}),\s*(?P<format>\w+)?,\s*(?P<names>.*)")
INSTANCE = ("I", "C")
"""Fields that number the sensor or the filter core of a message."""


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
            rows[_instance(kind, row)].append(row)
    made = [_table(path, kind, own) for kind, own in rows.items() if len(own) > 2]
    tables = [table for table in made if table is not None]
    if not tables:
        raise BadInput("no message of the log can be used", file=path, hint=f"read are {', '.join(ARDUPILOT)}")
    return with_steering(with_faults(tables, faults, count), parameters)


def _parameter(cells: list[str]) -> dict[str, float]:
    """Name and value of a parameter, wherever they stand in its line; nothing where they do not."""
    name = next((i for i, cell in enumerate(cells) if re.match(r"[A-Z]", cell)), len(cells))
    return {cells[name]: float(cells[name + 1])} if name + 1 < len(cells) and PLAIN.fullmatch(cells[name + 1]) else {}


def _row(names: list[str], cells: list[str]) -> dict[str, float] | None:
    """Field -> number of a message; None where it has other fields or no time."""
    if len(cells) != len(names):
        return None
    row = {}
    for name, cell in zip(names, cells, strict=True):
        try:
            row[name] = float(cell)
        except ValueError:
            row[name] = float("nan")
    return row if np.isfinite(_seconds(row)) else None


def _seconds(row: dict[str, float]) -> float:
    return 1e-6 * row["TimeUS"] if "TimeUS" in row else 1e-3 * row.get("TimeMS", float("nan"))


def _instance(kind: str, row: dict[str, float]) -> str:
    number = next((row[name] for name in INSTANCE if name in row), 0.0)
    return f"{kind} {number:g}" if number else kind


def _table(path: Path, kind: str, own: list[dict[str, float]]) -> RawTable | None:
    names = dict.fromkeys(name for row in own for name in row)  # a log may state a message anew
    values = {name: np.array([row.get(name, np.nan) for row in own]) for name in names}
    return message_table(path, kind, np.array([_seconds(row) for row in own]), values)


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
    return tables_or_refusal(list(_rows(text)), path, "message")


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
