"""A raw table and its mapping as quantities in SI units and radians over seconds."""

from __future__ import annotations

import re
from collections.abc import Mapping as Dict
from dataclasses import dataclass

import numpy as np

from .clock import DATED, rows_as_seconds, seconds, spread
from .draft import NOT_USED
from .finding import WITH_SIDE, either_side
from .mapping import ColumnMap, TableMap
from .raw import RawColumn, RawTable
from .report import Fault
from .units import UNITS

FEW, MANY, HALF = 0.02, 0.2, 0.5
"""Share of rows that may be left out, of cells of a column that may be gaps for not being numbers, and of sentences or
messages that may be left out: their checksums tell the bad ones from the others."""
ANGLE = re.compile(
    r"([NSEWO+-]?)\s*(\d{1,3})[°\s:-]\s*(\d{1,2}(?:[.,]\d+)?)['\u2032\s:]?\s*(\d{1,2}(?:[.,]\d+)?)?[\"\u2033]?\s*([NSEWO]?)"
)


HOLE_S, HOLE_STEPS = 60.0, 60.0
"""Seconds, and median steps, without rows from which on it is told."""


@dataclass(frozen=True)
class Stream:
    """Quantities of one logger, each (N,), over its time (N,) s; `kept` are the rows of the table that they come from.

    dated : whether the time counts from 1970;  clock : streams with an equal text share a clock;
    offset_s : what the mapping says is to be added to the time, None where it says nothing.
    """

    label: str
    clock: str
    dated: bool
    time: np.ndarray
    quantities: Dict[str, np.ndarray]
    kept: np.ndarray
    offset_s: float | None = None
    done: tuple[str, ...] = ()
    shift_s: float = 0.0
    """What was added to the times to set the clock."""
    parts: tuple[str, ...] = ()
    """Labels of streams that were joined to this one."""
    zoned: bool = False
    """Whether the file states that its times are UTC."""

    @property
    def step(self) -> float:
        """Median time step, s."""
        return float(np.median(np.diff(self.time)))


def stream_of(table: RawTable, mapping: TableMap, zoned: bool = False) -> tuple[Stream | None, list[Fault]]:
    """The quantities of a table, and its faults; None where a fault is fatal."""
    faults = _row_faults(table)
    time, done = _time(table, mapping)
    kept, wrong = _usable_rows(table, time, mapping)
    faults += wrong
    quantities = {}
    for entry in mapping.columns:
        column = table.column(entry.column)
        if column is None or entry.to == NOT_USED or entry.open:
            continue
        values, found = _converted(table, column, entry)
        faults += found
        quantities[entry.to] = values[kept]
    if any(fault.fatal for fault in faults) or kept.size < 3:
        return None, faults
    faults += _holes(table, time[kept], kept)
    dated = mapping.time.form in DATED
    clock = table.clock or table.label
    notes = (f"{table.label}: {done}",) if done else ()
    return Stream(
        table.label, clock, dated, time[kept], quantities, kept, mapping.clock_offset_s, notes, zoned=zoned
    ), faults


def _holes(table: RawTable, time: np.ndarray, kept: np.ndarray) -> list[Fault]:
    """The longest time without rows, where it is that of many."""
    steps = np.diff(time)
    k = int(np.argmax(steps))
    if not steps[k] > max(HOLE_S, HOLE_STEPS * float(np.median(steps))):
        return []
    hint = "was the log cut, or its clock set (summer time)? cut the record there"
    return [Fault(table.label, f"no row for {steps[k]:.4g} s before this one", hint, int(table.rows[kept[k + 1]]))]


def _time(table: RawTable, mapping: TableMap) -> tuple[np.ndarray, str]:
    """((N,) seconds, what was done to them)."""
    if mapping.time.form == "rows":
        return rows_as_seconds(table.n, mapping.time.step_s or 1.0), ""
    columns = [column for name in mapping.time.columns if (column := table.column(name))]
    assert mapping.time.form != "?"
    return spread(seconds(columns, mapping.time.form))


