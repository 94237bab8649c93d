"""Raw tables: the columns of a log as they stand in its file."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from ...models.errors import BadInput
from .cells import GAPS, Decorated, Style, Texts, angle_of, decorated, missing_value, numbers_of

Rejected: TypeAlias = tuple[int, str, str]
"""A line that is left out: its number, what is wrong, its text."""


@dataclass(frozen=True, eq=False)
class RawColumn:
    """A column: its name, the unit that the file states ('' if none), and its texts (N) or numbers (N,).

    known : quantity that the format of the file states, in the record's sign convention, or 'not used';  source : who
    states it, and of which instrument the column is;  said : statements about the column elsewhere in the file or
    beside it;  called : what it is named by, where not by its name;  below : its name without that of a group of
    columns;  side : to which a positive rudder of a known
    column turns the ship;  style : the decimal sign of the table.
    """

    name: str
    unit: str
    values: Sequence[str] | np.ndarray
    known: str = ""
    source: str = ""
    said: tuple[str, ...] = ()
    side: str = ""
    called: str = ""
    below: str = ""
    style: Style = "point"

    def __getstate__(self) -> dict[str, Any]:
        state = {field.name: getattr(self, field.name) for field in fields(self)}
        return state | ({"values": tuple(self.values)} if isinstance(self.values, Texts) else {})

    @cached_property
    def texts(self) -> Texts | None:
        """The cells as texts; None where they are numbers."""
        if isinstance(self.values, np.ndarray):
            return None
        return self.values if isinstance(self.values, Texts) else Texts(self.values)

    @cached_property
    def numbers(self) -> np.ndarray:
        """(N,) float64; nan where a cell holds no number, or one that stands for a missing value."""
        found = self.cells.numbers
        return np.where(found == self.missing, np.nan, found) if self.missing is not None else found

    @cached_property
    def missing(self) -> float | None:
        """The number that stands for a missing value, such as -9999; None where there is none."""
        return missing_value(self.cells.numbers)

    @cached_property
    def cells(self) -> Decorated:
        """The numbers of the cells, with the unit and side that letters in them state."""
        if self.texts is None:
            return Decorated(np.asarray(self.values, dtype=np.float64), "", "")
        plain = numbers_of(self.texts, self.style)
        unread = _not_gaps(self.texts, np.isnan(plain)).size
        found = decorated(self.texts, self.name, self.style) if unread > 0.02 * plain.size else None
        return found or Decorated(plain, "", "")

    @cached_property
    def degrees(self) -> np.ndarray:
        """(N,) degrees of numbers that hold degrees and minutes, ddmm.mmm, or of texts such as 54°12.345'N; nan where a
        cell is none."""
        if self.texts is not None and not self.numeric:
            return self.texts.mapped(angle_of)
        size = np.abs(self.numbers)
        return np.sign(self.numbers) * (size // 100.0 + (size % 100.0) / 60.0)

    @property
    def lettered(self) -> Decorated | None:
        """What letters in the cells state; None where there are none."""
        return self.cells if self.cells.unit or self.cells.positive else None

    @property
    def finite(self) -> np.ndarray:
        """(K,) the numbers that are known."""
        return self.numbers[np.isfinite(self.numbers)]

    @cached_property
    def bad(self) -> np.ndarray:
        """Indices of cells that hold neither a number nor one of the texts that mean a gap."""
        if self.texts is None:
            return np.flatnonzero(np.isinf(self.cells.numbers))
        return _not_gaps(self.texts, ~np.isfinite(self.cells.numbers))

    @cached_property
    def numeric(self) -> bool:
        """Whether most cells that are no gaps are numbers."""
        known = int(np.isfinite(self.numbers).sum())
        return known > 0 and known >= 4 * self.bad.size

    @cached_property
    def times(self) -> dict[str, np.ndarray]:
        """Form of a time -> the cells in seconds, as far as they have been computed."""
        return {}

    def text(self, index: int) -> str:
        """The cell as it stands, or the number in short form: six digits, of degrees nine (a metre), of seconds since
        1970 or days since 1900 the milliseconds."""
        value = self.values[index]
        if isinstance(value, str):
            return value.strip()
        size = abs(float(value))
        return f"{float(value):.{6 if size < 10.0 else 9 if size < 1e4 else 14}g}"

    def first(self, count: int = 3) -> tuple[str, ...]:
        """The first cells that are no gaps."""
        if self.texts is None:
            return tuple(self.text(i) for i in np.flatnonzero(~np.isnan(self.cells.numbers))[:count].tolist())
        told = (text.strip() for text in self.texts)
        return tuple(itertools.islice((text for text in told if text.lower() not in GAPS), count))

    def at(self, rows: Sequence[int] | np.ndarray) -> Texts | np.ndarray:
        """The cells of some rows."""
        return np.asarray(self.values)[rows] if self.texts is None else self.texts.take(rows)


def _not_gaps(texts: Texts, which: np.ndarray) -> np.ndarray:
    """Indices of those of some cells, which (N,), that do not mean a gap."""
    rows = np.flatnonzero(which)
    return rows[~texts.take(rows).among(GAPS)] if rows.size else rows


@dataclass(frozen=True)
class RawTable:
    """A table of one logger.

    file : name of the file;  sheet : sheet, sentence or variable, '' if the file holds one table;  columns : of equal
    length N;  rows : (N,) line numbers in the file;  clock : tables with an equal text are timed by the same clock;
    notes : lines above the header;  done : what the reader did, a sentence each;  faults : rows that were left out;
    lines : that the faults are of, where these are more than the rows.
    """

    file: str
    columns: tuple[RawColumn, ...]
    rows: np.ndarray
    sheet: str = ""
    clock: str = ""
    notes: tuple[str, ...] = ()
    done: tuple[str, ...] = ()
    faults: tuple[Rejected, ...] = ()
    lines: int = 0

    @classmethod
    def of(
        cls,
        path: Path,
        columns: Sequence[RawColumn],
        done: str,
        sheet: str = "",
        rows: Sequence[int] | np.ndarray | None = None,
    ) -> RawTable:
        """A table of a file and how it was read; its rows are counted from 1 where no lines of the file are given."""
        lines = np.arange(1, len(columns[0].values) + 1) if rows is None else np.asarray(rows)
        return cls(path.name, tuple(columns), lines, sheet, done=(done,))

    @property
    def label(self) -> str:
        """File and sheet."""
        return f"{self.file} [{self.sheet}]" if self.sheet else self.file

    @property
    def n(self) -> int:
        """Number of rows."""
        return int(self.rows.size)

    def column(self, name: str) -> RawColumn | None:
        """The column of that name, if there is one."""
        return next((column for column in self.columns if column.name == name), None)

    def at(self, rows: np.ndarray, columns: Iterable[RawColumn] | None = None, **changes: Any) -> RawTable:
        """Some rows of the table, of all its columns or of some of them, with changes of its other facts."""
        own = tuple(replace(c, values=c.at(rows)) for c in (self.columns if columns is None else columns))
        return replace(self, columns=own, rows=self.rows[rows], **changes)

    def told(self, told_of: Callable[[RawColumn], RawColumn], *done: str) -> RawTable:
        """The table with what is told of its columns, and what was done."""
        return replace(self, columns=tuple(map(told_of, self.columns)), done=(*self.done, *done))


def faults_once(parts: Sequence[RawTable]) -> list[RawTable]:
    """The tables that a table was cut into: the first one alone has its faults."""
    return [*parts[:1], *(replace(part, faults=()) for part in parts[1:])]


def usable(tables: Iterable[RawTable | None], path: Path, nothing: str, hint: str = "") -> list[RawTable]:
    """The tables of a file; BadInput, which says `nothing`, where there is none."""
    found = [table for table in tables if table is not None]
    if not found:
        raise BadInput(nothing, file=path, hint=hint)
    return found


def with_faults(tables: Sequence[RawTable], faults: Sequence[Rejected], lines: int = 0) -> list[RawTable]:
    """The tables of a file, of which the first one has the lines that were left out, of so many in all."""
    return [replace(tables[0], faults=tuple(faults), lines=lines), *tables[1:]]
