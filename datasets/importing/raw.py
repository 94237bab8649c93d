"""Raw tables: the columns of a log as they stand in its file."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np

from .cells import GAPS, Decorated, Style, decorated, numbers_of

Rejected: TypeAlias = tuple[int, str, str]
"""A line that is left out: its number, what is wrong, its text."""


@dataclass(frozen=True)
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
    values: tuple[str, ...] | np.ndarray
    known: str = ""
    source: str = ""
    said: tuple[str, ...] = ()
    side: str = ""
    called: str = ""
    below: str = ""
    style: Style = "point"

    @cached_property
    def numbers(self) -> np.ndarray:
        """(N,) float64; nan where a cell holds no number."""
        if isinstance(self.values, np.ndarray):
            return np.asarray(self.values, dtype=np.float64)
        return self.cells.numbers

    @cached_property
    def cells(self) -> Decorated:
        """The numbers of the texts, with the unit and side that letters in the cells state."""
        assert not isinstance(self.values, np.ndarray)
        plain = numbers_of(self.values, self.style)
        unread = [i for i in np.flatnonzero(np.isnan(plain)).tolist() if self.values[i].strip().lower() not in GAPS]
        found = decorated(self.values, self.name, self.style) if len(unread) > 0.02 * plain.size else None
        return found or Decorated(plain, "", "")

    @property
    def lettered(self) -> Decorated | None:
        """What letters in the cells state; None where there are none."""
        found = self.cells if not isinstance(self.values, np.ndarray) else None
        return found if found is not None and (found.unit or found.positive) else None

    @cached_property
    def bad(self) -> np.ndarray:
        """Indices of cells that hold neither a number nor one of the texts that mean a gap."""
        if isinstance(self.values, np.ndarray):
            return np.flatnonzero(np.isinf(self.values))
        texts, numbers = self.values, self.numbers
        return np.array(
            [i for i in np.flatnonzero(~np.isfinite(numbers)).tolist() if texts[i].strip().lower() not in GAPS],
            dtype=int,
        )

    @property
    def numeric(self) -> bool:
        """Whether most cells that are no gaps are numbers."""
        known = int(np.isfinite(self.numbers).sum())
        return known > 0 and known >= 4 * self.bad.size

    def text(self, index: int) -> str:
        """The cell as it stands, or the number in short form."""
        value = self.values[index]
        return value.strip() if isinstance(value, str) else _short(float(value))

    def first(self, count: int = 3) -> tuple[str, ...]:
        """The first cells that are no gaps."""
        n = len(self.values)
        known = (i for i in range(n) if self.text(i).lower() not in GAPS)
        return tuple(self.text(i) for _, i in zip(range(count), known, strict=False))


def _short(value: float) -> str:
    """Six digits, of degrees nine (a metre), of seconds since 1970 or days since 1900 the milliseconds."""
    size = abs(value)
    return f"{value:.{6 if size < 10.0 else 9 if size < 1e4 else 14}g}"


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
