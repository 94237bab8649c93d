"""Which name of a header stands over which cells, where there are fewer names than cells."""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from dataclasses import dataclass

from ...models.errors import BadInput
from .gps_time import WEEK_S
from .names import is_date, is_time, named, words

DATE_CELL = re.compile(r"\d{4}([-/.])\d{1,2}\1\d{1,2}|\d{1,2}([-/.])\d{1,2}\2\d{2,4}|\d{1,2}-[A-Za-z]{3}-\d{2,4}")
CLOCK_CELL = re.compile(r"\d{1,2}:\d{2}(:\d{2}([.,]\d+)?)?")
BEHIND_CLOCK = re.compile(r"[AaPp]\.?[Mm]\.?|UTC|GMT|Z|[+-]\d{2}:?\d{2}|[A-Z]{3,4}")
"""What stands behind a clock, in a cell of its own: half of the day, or the zone."""
LOCAL_ZONE = re.compile(r"(?!UTC|GMT)[A-Z]{3,4}")
"""The letters of a zone, which several have."""
WEEK_CELL = re.compile(r"[12]\d{3}")
SEPARATORS = (",", ";", "|", None)
"""Separators that a header may have other than its table; None: blanks."""


@dataclass(frozen=True)
class Names:
    """names (k) of k columns, '' where one has none.

    places : (k) which name of the header each is, -1 where none.  joined : (first, number) of cells that are one
    column: date, clock and what stands behind it.  done : what was done.
    """

    names: tuple[str, ...]
    places: tuple[int, ...]
    joined: tuple[int, int] | None = None
    done: tuple[str, ...] = ()


def place_names(names: Sequence[str], rows: Sequence[Sequence[str]], explicit: int) -> Names | None:
    """The names over the cells of rows; None where the names are no header of them.

    explicit : cells of the header's line, with empty ones at its end, which are columns without a name.

    Raises
    ------
    BadInput : names are missing, and nothing tells of which columns.
    """
    width = len(rows[0]) if rows else len(names)
    missing = width - len(names)
    if missing <= 0 or explicit == width:
        empty = next((i for i in range(width) if any(row[width - 1 - i].strip() for row in rows)), 0)
        fits = width - max(empty, 1) <= len(names) <= width
        return Names((*names, *[""] * width)[:width], tuple(range(width))) if fits else None
    counted = len(names) < width and _counts([row[0].strip() for row in rows])
    for front in (0, 1) if counted else (0,):
        found = _over_time(names, [row[front:] for row in rows], missing - front)
        if found is not None:
            first = found.joined and (found.joined[0] + front, found.joined[1])
            return Names((*[""] * front, *found.names), (*[-1] * front, *found.places), first, found.done)
    if missing == 1 and any(is_time(name) or named(words(name)).may_be for name in names):
        said = f"{len(names)} names over {width} columns, and nothing tells which column has none: {', '.join(names)}"
        raise BadInput(said, hint="write a name for every column into that line")
    return None


def _over_time(names: Sequence[str], rows: Sequence[Sequence[str]], missing: int) -> Names | None:
    """The names where exactly those cells have none that belong to a date, a clock and what stands behind it."""
    if missing == 0:
        return Names(tuple(names), tuple(range(len(names))))
    for start, length, weeks in _time_runs(rows):
        count = _names_of_time(names, start)
        bare = start == 0 and count == 0 and not any(is_time(name) or is_date(name) for name in names)
        if length - count != missing or not (count or bare):
            continue
        before, own, behind = names[:start], names[start : start + count], names[start + count :]
        places = list(range(len(names)))
        first, last = places[:start], places[start + count :]
        if length == 2:
            name = own[0] if own else ""
            parts = ("week", "seconds of week") if weeks else ("date", "clock")
            done = f"{name!r} names {' and '.join(parts)}" if name else f"{' and '.join(parts)} stand without names"
            made = (*before, *(f"{name} {part}".strip() for part in parts), *behind)
            return Names(made, (*first, *[start if own else -1] * 2, *last), done=(done,))
        if LOCAL_ZONE.fullmatch(rows[0][start + length - 1].strip()) and length == 3:
            pair = own if count == 2 else [f"{own[0] if own else ''} {part}".strip() for part in ("date", "clock")]
            at = [*range(start, start + count)] if count == 2 else [start if own else -1] * 2
            done = "the zone behind the clock has no name, and is not read"
            return Names((*before, *pair, "zone", *behind), (*first, *at, -1, *last), done=(done,))
        name = " ".join(own) or "time"
        done = f"{name!r} names {length} cells of date and clock"
        return Names((*before, name, *behind), (*first, start if own else -1, *last), (start, length), (done,))
    return None


