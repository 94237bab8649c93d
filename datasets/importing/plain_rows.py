"""Rows of plain text at once, by Arrow where it is installed.

Plain are rows of ASCII without quotes, comments and repeated headers.  All others, and all rows where one looks
otherwise, are left to the reader that takes line by line; both find the same cells, line numbers and faults.
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from ..arrow_csv import FEWEST_BYTES, arrow
from .cell_texts import Texts
from .cells import GAPS
from .layout import LONGEST, DataRows, Layout, Line, PlainRows, is_header_again, of_other_width

PLAIN = bytes(sorted({*range(32, 127), *b"\t\r\n"} - {*b'"#%!*('}))
"""Characters of plain rows: none that quotes or begins a comment."""
SEPARATORS = ";\t|,"
MOST_FAULTS = 1000
"""Rows of another width up to which the others are plain."""


def plain_reader(text: str, separator: str, trailing: int | None) -> PlainRows | None:
    """The reader of the plain rows of a text; None where none are to be expected.

    trailing : number of cells where every line ends with a separator, as `read_text` finds it; None: none does.
    """
    if len(text) < FEWEST_BYTES or separator not in SEPARATORS or arrow() is None:
        return None
    return lambda layout, start: _plain_rows(text, separator, trailing, layout, start)


def _plain_rows(text: str, separator: str, trailing: int | None, layout: Layout, start: int) -> DataRows | None:
    body = _from_line(text, start)
    if trailing not in (None, layout.width + 1) or not _is_plain(body):
        return None
    found = _cells(body, separator, layout.width if trailing is None else trailing, start)
    if found is None:
        return None
    cells, odd = found
    if trailing is not None and not cells.pop().among(("",)).all():
        return None
    faults = [of_other_width(line, layout.width) for line in odd if any(cell.strip() for cell in line.cells)]
    if any(len(cell) > LONGEST for line in odd for cell in line.cells) or not _all_are_data(cells, layout):
        return None
    numbers = np.arange(start, start + len(cells[0]) + len(odd))
    return DataRows(cells, np.delete(numbers, [line.number - start for line in odd]), tuple(faults))


def _from_line(text: str, number: int) -> bytes:
    """The text from a line on, without empty lines at its end."""
    place = 0
    for _ in range(number - 1):
        place = text.index("\n", place) + 1
    return text[place:].encode().rstrip(b"\r\n")


def _is_plain(body: bytes) -> bool:
    """Whether no row is empty, a comment, or holds a character beyond the plain ones."""
    if body.translate(None, PLAIN) or b"\n\n" in body or b"\n\r\n" in body or b"//" in body:
        return False
    return b";" not in body or not (re.match(rb"[ \t]*;", body) or re.search(rb"\n[ \t]*;", body))


def _cells(body: bytes, separator: str, width: int, start: int) -> tuple[list[Texts], list[Line]] | None:
    """(The texts of the columns, rows of another width); None where Arrow refuses, or there are many of these."""
    pa = arrow()
    odd: list[Line] = []

    def skip(row: Any) -> str:
        odd.append(Line(start + row.number - 1, tuple(row.text.rstrip("\r").split(separator))))
        return "skip" if len(odd) <= MOST_FAULTS else "error"

    names = [str(i) for i in range(width)]
    try:
        table = pa.csv.read_csv(
            pa.BufferReader(body),
            read_options=pa.csv.ReadOptions(column_names=names, use_threads=False),  # only then are rows numbered
            parse_options=pa.csv.ParseOptions(delimiter=separator, quote_char=False, invalid_row_handler=skip),
            convert_options=pa.csv.ConvertOptions(column_types=dict.fromkeys(names, pa.string()), check_utf8=False),
        )
    except pa.ArrowException:
        return None
    return [Texts.of_arrow(column.combine_chunks()) for column in table.columns], odd


def _all_are_data(cells: list[Texts], layout: Layout) -> bool:
    """Whether no row is a header that is repeated, empty, or has a cell that is too long."""
    if any(texts.longest > LONGEST for texts in cells):
        return False
    known = np.zeros(len(cells[0]), dtype=bool)
    for texts in cells:
        numbers = texts.floats(~texts.among(GAPS))
        known |= np.isfinite(numbers) if numbers is not None else False
        if known.all():
            return True
    rows = np.flatnonzero(~known)
    for row in zip(*(texts.take(rows) for texts in cells), strict=True):
        if not any(cell.strip() for cell in row) or is_header_again(row, layout):
            return False
    return True
