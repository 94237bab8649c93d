"""A raw table and its mapping as quantities in SI units and radians over seconds."""

from __future__ import annotations

import re
from collections.abc import Mapping as Dict
from dataclasses import dataclass, replace

import numpy as np

from ..io import MIN_SAMPLES
from .draft import NOT_USED
from .finding import EITHER_SIDE, either_side
from .mapping import ColumnMap, TableMap
from .raw import RawColumn, RawTable
from .result import FileFault
from .times import TableTime
from .units import UNITS

FEW, MANY, HALF = 0.02, 0.2, 0.5
"""Share of rows that may be left out, of cells of a column that may be gaps for not being numbers, and of sentences or
messages that may be left out: their checksums tell the bad ones from the others."""
ANGLE = re.compile(
    r"([NSEWO+-]?)\s*(\d{1,3})[°\s:-]\s*(\d{1,2}(?:[.,]\d+)?)['\u2032\s:]?\s*(\d{1,2}(?:[.,]\d+)?)?[\"\u2033]?\s*([NSEWO]?)"
)


MOST_RUNS = 50
"""Runs of a table; a time that starts again more often is not sorted."""
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
    rate: float = 0.0
    middle_s: float = 0.0
    """What was added to its times t, s, to set the clock: shift_s + rate (t - middle_s)."""
    parts: tuple[str, ...] = ()
    """Labels of streams that were joined to this one."""
    zoned: bool = False
    """Whether the file states the offset of its times from UTC."""
    period_s: float = 0.0
    """Seconds after which times without a date are the same again; 0 where they are not."""
    gps: bool = False
    """Whether the file states GPS time; where it states the date, too, the times are in UTC."""
    vague: bool = False
    """Whether GPS time is told by a name that stands for the receiver's UTC as well."""
    time_column: str = ""
    """Column of the time, '' for none."""
    run: int = 0
    """Number of the run, where the time of the table starts again; else 0."""

    def at(self, rows: np.ndarray | slice) -> Stream:
        """Some rows of the stream."""
        own = {name: values[rows] for name, values in self.quantities.items()}
        return replace(self, time=self.time[rows], quantities=own, kept=self.kept[rows])

    def on_clock(self, time: np.ndarray) -> np.ndarray:
        """Times (N,), s, of this clock before it was set, as they are after that."""
        return time + self.shift_s + self.rate * (time - self.middle_s)

    @property
    def table(self) -> str:
        """Label of its table."""
        return self.label.removesuffix(f", run {self.run}")

    @property
    def step(self) -> float:
        """Median time step, s."""
        return float(np.median(np.diff(self.time)))


def streams_of(table: RawTable, mapping: TableMap, times: TableTime) -> tuple[list[Stream], list[FileFault]]:
    """The quantities of a table, of every run of it where its time starts again, and its faults; none where a fault is
    fatal."""
    faults = _row_faults(table)
    seconds = times.seconds(table)
    assert seconds is not None
    time, done = seconds
    parts, wrong = _usable_rows(table, time, mapping)
    faults += wrong
    quantities = {}
    for entry in mapping.columns:
        column = table.column(entry.column)
        if column is None or entry.to == NOT_USED or entry.open:
            continue
        quantities[entry.to], found = _converted(table, column, entry)
        faults += found
    if any(fault.fatal for fault in faults) or max(map(len, parts), default=0) < 3:
        return [], faults
    offset = mapping.clock_offset_s if mapping.clock_offset_s is not None else times.offset_s
    made = Stream(
        table.label, table.clock, times.dated, time, quantities, np.arange(time.size), offset,
        (f"{table.label}: {done}",) if done else (), zoned=times.zoned, period_s=times.period_s,
        gps=times.scale == "GPS", vague=times.vague,
        time_column=next(iter(mapping.time.columns), ""),
    )  # fmt: skip
    streams = [made.at(kept) for kept in parts]
    if len(parts) > 1:
        streams = [replace(s, label=f"{s.label}, run {run}", run=run) for run, s in enumerate(streams, 1)]
    return streams, faults + [fault for s in streams for fault in _holes(table, s.time, s.kept)]


def _holes(table: RawTable, time: np.ndarray, kept: np.ndarray) -> list[FileFault]:
    """The longest time without rows, where it is that of many."""
    steps = np.diff(time)
    k = int(np.argmax(steps))
    if not steps[k] > max(HOLE_S, HOLE_STEPS * float(np.median(steps))):
        return []
    hint = "was the log cut, or its clock set (summer time)? cut the record there"
    return [FileFault(table.label, f"no row for {steps[k]:.4g} s before this one", hint, int(table.rows[kept[k + 1]]))]


def _row_faults(table: RawTable) -> list[FileFault]:
    """One fault for rows that the reader left out."""
    if not table.faults:
        return []
    total = max(table.lines, table.n + len(table.faults))
    many = len(table.faults) > (HALF if table.lines else FEW) * total and len(table.faults) > 2
    row, message, _ = next(iter(table.faults))
    more = f" ({len(table.faults)} of {total} rows are wrong, this is the first)" if len(table.faults) > 1 else ""
    hint = "mend or remove them" if many else "left out"
    return [FileFault(table.label, message + more, hint, row=row, fatal=many)]


