"""Raw tables: the columns of a log as they stand in its file."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

GAPS = frozenset({"", "nan", "na", "n/a", "null", "none", "-", "--", "---", "#n/a", "#nv", "inv", "invalid", "?", "*"})
"""Texts, in lower case, that stand for a missing value."""
DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+([eE][+-]?\d+)?")
THOUSANDS = re.compile(r"[+-]?\d{1,3}(\.\d{3})+(,\d+)?")


@dataclass(frozen=True)
class RawColumn:
    """A column: its name, the unit that the file states ('' if none), and its texts (N) or numbers (N,)."""

    name: str
    unit: str
    values: tuple[str, ...] | np.ndarray

    @cached_property
    def numbers(self) -> np.ndarray:
        """(N,) float64; nan where a cell holds no number."""
        if isinstance(self.values, np.ndarray):
            return np.asarray(self.values, dtype=np.float64)
        return parse_numbers(self.values)

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
    done : what the reader did, a sentence each;  faults : rows that were left out: (line, what is wrong).
    """

    file: str
    columns: tuple[RawColumn, ...]
    rows: np.ndarray
    sheet: str = ""
    clock: str = ""
    done: tuple[str, ...] = ()
    faults: tuple[tuple[int, str], ...] = field(default=())

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


def parse_numbers(texts: Sequence[str]) -> np.ndarray:
    """Texts (N) as numbers (N,), nan where a text is none.

    A column has decimal commas where more cells are numbers with a comma for a point than without.
    """
    plain = _floats(texts)
    left = [i for i in np.flatnonzero(np.isnan(plain)).tolist() if "," in texts[i]]
    commas = [i for i in left if DECIMAL_COMMA.fullmatch(texts[i].strip()) or THOUSANDS.fullmatch(texts[i].strip())]
    if not commas or len(commas) < np.isfinite(plain).sum() - _integers(texts, plain):
        return plain
    changed = [text.replace(".", "").replace(",", ".") if "," in text else text for text in texts]
    return _floats(changed)


def _integers(texts: Sequence[str], numbers: np.ndarray) -> int:
    return sum(1 for i in np.flatnonzero(np.isfinite(numbers)).tolist() if "." not in texts[i])


def _floats(texts: Sequence[str]) -> np.ndarray:
    out = np.full(len(texts), np.nan)
    for i, text in enumerate(texts):
        try:
            out[i] = float(text)
        except ValueError:
            continue
    return out


def is_number(text: str) -> bool:
    """Whether a cell is a number, with a decimal point or a decimal comma."""
    try:
        float(text)
    except ValueError:
        return bool(DECIMAL_COMMA.fullmatch(text.strip()))
    return text.strip().lower() not in GAPS