def _names_of_time(names: Sequence[str], start: int) -> int:
    """How many names from `start` on are those of a date, a clock or both."""
    if start >= len(names) or not (is_time(names[start]) or is_date(names[start])):
        return 0
    second = names[start + 1] if start + 1 < len(names) else ""
    both = {*words(names[start])} >= {"date", "time"}
    parts = (is_date(names[start]) and is_time(second)) or (is_time(names[start]) and is_date(second))
    return 2 if parts and not both else 1


def _time_runs(rows: Sequence[Sequence[str]]) -> list[tuple[int, int, bool]]:
    """(first, number, whether of weeks and seconds) of cells that are a date, a clock and what stands behind it."""
    columns = [[cell.strip() for cell in column] for column in zip(*rows, strict=True)]
    found = []
    for i, (one, two) in enumerate(itertools.pairwise(columns)):
        dated = _all(DATE_CELL, one) and _all(CLOCK_CELL, two)
        if dated or (_all(CLOCK_CELL, one) and _is_mark(two)):
            stop = i + 2
            while dated and stop < len(columns) and _is_mark(columns[stop]):
                stop += 1
            found.append((i, stop - i, False))
        elif _all(WEEK_CELL, one) and len(set(one)) <= 2 and _is_second_of_week(two):
            found.append((i, 2, True))
    return found


def _all(pattern: re.Pattern[str], cells: Sequence[str]) -> bool:
    return bool(cells) and all(pattern.fullmatch(cell) for cell in cells)


def _is_mark(cells: Sequence[str]) -> bool:
    """Whether cells are all AM or PM, or one and the same zone."""
    halves = {cell.replace(".", "").upper() for cell in cells} <= {"AM", "PM"}
    return _all(BEHIND_CLOCK, cells) and (halves or len(set(cells)) == 1)


def _is_second_of_week(cells: Sequence[str]) -> bool:
    try:
        numbers = [float(cell) for cell in cells]
    except ValueError:
        return False
    rising = sum(b > a for a, b in itertools.pairwise(numbers))
    return all(0.0 <= number < WEEK_S for number in numbers) and rising >= 0.9 * (len(numbers) - 1) > 0


def _counts(cells: Sequence[str]) -> bool:
    """Whether cells count rows: whole numbers that rise by one."""
    if len(cells) < 3 or not all(cell.isdigit() for cell in cells):
        return False
    return all(int(b) == int(a) + 1 for a, b in itertools.pairwise(cells))


def other_separator(cells: Sequence[str], width: int) -> tuple[str, ...]:
    """The cells of a header; where they are cut by another separator than the table, and then are `width`, those."""
    if len(cells) == width or any(re.fullmatch(r"[-+\d.,]+", cell.strip()) for cell in cells):
        return tuple(cells)
    text = " ".join(cell for cell in cells if cell.strip())
    for separator in SEPARATORS:
        parts = [part.strip() for part in text.split(separator)]
        told = any(is_time(part) or named(words(part)).may_be for part in parts)
        if len(parts) == width and all(parts) and told:
            return tuple(parts)
    return tuple(cells)