def _usable_rows(table: RawTable, time: np.ndarray, mapping: TableMap) -> tuple[list[np.ndarray], list[FileFault]]:
    """(indices of rows with times that rise, of every run; faults)."""
    name = mapping.time.columns[-1] if mapping.time.columns else None
    faults: list[FileFault] = []
    known = np.flatnonzero(np.isfinite(time))
    missing = np.flatnonzero(~np.isfinite(time))
    if missing.size:
        many = missing.size > FEW * time.size and missing.size > 2
        said = f"{missing.size} of {time.size} rows have no time of the form {mapping.time.form!r}"
        hint = "state the form in the mapping" if many else "left out"
        faults.append(FileFault(table.label, said, hint, _row(table, missing[0]), name, many))
    if known.size < 3:
        said, hint = f"{known.size} rows with a time", "a log needs some minutes of them"
        return [known], [*faults, FileFault(table.label, said, hint, column=name, fatal=True)]
    parts = _runs_of(time, known)
    rises = [np.diff(np.maximum.accumulate(time[part]), prepend=-np.inf) > 0.0 for part in parts]
    kept = [part[own] for part, own in zip(parts, rises, strict=True)]
    late = np.concatenate([part[~own] for part, own in zip(parts, rises, strict=True)])
    faults += _late_faults(table, time, late, name)
    long = [part for part in kept if part.size >= MIN_SAMPLES]
    if len(parts) > 1 and long:
        said = f"time goes back here, and at {len(parts) - 2} later places: cut into {len(long)} runs of their own"
        said = said.replace(", and at 0 later places", "")
        short = sum(part.size for part in kept) - sum(part.size for part in long)
        hint = "a record each" + (f"; {short} rows in runs too short for one left out" if short else "")
        faults.append(FileFault(table.label, said, hint, _row(table, parts[1][0]), name))
    return long if len(parts) > 1 and long else kept, faults


def _runs_of(time: np.ndarray, known: np.ndarray) -> list[np.ndarray]:
    """Rows with a time (N,) cut where it starts again: it goes back, and is not soon where it was before."""
    rest, parts = known, []
    while len(parts) < MOST_RUNS:
        times = time[rest]
        highest = np.maximum.accumulate(times)
        back = np.flatnonzero(np.diff(times) < 0.0) + 1
        before = highest[back - 1]
        later = np.searchsorted(highest, before, side="right") - back
        again = before - times[back] > HALF * (before - times[0])
        cuts = back[(later >= MIN_SAMPLES) & ((later > FEW * known.size) | again)]
        if not cuts.size:
            return [*parts, rest]
        parts, rest = [*parts, rest[: cuts[0]]], rest[cuts[0] :]
    return [known]


def _late_faults(table: RawTable, time: np.ndarray, late: np.ndarray, name: str | None) -> list[FileFault]:
    """What is wrong with rows whose time is not above all before them."""
    back = late[time[late] < time[late - 1]]
    if back.size:
        many = late.size > FEW * time.size
        said = f"time goes back in {back.size} place{'s' if back.size > 1 else ''}"
        hint = "cut the file there, or sort it by time" if many else f"{late.size} rows left out"
        return [FileFault(table.label, said, hint, _row(table, back[0]), name, many)]
    if late.size:
        many = late.size > 0.5 * time.size
        hint = "the time is too coarse: log it with fractions of a second" if many else "the first of each was kept"
        said = f"{late.size} rows repeat the time of the row before"
        return [FileFault(table.label, said, hint, _row(table, late[0]), name, many)]
    return []


def _row(table: RawTable, index: int) -> int:
    return int(table.rows[index])


def _converted(table: RawTable, column: RawColumn, entry: ColumnMap) -> tuple[np.ndarray, list[FileFault]]:
    """The column in SI units, and a fault where cells are no numbers."""
    if entry.unit == "deg min":
        numbers = _degrees_minutes(column)
        bad = np.flatnonzero(~np.isfinite(numbers))
    else:
        numbers, bad = column.numbers, column.bad
    unit = UNITS[str(entry.unit)].factor
    numbers = np.where(np.isfinite(numbers), numbers, np.nan)
    values = numbers * (unit * entry.factor * int(entry.sign)) + entry.offset * unit
    values = either_side(values) if entry.to in EITHER_SIDE else values
    empty = not np.isfinite(values).any()
    if empty:
        hint = "check its cells, or leave it out of the mapping"
        return values, [FileFault(table.label, "no number in the whole column", hint, column=column.name, fatal=True)]
    if not bad.size:
        return values, []
    many = bad.size > MANY * values.size
    said = f"{column.text(bad[0])!r} is not a number ({bad.size} such cells)"
    hint = "map another column, or write what it means as an empty cell" if many else "taken as gaps"
    return values, [FileFault(table.label, said, hint, _row(table, bad[0]), column.name, many)]


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
