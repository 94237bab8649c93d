"""Rows of a table that are no samples: statistics above or below the data, zeros where a logger had no data."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .cell_texts import Texts
from .names import is_time, joined, listed
from .raw import RawColumn, RawTable

ENDS = 12
"""Rows at either end of a table among which those of statistics are."""
FEWEST, MOST = 3, 0.5
"""Columns that are 0 together where a logger has no data, and the share of rows that may be so."""
FAR = 0.2
"""Least size of a signal, as a share of its median, from which on it never comes near 0."""


def without_statistics(table: RawTable) -> RawTable:
    """A table without the rows at its ends that a cell calls a minimum, a mean or the like."""
    ends = sorted({*range(min(ENDS, table.n)), *range(max(0, table.n - ENDS), table.n)})
    called = {row: text for c in table.columns if c.texts is not None for row in ends if _is_one(text := c.text(row))}
    if not called or len(called) > table.n // 2:
        return table
    kept = np.setdiff1d(np.arange(table.n), list(called))
    faults = [(int(table.rows[row]), f"a row of statistics ({text})", text) for row, text in sorted(called.items())]
    return table.at(kept, faults=(*table.faults, *faults))


def _is_one(text: str) -> bool:
    """Whether a cell is the name of a statistic."""
    return bool(text) and not text[0].isdigit() and joined(text) in listed("statistics")


def with_dropouts(table: RawTable) -> RawTable:
    """A table with gaps in the rows where all its numbers are 0 although two of three, or one of more, never come near
    that."""
    columns = [c for c in table.columns if c.numeric and not c.known and not is_time(c.name) and not _rises(c)]
    columns = [c for c in columns if np.any(np.nan_to_num(c.numbers))]
    if len(columns) < FEWEST:
        return table
    nothing = np.logical_and.reduce([c.numbers == 0.0 for c in columns])
    if not 0 < nothing.sum() < MOST * table.n:
        return table
    far = sum(_is_far(c.numbers[~nothing]) for c in columns)
    if far < (1 if len(columns) > FEWEST else 2):
        return table
    done = f"{int(nothing.sum())} rows hold 0 in all {len(columns)} columns: taken as gaps"
    own = {c.name for c in columns}
    return table.told(lambda c: _with_gaps(c, nothing) if c.name in own else c, done)


def _rises(column: RawColumn) -> bool:
    known = column.finite
    return known.size > 1 and float(np.mean(np.diff(known) > 0.0)) > 0.95


def _is_far(numbers: np.ndarray) -> bool:
    """Whether a signal (N,) never comes near 0."""
    sizes = np.abs(numbers[np.isfinite(numbers)])
    return bool(sizes.size) and float(sizes.min()) > FAR * float(np.median(sizes))


def _with_gaps(column: RawColumn, rows: np.ndarray) -> RawColumn:
    """A column without its cells in some rows (N,)."""
    if column.texts is None:
        return replace(column, values=np.where(rows, np.nan, column.numbers))
    return replace(column, values=Texts(np.where(rows, "", column.texts.array)))
