"""MAVLink messages, one a line: as mavlogdump prints them, a stamp, the name of the message, its fields in braces; as
Mission Planner writes them, a stamp, the name among other cells, then names and values in turn."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ....models.number_texts import DECIMAL
from ..raw import RawTable
from .object_tables import tables_or_refusal

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
