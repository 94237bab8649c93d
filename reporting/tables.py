"""Tables: made from rows and columns in one way, written as HTML, Markdown, CSV and for the terminal.

A table holds both the text of a cell and its value: pages show the text and sort by the value, CSV has the value.
"""

from __future__ import annotations

import csv as csv_format
import io
import math
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from html import escape
from itertools import accumulate
from shutil import get_terminal_size
from typing import Any

from .numbers import MISSING, is_missing, number

WIDEST_PADDED = 40
"""Markdown cells are padded to the width of their column, but not beyond this many characters."""
FORMULA = re.compile(r"(^|[;\t\n])(\s*)(?=[=+\-@\uff1d\uff0b\uff0d\uff20])")
"""Where a spreadsheet takes what follows for a formula, also where a cell begins at a semicolon or a tab; CSV has an
apostrophe there."""
LONG = 48
"""HTML cells with more characters may be broken into lines."""


@dataclass(frozen=True)
class Cell:
    """One cell.

    text : what is shown;  value : what it is sorted by and what CSV holds, None where that is the text;
    markdown : what is shown instead of the text in Markdown, taken as it is.
    """

    text: str
    value: Any = None
    markdown: str | None = None

    @property
    def key(self) -> str:
        """What a page sorts by: a number as JavaScript reads it, empty where there is none, else the text."""
        if self.value is None:
            return "" if self.text == MISSING else self.text
        if is_missing(self.value):
            return ""
        return "1e999" if self.value == math.inf else str(self.value)

    @property
    def long(self) -> bool:
        """Whether a page may break the text into lines."""
        return len(self.text) > LONG


@dataclass(frozen=True)
class Column:
    """One column: its title, how a row becomes text, and the value behind the text (None: the text itself)."""

    title: str
    text: Callable[[Any], str]
    value: Callable[[Any], Any] | None = None
    markdown: Callable[[Any], str] | None = None

    def cell(self, row: Any) -> Cell:
        """The cell of a row."""
        value, markdown = (form(row) if form else None for form in (self.value, self.markdown))
        value = math.nan if self.value is not None and value is None else value
        return Cell(self.text(row), value, markdown)


@dataclass(frozen=True)
class Table:
    """Titles of columns and rows of cells; `kinds` names the kind of each row, for the page's style and filters."""

    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    title: str = ""
    note: str = ""
    kinds: tuple[str, ...] = ()

    @cached_property
    def numeric(self) -> tuple[bool, ...]:
        """Which columns hold numbers and are aligned to the right."""
        places = range(len(self.columns))
        return tuple(any(isinstance(row[j].value, int | float) for row in self.rows) for j in places)


Source = str | Callable[[Any], Any]
"""Where a column takes its values from: the key or attribute of the rows, or a function of a row."""


def field(source: str, title: str | None = None) -> Column:
    """A column of texts, one field of the rows."""
    return Column(source if title is None else title, lambda row: str(_taken(row, source)))


def numeric(title: str, source: Source, form: Callable[[Any], str] = number, scale: float = 1.0) -> Column:
    """A column of numbers, sorted by value; what is known of them is multiplied by `scale`."""

    def value(row: Any) -> Any:
        own = _taken(row, source)
        return own if is_missing(own) or scale == 1.0 else scale * own

    return Column(title, lambda row: form(value(row)), value)


def _taken(row: Any, source: Source) -> Any:
    if callable(source):
        return source(row)
    return row[source] if isinstance(row, Mapping) else getattr(row, source)


def make_table(
    columns: Sequence[Column],
    rows: Sequence[Any],
    title: str = "",
    note: str = "",
    kind: Callable[[Any], str] | None = None,
) -> Table:
    """The table of the rows; columns that are empty throughout are left out, such as efficiency from a single seed."""
    cells = [[column.cell(row) for column in columns] for row in rows]
    keep = [i for i in range(len(columns)) if any(row[i].text not in (MISSING, "") for row in cells)]
    kept = tuple(tuple(row[i] for i in keep) for row in cells)
    return Table(tuple(columns[i].title for i in keep), kept, title, note, tuple(map(kind, rows)) if kind else ())


