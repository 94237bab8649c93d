"""Several tables below each other in one text, each with a header of its own."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...models.errors import BadInput
from .cells import is_number
from .headers import says_unit
from .layout import Line, is_data
from .raw import RawTable

SEPARATORS = ",;\t|"
WORDS = re.compile(r"^[ \t]*[\"'\[#*]?[^\W\d][^\n]*$", re.MULTILINE)
"""A line that begins with a word."""
FIRST, MOST, MOST_TABLES = 3, 300, 20
"""Rows of the least table, and lines of words from which on words are the data of a log; tables that are read."""


def parts_of(text: str) -> list[str]:
    """The text, cut above each further header: names of other columns than before, and rows of numbers below them."""
    heads = [match.start() for match in itertools.islice(WORDS.finditer(text), MOST + 1)]
    if not 1 < len(heads) <= MOST:
        return [text]
    cuts, before = [0], set[str]()
    for start in heads:
        names = _header(text, start)
        if names and before and len(cuts) < MOST_TABLES and len(names & before) <= 0.5 * len(names):
            cuts.append(_after_data(text, start))
        before = names or before
    return [text[a:b] for a, b in zip(cuts, [*cuts[1:], len(text)], strict=True)]


def _header(text: str, start: int) -> set[str]:
    """The names of the line at a place, where rows of as many numbers stand below it; else nothing."""
    lines = [line for line in text[start : start + 20000].splitlines()[:12] if line.strip()][:6]
    if len(lines) < FIRST + 1:
        return set()
    separator = max(SEPARATORS, key=lines[-1].count)
    rows = [[cell.strip().strip("\"'#") for cell in line.rstrip(f"\r{separator}").split(separator)] for line in lines]
    width = len(rows[-1])
    if width < 2 or len(rows[0]) != width or any(map(is_number, rows[0])) or all(map(says_unit, rows[0])):
        return set()
    body = rows[-FIRST:]
    return {re.split(r"[\[(]", name)[0].strip() for name in rows[0]} if all(map(is_data, body)) else set()


def _after_data(text: str, start: int) -> int:
    """Behind the last line of data before a header: the lines between belong to it."""
    while start > 0:
        before = text.rfind("\n", 0, start - 1) + 1
        line = text[before:start].strip()
        separator = max(SEPARATORS, key=line.count)
        if line and is_data(line.split(separator)) and line.count(separator):
            return start
        start = before
    return 0


def read_parts(text: str, path: Path, read: Callable[[str], RawTable]) -> list[RawTable]:
    """The tables of a text, read one by one; a part without rows of numbers is left out where others have some."""
    parts = parts_of(text)
    if len(parts) == 1:
        return [read(text)]
    out, line = [], 0
    for number, part in enumerate(parts, start=1):
        try:
            table = _shifted(read(part), line)
            title = _title(part)
            named = title and all(title != other.sheet for other in out)
            out.append(replace(table, sheet=title if named else f"table {number}"))
        except BadInput:
            if number == len(parts) and not out:
                raise
        line += part.count("\n")
    return out


def _title(part: str) -> str:
    """The only text of the first line of a part, where it is no header."""
    first = next((line.strip(' \t\r,;#*[]"') for line in part.splitlines() if line.strip()), "")
    return "" if any(separator in first for separator in SEPARATORS) else first[:60]


def _shifted(table: RawTable, lines: int) -> RawTable:
    """A table with the line numbers of the whole file."""
    faults = tuple((number + lines, said, text) for number, said, text in table.faults)
    return replace(table, rows=np.asarray(table.rows) + lines, faults=faults)


def blocks_of(lines: Sequence[Line]) -> list[list[Line]]:
    """Lines of a sheet, cut above each further header: names of other columns than before, and rows of data below."""
    cuts, before = [0], set[str]()
    for i, line in enumerate(lines):
        names = {cell.strip() for cell in line.cells if cell.strip()}
        body = [other.cells for other in lines[i + 1 : i + 1 + FIRST]]
        if len(names) < 2 or is_data(line.cells) or any(map(is_number, names)) or all(map(says_unit, names)):
            continue
        if len(body) < FIRST or not all(map(is_data, body[1:])):
            continue
        last = i - 1
        while last > 0 and sum(map(bool, lines[last].cells)) < 2:  # a title belongs to the table below it
            last -= 1
        if before and len(names & before) <= 0.5 * len(names) and is_data(lines[last].cells):
            cuts.append(last + 1)
        before = names
    return [list(lines[a:b]) for a, b in zip(cuts, [*cuts[1:], len(lines)], strict=True)]
