"""Logs whose lines name each value: `ts=2026-03-14T10:00:00Z level=info hdg=271.4 rudder_deg=-3`, as logfmt."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ....models.number_texts import DECIMAL
from ..moments import time_in
from ..names import is_time
from ..raw import RawTable, usable
from .object_tables import Row, tables_of_rows

PAIR = re.compile(r'(?<![^\s,;|])([^\W\d][\w.\-/]*)\s?[=:]\s?("[^"]*"|[^\s,;|"]+)(?=[\s,;|]|$)')
NUMBER = re.compile(DECIMAL)
STAMP = "timestamp"
FEWEST, LONGEST = 2, 5000
"""Pairs of a line, and its characters."""


def looks_like_named_values(text: str) -> bool:
    """Whether most of the first lines hold numbers, each behind its name and a sign of equality, or behind a colon,
    the same names in all."""
    lines = [line for line in text[:20000].splitlines()[:60] if line.strip()][:-1]
    named = [_names(line) for line in lines]
    equal = [sum(sign == "=" for _, sign in own) >= FEWEST for own in named]
    alike = [len(own) >= FEWEST and own == named[0] for own in named]
    return len(lines) > 2 and any(sum(fits) > 0.8 * len(lines) for fits in (equal, alike))


def _names(line: str) -> list[tuple[str, str]]:
    """(name, sign) of the numbers of a line."""
    pairs = (match for match in PAIR.finditer(line[:LONGEST]) if NUMBER.fullmatch(match[2]))
    return [(match[1], "=" if "=" in match[0] else ":") for match in pairs]


def read_named_values(text: str, path: Path) -> list[RawTable]:
    """The tables of a log of named values: one for each kind of line; BadInput where none holds numbers."""
    return usable(tables_of_rows(list(_rows(text)), path), path, "no line of named values with numbers found")


def _rows(text: str) -> Iterator[Row]:
    """(line, values) of the lines that hold some; a time before them is one, too."""
    for number, line in enumerate(text.splitlines(), start=1):
        pairs = list(PAIR.finditer(line)) if len(line) <= LONGEST else []
        values: dict[str, Any] = {pair[1]: _value(pair[2]) for pair in pairs}
        if len(values) >= FEWEST:
            stamp, _ = time_in(line[: pairs[0].start()])
            yield number, ({STAMP: stamp} if stamp and not any(map(is_time, values)) else {}) | values


def _value(text: str) -> float | str:
    return float(text) if NUMBER.fullmatch(text) else text.strip('"')