def _row_faults(table: RawTable) -> list[Fault]:
    """One fault for rows that the reader left out."""
    if not table.faults:
        return []
    total = max(table.lines, table.n + len(table.faults))
    many = len(table.faults) > (HALF if table.lines else FEW) * total and len(table.faults) > 2
    row, message, _ = next(iter(table.faults))
    more = f" ({len(table.faults)} of {total} rows are wrong, this is the first)" if len(table.faults) > 1 else ""
    hint = "mend or remove them" if many else "left out"
    return [Fault(table.label, message + more, hint, row=row, fatal=many)]


def _usable_rows(table: RawTable, time: np.ndarray, mapping: TableMap) -> tuple[np.ndarray, list[Fault]]:
    """(indices of rows with times that rise, faults)."""
    name = mapping.time.columns[-1] if mapping.time.columns else None
    faults: list[Fault] = []
    known = np.flatnonzero(np.isfinite(time))
    missing = np.flatnonzero(~np.isfinite(time))
    if missing.size:
        many = missing.size > FEW * time.size and missing.size > 2
        said = f"{missing.size} of {time.size} rows have no time of the form {mapping.time.form!r}"
        hint = "state the form in the mapping" if many else "left out"
        faults.append(Fault(table.label, said, hint, _row(table, missing[0]), name, many))
    if known.size < 3:
        said = f"{known.size} rows with a time"
        return known, [*faults, Fault(table.label, said, "a log needs some minutes of them", column=name, fatal=True)]
    highest = np.maximum.accumulate(time[known])
    rises = np.concatenate([[True], time[known][1:] > highest[:-1]])
    late = known[~rises]
    back = late[time[late] < time[late - 1]]
    if back.size:
        many = late.size > FEW * time.size
        said = f"time goes back in {back.size} place{'s' if back.size > 1 else ''}"
        hint = "cut the file there, or sort it by time" if many else f"{late.size} rows left out"
        faults.append(Fault(table.label, said, hint, _row(table, back[0]), name, many))
    elif late.size:
        many = late.size > 0.5 * time.size
        hint = "the time is too coarse: log it with fractions of a second" if many else "the first of each was kept"
        said = f"{late.size} rows repeat the time of the row before"
        faults.append(Fault(table.label, said, hint, _row(table, late[0]), name, many))
    return known[rises], faults


def _row(table: RawTable, index: int) -> int:
    return int(table.rows[index])


def _converted(table: RawTable, column: RawColumn, entry: ColumnMap) -> tuple[np.ndarray, list[Fault]]:
    """The column in SI units, and a fault where cells are no numbers."""
    if entry.unit == "deg min":
        numbers = _degrees_minutes(column)
        bad = np.flatnonzero(~np.isfinite(numbers))
    else:
        numbers, bad = column.numbers, column.bad
    unit = UNITS[str(entry.unit)].factor
    numbers = np.where(np.isfinite(numbers), numbers, np.nan)
    values = numbers * (unit * entry.factor * int(entry.sign)) + entry.offset * unit
    values = either_side(values) if entry.to in WITH_SIDE else values
    empty = not np.isfinite(values).any()
    if empty:
        hint = "check its cells, or leave it out of the mapping"
        return values, [Fault(table.label, "no number in the whole column", hint, column=column.name, fatal=True)]
    if not bad.size:
        return values, []
    many = bad.size > MANY * values.size
    said = f"{column.text(bad[0])!r} is not a number ({bad.size} such cells)"
    hint = "map another column, or write what it means as an empty cell" if many else "taken as gaps"
    return values, [Fault(table.label, said, hint, _row(table, bad[0]), column.name, many)]


def _degrees_minutes(column: RawColumn) -> np.ndarray:
    """Degrees (N,) from texts such as 54°12.345'N or 54 12 20 N, or from numbers of the form ddmm.mmm."""
    if column.numeric:
        size = np.abs(column.numbers)
        return np.sign(column.numbers) * (size // 100.0 + (size % 100.0) / 60.0)
    return np.full(len(column.values), np.nan) if column.texts is None else column.texts.mapped(_one_angle)


def _one_angle(text: str) -> float:
    match = ANGLE.fullmatch(text.strip())
    if not match:
        return float("nan")
    minutes, rest = (float((part or "0").replace(",", ".")) for part in (match[3], match[4]))
    sign = -1.0 if {match[1], match[5]} & {"S", "W", "-"} else 1.0
    return sign * (float(match[2]) + minutes / 60.0 + rest / 3600.0)