def from_frame(frame: Any) -> Table:
    """A pandas frame as a table of its values, for `csv`."""
    names = tuple(map(str, frame.columns))
    rows = (tuple(Cell(str(value), value) for value in row) for row in frame.itertuples(index=False, name=None))
    return Table(names, tuple(rows))


def html(table: Table) -> str:
    """The table as HTML for notebooks, where no script sorts it."""
    from .templating import macro

    return str(macro("_table.html.j2", "table")(table, False))


def markdown(table: Table) -> str:
    """The table as Markdown: columns aligned, numbers to the right."""
    rows = [[_markdown_cell(Cell(title)) for title in table.columns]]
    rows += [[_markdown_cell(cell) for cell in row] for row in table.rows]
    right = table.numeric
    widths = [min(max(3, *(len(row[j]) for row in rows)), WIDEST_PADDED) for j in range(len(table.columns))]
    rule = [("-" * (width - 1) + ":") if end else "-" * width for width, end in zip(widths, right, strict=True)]
    lines = [_padded(row, widths, right) for row in (rows[0], rule, *rows[1:])]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def csv(table: Table) -> str:
    """The values of the table as CSV; empty where there is none."""
    buffer = io.StringIO()
    writer = csv_format.writer(buffer, lineterminator="\n")
    writer.writerow([without_formula(name) for name in table.columns])
    writer.writerows([_csv_value(cell) for cell in row] for row in table.rows)
    return buffer.getvalue()


def console(table: Table, indent: str = "", fit: bool = False) -> str:
    """The table as plain text in columns, numbers to the right; without titles where all are empty.

    fit : on a terminal the last columns that it has no room for are left out, and named.
    """
    rows = [[" ".join(cell.text.split()) for cell in row] for row in table.rows]
    rows = [list(table.columns), *rows] if any(table.columns) else rows
    right = table.numeric
    widths = [max((len(row[j]) for row in rows), default=0) for j in range(len(table.columns))]
    room = get_terminal_size().columns if fit and sys.stdout.isatty() else math.inf
    shown = max(1, sum(end <= room for end in accumulate(widths, lambda end, width: end + 2 + width)))
    lines = [indent + "  ".join(_padded(row, widths, right)[:shown]).rstrip() for row in rows]
    left_out = ", ".join(table.columns[shown:])
    return "\n".join([*lines, *([f"Not shown: {left_out}."] if left_out else [])])


def _padded(row: Sequence[str], widths: Sequence[int], right: Sequence[bool]) -> list[str]:
    return [
        text.rjust(width) if end else text.ljust(width) for text, width, end in zip(row, widths, right, strict=True)
    ]


def in_markdown(text: object) -> str:
    """A text that is foreign to a Markdown page, such as a suite's name: one line that is neither markup nor a link."""
    return re.sub(r"([\\`*_{}\[\]<>#|!])", r"\\\1", " ".join(str(text).split()))


def section(table: Table, where: str = "") -> list[str]:
    """A table with its note under its title, as parts of a Markdown page; none where it has no rows."""
    return [part for part in (f"## {table.title}{where}", table.note, markdown(table)) if part] if table.rows else []


def listed(rows: Sequence[tuple[str, str]]) -> str:
    """Pairs of name and text as a Markdown list."""
    return "\n".join(f"- {name}: {in_markdown(text)}" for name, text in rows)


def _markdown_cell(cell: Cell) -> str:
    """One line in which a bar does not end the cell, and a text is no link."""
    text = escape(cell.text, quote=False).replace("](", "]\\(") if cell.markdown is None else cell.markdown
    return re.sub(r"(\\*)\|", r"\1\1\\|", " ".join(text.split()))


def _csv_value(cell: Cell) -> Any:
    value: Any = cell.text if cell.value is None else cell.value
    value = value.item() if hasattr(value, "item") else value
    if isinstance(value, str):
        return without_formula(value)
    return "" if is_missing(value) else value


def without_formula(text: str) -> str:
    """A text as a cell of CSV that no spreadsheet takes for a formula."""
    text = text.replace("\r", " ")
    return text if _is_number(text) else FORMULA.sub(r"\1'\2", text)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
