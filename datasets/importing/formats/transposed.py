"""Tables that lie on their side: a row for every channel, a column for every time."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from ....models.errors import BadInput
from ....models.number_texts import DECIMAL
from ..layout import distinct
from ..raw import RawColumn, RawTable, Rejected, with_faults

SEPARATORS = ",;\t"
NUMBER = re.compile(DECIMAL)
STAMP = re.compile(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d.*")
FEWEST_TIMES, MOST_CHANNELS, HEAD = 10, 500, 4000
"""Times and channels of such a table; characters of its first line that are looked at."""


def _is_transposed(text: str) -> bool:
    """Whether the first line is a word and then times that rise, and the lines below it are a word and then numbers."""
    stop = text.find("\n")
    first, rest = text[:stop].lstrip("\ufeff"), text[stop + 1 : stop + 1 + HEAD]
    for separator in SEPARATORS:
        cells = _cells(first[:HEAD], separator)[: -1 if len(first) > HEAD else None]
        below = _cells(rest.partition("\n")[0], separator)[:FEWEST_TIMES]
        if len(cells) > FEWEST_TIMES and _are_times(cells[1:]) and len(below) > 2:
            named = not any(map(NUMBER.fullmatch, (cells[0], below[0])))
            return named and all(not cell or NUMBER.fullmatch(cell) for cell in below[1:])
    return False


def _cells(line: str, separator: str) -> list[str]:
    return [cell.strip().strip('"') for cell in line.rstrip("\r").split(separator)]


def _are_times(cells: list[str]) -> bool:
    """Whether cells are stamps with a date, or numbers that rise and are more than counted columns."""
    if all(map(STAMP.fullmatch, cells)):
        return cells == sorted(cells)
    if not all(map(NUMBER.fullmatch, cells)):
        return False
    times = np.array(cells, dtype=float)
    return bool(np.all(np.diff(times) > 0.0)) and not np.array_equal(times - times[0], np.arange(times.size))


def read_transposed(text: str, path: Path) -> list[RawTable] | None:
    """The table, turned round: a column for every row, None where it does not lie on its side; BadInput where no row
    has a number for every time."""
    if not _is_transposed(text):
        return None
    lines = [line for line in text.lstrip("\ufeff").splitlines() if line.strip()]
    separator = max(SEPARATORS, key=lines[0].count)
    head = _cells(lines[0], separator)
    faults: list[Rejected] = []
    series: list[tuple[str, np.ndarray]] = []
    for number, line in enumerate(lines[1:], start=2):
        name, *cells = _cells(line, separator)
        if len(cells) != len(head) - 1 or len(series) >= MOST_CHANNELS:
            faults.append((number, f"{len(cells)} numbers under {len(head) - 1} times", line[:200]))
        elif any(cells):
            series.append((name, np.array([float(c) if NUMBER.fullmatch(c) else np.nan for c in cells])))
    if not series:
        raise BadInput("no row has a number for every time", file=path, hint="is the file whole? export it again")
    names = distinct([name or "channel" for name, _ in series])
    columns = [RawColumn("time", "", tuple(head[1:]))]
    columns += [RawColumn(name, "", values) for name, (_, values) in zip(names, series, strict=True)]
    done = "a row for every channel and a column for every time: turned round"
    return with_faults([RawTable.of(path, columns, done, rows=np.arange(2, len(head) + 1))], faults)
