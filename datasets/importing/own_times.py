"""Tables whose columns have more than one time: each time with the columns behind it is a table of its own."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .clock import COUNTED, guess_form, seconds
from .names import is_time, words
from .raw import RawColumn, RawTable

RISING, AS_LONG, NEAR = 0.95, 0.05, 0.1
"""Share of steps that rise, relative difference of lengths that are the same, and of first times over a length."""
AGAIN = re.compile(r" \(\d+\)$")
"""What the reader puts behind a name that stands there already."""


def by_times(table: RawTable) -> list[RawTable]:
    """The table, or one for every time in it that has columns of its own behind it.

    A time is another one where it is not the first by another clock or in another form, and where the file says that it
    belongs to the columns behind it: by its number or its equal name, by its end, or by lasting as long in other steps.
    """
    places = [i for i, column in enumerate(table.columns) if column.known == "" and is_time(column.name)]
    places = [i for i in places if i + 1 not in places and i + 1 < len(table.columns)]
    if len(places) < 2:
        return [table]
    times = [_seconds(table.columns[i]) for i in places]
    first = times[0]
    if first is None:
        return [table]
    later = [
        (i, time)
        for i, time in zip(places[1:], times[1:], strict=True)
        if time is not None and _is_other(first, time) and _is_own(table, places[0], i, first, time)
    ]
    if not later:
        return [table]
    starts = [0, *(i for i, _ in later), len(table.columns)]
    parts = zip([first, *(time for _, time in later)], starts[:-1], starts[1:], strict=True)
    return [_part(table, time, table.columns[a:b]) for time, a, b in parts]


def _seconds(column: RawColumn) -> np.ndarray | None:
    """(N,) seconds of a time that counts from any moment and rises; None of others."""
    guess = guess_form(column, column.unit.strip("[]() ").lower()) if column.numeric else None
    if guess is None or guess.forms[0] not in COUNTED:
        return None
    time = seconds([column], guess.forms[0])
    steps = np.diff(time[np.isfinite(time)])
    return time if steps.size and np.mean(steps > 0.0) > RISING else None


def _is_other(first: np.ndarray, time: np.ndarray) -> bool:
    """Whether two times (N,) of a table are not one and the same but for a constant."""
    both = np.isfinite(first) & np.isfinite(time)
    if both.sum() < 3:
        return True
    apart = (time - first)[both]
    return bool(np.ptp(apart) > 2.0 * float(np.median(np.diff(first[np.isfinite(first)]))))


def _is_own(table: RawTable, place: int, other: int, first: np.ndarray, time: np.ndarray) -> bool:
    """Whether the file says that a time belongs to the columns behind it."""
    start, length = np.nanmin(first), np.nanmax(first) - np.nanmin(first)
    if abs(np.nanmin(time) - start) > NEAR * length:
        return False
    names = [table.columns[i].name for i in (place, other)]
    called = AGAIN.sub("", names[0]) == AGAIN.sub("", names[1]) or all(map(_numbered, names))
    ends = np.isfinite(first).sum() != np.isfinite(time).sum()
    as_long = abs(np.nanmax(time) - np.nanmin(time) - length) < AS_LONG * length
    return bool(called or ends or as_long)


def _numbered(name: str) -> bool:
    return any(word.isdigit() for word in words(name)[1:2])


def _part(table: RawTable, time: np.ndarray, columns: Sequence[RawColumn]) -> RawTable:
    """Some columns of a table, at the rows that have their time."""
    rows = np.flatnonzero(np.isfinite(time))
    kept = tuple(replace(column, values=column.at(rows)) for column in columns)
    if columns[0] is table.columns[0]:
        return replace(table, columns=kept, rows=table.rows[rows])
    done = (f"{columns[0].name!r} is the time of the columns behind it alone",)
    sheet = f"{table.sheet} {columns[0].name}".strip()
    return replace(table, columns=kept, rows=table.rows[rows], sheet=sheet, done=done, faults=())
