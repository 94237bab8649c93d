"""The layout of a table of cells: its header, its row of units, its data, and rows that do not belong to it."""

from __future__ import annotations

import itertools
import re
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from ...models.errors import BadInput
from .beside import with_halves, with_minutes, with_notes, with_places, with_sides
from .cells import CHUNK, GAPS, PLAIN, Texts, is_number, table_style
from .cells import SAMPLE as STYLE_SAMPLE
from .headers import says_unit, scaled_unit, sign_stated
from .moments import WEEK_S, with_plain_stamps
from .names import is_date, is_time, named, words
from .quantities import tidy
from .raw import RawColumn, RawTable, Rejected

TAIL = r"[-+\d:.,TZ ]*(?:[AaPp][Mm]|UTC|GMT|LT)?"
TIME_LIKE = re.compile(
    rf"\d{{1,4}}([-./:]\d{{1,2}}){{1,2}}{TAIL}|\d{{8}}T?\d*{TAIL}|\d{{1,2}}[- ][A-Za-z]{{3}}[- ]\d{{2,4}}{TAIL}"
)
POSITION = re.compile(r"\d{1,3}[°\s]\s*\d{1,2}.*[NSEW]?\s*")
LETTERED = re.compile(r"[A-Za-z]{0,9}\s*[+-]?\d+(?:[.,]\d+)?\s*[A-Za-z°/%]{0,9}")
"""A number with the letters of a side, a hemisphere or a unit."""
WITH_UNIT = re.compile(r"[+-]?\d+(?:[.,]\d+)?\s*[A-Za-z°/%]{1,8}")
IN_BRACKETS = re.compile(r"^(?P<name>.*?)\s*[\[({](?P<unit>[^\])}]*)[\])}]\s*$")
QUOTED = re.compile(r"""(["'])(.*)\1""")
NUMBERED = re.compile(
    r"^\W*(?:col(?:umn)?|spalte|channel|kanal|ch)?\.?\s*#?(?P<number>\d{1,3})(?:\s*[:=.)\-]\s*|\s+(?=[^\W\d]))(?P<name>\S.*)$",
    re.IGNORECASE,
)
RULE = re.compile(r"[-=_+|*]{2,}")
"""What a line is drawn of between a header and its data."""
LONGEST = 5000
"""Characters of a cell that are read: names are taken apart word by word."""
SAMPLE = 400
"""Rows that are looked at to find the layout."""


@dataclass(frozen=True, slots=True)
class Line:
    """A row of cells: its line number in the file, and whether it is marked as a comment."""

    number: int
    cells: tuple[str, ...]
    comment: bool = False


@dataclass(frozen=True)
class Layout:
    """The index of the first line of data; names and units (k) of the columns, their names without those of groups,
    what was done, and the other lines above the data.

    width : number of cells of a row;  joined : (first, number) of cells that are one column.
    """

    start: int
    width: int
    names: tuple[str, ...]
    units: tuple[str, ...]
    below: tuple[str, ...]
    done: tuple[str, ...]
    notes: tuple[str, ...]
    joined: tuple[int, int] | None = None


def is_value(cell: str) -> bool:
    """Whether a cell is a number, a time, an angle in degrees and minutes, or empty."""
    cell = cell.strip()
    return (
        cell.lower() in GAPS
        or is_number(cell)
        or any(pattern.fullmatch(cell) for pattern in (TIME_LIKE, POSITION, LETTERED))
    )


def is_data(cells: Sequence[str]) -> bool:
    """Whether a row holds data: a number, and half of its cells are values, or a third where a time of day is first."""
    told = [cell for cell in cells if cell.strip()]
    timed = bool(told) and ":" in told[0] and bool(TIME_LIKE.fullmatch(told[0].strip()))
    return (
        len(told) > 0
        and sum(map(is_value, told)) >= (0.3 if timed else 0.5) * len(told)
        and any(is_number(c) or WITH_UNIT.fullmatch(c.strip()) for c in told)
    )


def is_rule(cells: Sequence[str]) -> bool:
    """Whether a row is a drawn line, and no gaps."""
    drawn = all(RULE.fullmatch(cell.strip()) for cell in cells if cell.strip())
    return drawn and not GAPS.issuperset(map(str.strip, cells))


def find_layout(lines: Sequence[Line]) -> Layout | None:
    """The layout of lines; None where no line holds data."""
    plain = [line for line in lines if not line.comment]
    widths = Counter(len(line.cells) for line in plain[-SAMPLE:] if is_data(line.cells))
    if not widths:
        return None
    width = widths.most_common(1)[0][0]
    # the first line of data: one that more data follow, not a line with a number above a header
    filled = [i for i, line in enumerate(lines) if not line.comment and any(cell.strip() for cell in line.cells)]
    data = [len(lines[i].cells) == width and is_data(lines[i].cells) for i in filled]
    first = next((i for i, own, then in zip(filled, data, data[1:], strict=False) if own and then), None)
    start = first if first is not None else next((i for i, own in zip(filled, data, strict=True) if own), None)
    if start is None:
        return None
    head = [line for line in lines[:start] if any(cell.strip() for cell in line.cells) and not is_rule(line.cells)]
    body = [line.cells for line in lines[start:] if not line.comment and len(line.cells) == width]
    return _below(head, body[:SAMPLE], start, width)


def _below(head: Sequence[Line], rows: Sequence[Sequence[str]], start: int, cells: int) -> Layout:
    """The layout of rows of so many cells, below the lines of a head."""
    width = cells
    # lines such as `column 3: heading [deg]`, or `3  PSI  deg`
    found = [match for line in head if (match := NUMBERED.match(" ".join(line.cells)))]
    listed = dict[int, str]()
    for match in found:  # a last word that is a unit in brackets
        text = match["name"].strip()
        name, _, unit = text.rpartition(" ")
        spelt = name and says_unit(unit) and unit[0] not in "[("
        listed[int(match["number"])] = f"{name.strip()} [{unit}]" if spelt else text
    listed = listed if len(listed) > 1 and sorted(listed) == list(range(1, len(listed) + 1)) else {}
    others = head if len(listed) != width else [line for line in head if not NUMBERED.match(" ".join(line.cells))]
    near = _near(others, rows, width)
    done = []
    units = [""] * width
    if len(near) > 1 and _units_row(near[-1].cells, width):
        units = [cell.strip().strip("[]()") for cell in _fitted(near[-1].cells, width)]
        done.append(f"line {near[-1].number} is a row of units")
        near = near[:-1]
    placed = _placed(near[-1].cells, rows) if near else None
    placed = placed or Names(("",) * width, tuple(range(width)))
    names, joined = list(placed.names), placed.joined
    done += placed.done
    width = len(names)
    below = [""] * width
    used = {line.number for line in near[-1:]}
    if len(near) > 1 and _is_group_row(near[-2].cells, names):
        below, group = list(names), ""
        for i, own in enumerate(_fitted(near[-2].cells, width)):  # a group reaches over columns that have a name
            group = own or (group if below[i] else "")
            names[i] = f"{group} {below[i]}".strip() if group != below[i] else below[i]
        used |= {near[-2].number}
        done.append(f"line {near[-2].number} names groups of columns")
    if not near and (listed := listed or _named_in_line(head, width)):
        names = [listed.get(i + 1, "") for i in range(width)]
        done += ["the names of the columns are listed in the comment lines"]
    units = [units[place] if place >= 0 else "" for place in placed.places]
    above = [line for line in head if line.number not in used]
    if above:
        done.append(f"{len(above)} line{'s' if len(above) > 1 else ''} above the header not used as data")
    split = [name_and_unit(name) for name in names]
    sizes = [
        [scaled_unit(text.strip("[]() ")) for text in (own, unit)] for (_, own), unit in zip(split, units, strict=True)
    ]
    differ = [one[0] is not None and two[0] is not None and one != two for one, two in sizes]  # both units
    done += [f"{name}: the header states {own}, the row of units {unit}: neither is taken"
             for (name, own), unit, other in zip(split, units, differ, strict=True) if other]  # fmt: skip
    told = zip(split, units, differ, strict=True)
    units = ["" if other else own or unit for (_, own), unit, other in told]
    texts = distinct([name or f"column {i + 1}" for i, (name, _) in enumerate(split)])
    notes = tuple(" ".join(line.cells).strip() for line in above)
    return Layout(start, cells, tuple(texts), tuple(units), tuple(below), tuple(done), notes, joined)


def _near(head: Sequence[Line], rows: Sequence[Sequence[str]], width: int) -> list[Line]:
    """The lines just above the data that may be header and units, cut by another separator where none fits else."""
    cut = [(line, replace(line, cells=other_separator(line.cells, width))) for line in head]
    several = [pair for pair in cut if max(_filled(line) for line in pair) > 1 or width < 3][-4:]
    own = any(_placed(line.cells, rows) for line, _ in several)
    able = [line if own else other for line, other in several]
    # without those below the fullest one that fill less than half as many cells
    near = [line for line in able if _could_be_header(line.cells, rows, width)]
    filled = [_filled(line) for line in near]
    fullest = filled.index(max(filled)) if filled else 0
    return [
        line for i, line in enumerate(near)
        if i <= fullest or 2 * filled[i] >= filled[fullest] or _units_row(line.cells, width)
    ]  # fmt: skip


def _filled(line: Line) -> int:
    return sum(map(bool, _stripped(line.cells)))


def _could_be_header(cells: Sequence[str], rows: Sequence[Sequence[str]], width: int) -> bool:
    filled = [cell for cell in _stripped(cells) if cell]
    if any(is_number(cell) or TIME_LIKE.fullmatch(cell) for cell in filled):
        return False
    return (len(filled) >= 1 and _units_row(cells, width)) or _placed(cells, rows) is not None


def _placed(cells: Sequence[str], rows: Sequence[Sequence[str]]) -> Names | None:
    """The names over the columns; None where the cells are no names of them."""
    # cells without empty ones at the end; a cell that was cut within brackets is one again
    out: list[str] = []
    for cell in _stripped(cells):
        cut = out and sum(out[-1].count(x) for x in "[(") > sum(out[-1].count(x) for x in "])")
        if cut:
            out[-1] = f"{out[-1]},{cell}"
        else:
            out.append(cell)
    return place_names(out, rows, len(cells))


def _is_group_row(cells: Sequence[str], names: Sequence[str]) -> bool:
    """Whether a row above the names names groups of columns: several cells are filled, and fewer than there are names,
    or names are missing or stand twice below it."""
    filled = [cell for cell in _stripped(cells) if cell]
    below = [name for name in names if name]
    return len(filled) > 1 and (len(filled) < len(names) or len(below) < len(names) or len(set(below)) < len(below))


def _units_row(cells: Sequence[str], width: int) -> bool:
    told = [cell for cell in _stripped(cells) if cell.strip()]
    known = sum(says_unit(cell) or bool(sign_stated(f"({cell})")[0]) for cell in told)
    return len(_stripped(cells)) <= width and known >= 1 and known >= 0.6 * len(told)


def _stripped(cells: Sequence[str]) -> list[str]:
    """The cells without empty ones at the end."""
    out = [" ".join(cell.split()) for cell in cells]
    while out and not out[-1]:
        out.pop()
    return out


def _fitted(cells: Sequence[str], width: int) -> list[str]:
    return [*_stripped(cells), *[""] * width][:width]


def _named_in_line(head: Sequence[Line], width: int) -> dict[int, str]:
    """Column number -> name, from a line that names all columns behind a colon: `CHANNELS: t (s), psi (deg)`."""
    for line in head:
        _, colon, listed = " ".join(line.cells).partition(":")
        names = [part.strip() for part in re.split(r"[,;|](?![^\[(]*[\])])", listed)] if colon else []
        if len(names) == width > 2 and all(re.search(r"[^\W\d]", name) for name in names):
            return dict(enumerate(names, start=1))
    return {}


def name_and_unit(text: str) -> tuple[str, str]:
    """(name, unit) of `name [unit]`; a text in brackets that is no unit belongs to the name."""
    quoted = QUOTED.fullmatch(text.strip())
    text = quoted[2].strip() if quoted else text.strip().strip('"')
    match = IN_BRACKETS.match(text)
    if match and match["name"] and says_unit(match["unit"]) and not match["unit"].isdigit():
        return match["name"].strip(), match["unit"].strip()
    name, separator, unit = text.rpartition(" in ")
    return (name.strip(), unit.strip()) if separator and says_unit(unit) and tidy(unit) else (text, "")


def distinct(names: Sequence[str]) -> list[str]:
    """The names, those that stand there already with a number behind."""
    counts: Counter[str] = Counter()
    out = []
    for name in names:
        counts[name] += 1
        out.append(name if counts[name] == 1 else f"{name} ({counts[name]})")
    return out


DataRows: TypeAlias = tuple[list[Texts], np.ndarray, tuple[Rejected, ...], tuple[str, ...]]
"""Rows of data: the texts of their columns, their line numbers (N,), what is left out, and what was done."""
PlainRows: TypeAlias = Callable[[Layout, int], DataRows | None]
"""Reads the rows from a line number on at once; None where they need a closer look."""


def table_of(
    lines: Iterable[Line],
    sample: Sequence[Line],
    file: str,
    sheet: str = "",
    done: Sequence[str] = (),
    plain: PlainRows | None = None,
) -> RawTable | None:
    """The raw table of lines of cells; None where they hold no data.

    sample : the first and the last of the lines, by which the layout is found.  plain : a reader that is asked first.
    """
    layout = find_layout(sample)
    if layout is None:
        return None
    start = sample[layout.start].number
    rows = (plain(layout, start) if plain is not None else None) or _rows(lines, layout, start, file)
    texts, numbers, faults, left_out = rows
    if layout.joined is not None:  # columns that are one
        first, stop = layout.joined[0], sum(layout.joined)
        texts = [*texts[:first], Texts(map(" ".join, zip(*texts[first:stop], strict=True))), *texts[stop:]]
    style = table_style([cells[:STYLE_SAMPLE] for cells in texts])
    columns = [
        RawColumn(name, unit, cells, below=below, style=style)
        for name, unit, below, cells in zip(layout.names, layout.units, layout.below, texts, strict=True)
        if not (name.startswith("column ") and cells.unique() in ([], [""]))
    ]
    columns = with_minutes(with_places(list(map(with_plain_stamps, columns))))
    columns = with_halves(with_sides(with_notes(columns, layout.notes)))
    said = (*done, *layout.done, *left_out)
    return RawTable(file, tuple(columns), numbers, sheet, notes=layout.notes, done=said, faults=faults)


def _rows(lines: Iterable[Line], layout: Layout, start: int, file: str) -> DataRows:
    """The rows of data, line by line, put away as columns some thousands at a time.

    Raises
    ------
    BadInput : a line is a header with other names or units than the first one.
    """
    faults: list[Rejected] = []
    left_out = Counter[str]()
    numbers: list[int] = []
    stored: list[list[Any]] = [[] for _ in range(layout.width)]
    kept: list[tuple[str, ...]] = []

    def store() -> None:
        for own, cells in zip(stored, zip(*kept, strict=True), strict=True):
            own.append(Texts(cells).array)
        kept.clear()

    for line in lines:
        if line.number < start or not any(cell.strip() for cell in line.cells):
            continue
        if line.comment or is_rule(line.cells):
            left_out["comment lines between the data"] += 1
        elif len(line.cells) != layout.width:
            faults.append(of_other_width(line, layout.width))
        elif is_header_again(line.cells, layout):
            _check_again(line, layout, file)
            left_out["repeated header lines"] += 1
        else:
            numbers.append(line.number)
            kept.append(line.cells)
            if len(kept) == CHUNK:
                store()
    if kept:
        store()
    columns = []
    while stored:  # each is given away as its column is made
        own = stored.pop(0)
        columns.append(Texts(np.concatenate(own) if own else []))
    done = tuple(f"{count} {what} left out" for what, count in sorted(left_out.items()))
    return columns, np.array(numbers, dtype=int), tuple(faults), done


def _check_again(line: Line, layout: Layout, file: str) -> None:
    """Refuse a repeated header (or row of units) that names the columns or their units in another way."""
    split = [name_and_unit(cell) for cell in line.cells]
    known = [{re.sub(r" \(\d+\)$", "", n), below, ""} for n, below in zip(layout.names, layout.below, strict=True)]
    same = [name in own for (name, _), own in zip(split, known, strict=True)]
    if not _names_again(line.cells, layout):  # a row of units
        split, same = [("", cell.strip().strip("[]()")) for cell in line.cells], [True]
    units = [not own or tidy(own) == tidy(unit) for (_, own), unit in zip(split, layout.units, strict=True)]
    if not (all(same) and all(units)):
        said = f"a second header, with other columns or units: {','.join(line.cells)}"
        raise BadInput(said, file=file, row=line.number, hint="cut the file in two there")


def of_other_width(line: Line, width: int) -> Rejected:
    """A row that is left out for its number of cells."""
    return line.number, f"{len(line.cells)} cells under {width} columns", ",".join(line.cells)


def is_header_again(cells: Sequence[str], layout: Layout) -> bool:
    """Whether a row among the data names the columns, or their units, once more; none with a number does."""
    if any(map(PLAIN.fullmatch, cells)) or any(map(is_number, cells)):
        return False
    return _names_again(cells, layout) or _units_row(cells, layout.width)


def _names_again(cells: Sequence[str], layout: Layout) -> bool:
    """Whether more than half of the cells name columns of the table, in any order."""
    names = [name_and_unit(cell)[0] for cell in cells]
    return sum(name in layout.names for name in names) > 0.5 * layout.width


# ---- Which name of a header stands over which cells, where there are fewer names than cells.

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
    # (first, number, whether of weeks and seconds) of the cells of times
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
    for start, length, weeks in found:
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


# ---- Several tables below each other in one text, each with a header of its own.

OF_TABLES = ",;\t|"
WORDS = re.compile(r"^[ \t]*[\"'\[#*]?[^\W\d][^\n]*$", re.MULTILINE)
"""A line that begins with a word."""
FIRST, MOST, MOST_TABLES = 3, 300, 20
"""Rows of the least table, and lines of words from which on words are the data of a log; tables that are read."""


def parts_of(text: str) -> list[str]:
    """The text, cut above each further header: names of other columns than before, and rows of numbers below them."""
    heads = [match.start() for match in itertools.islice(WORDS.finditer(text), MOST + 1)]
    if not 1 < len(heads) <= MOST:
        return [text]
    cuts, before = [0], set[str]()
    for start in heads:
        names = _header(text, start)
        if names and before and len(cuts) < MOST_TABLES and len(names & before) <= 0.5 * len(names):
            cuts.append(_after_data(text, start))
        before = names or before
    return [text[a:b] for a, b in zip(cuts, [*cuts[1:], len(text)], strict=True)]


def _header(text: str, start: int) -> set[str]:
    """The names of the line at a place, where rows of as many numbers stand below it; else nothing."""
    lines = [line for line in text[start : start + 20000].splitlines()[:12] if line.strip()][:6]
    if len(lines) < FIRST + 1:
        return set()
    separator = max(OF_TABLES, key=lines[-1].count)
    rows = [[cell.strip().strip("\"'#") for cell in line.rstrip(f"\r{separator}").split(separator)] for line in lines]
    width = len(rows[-1])
    if width < 2 or len(rows[0]) != width or any(map(is_number, rows[0])) or all(map(says_unit, rows[0])):
        return set()
    body = rows[-FIRST:]
    return {re.split(r"[\[(]", name)[0].strip() for name in rows[0]} if all(map(is_data, body)) else set()


def _after_data(text: str, start: int) -> int:
    """Behind the last line of data before a header: the lines between belong to it."""
    while start > 0:
        before = text.rfind("\n", 0, start - 1) + 1
        line = text[before:start].strip()
        separator = max(OF_TABLES, key=line.count)
        if line and is_data(line.split(separator)) and line.count(separator):
            return start
        start = before
    return 0


def read_parts(text: str, path: Path, read: Callable[[str], RawTable]) -> list[RawTable]:
    """The tables of a text, read one by one; a part without rows of numbers is left out where others have some."""
    parts = parts_of(text)
    if len(parts) == 1:
        return [read(text)]
    out, line = [], 0
    for number, part in enumerate(parts, start=1):
        try:
            table = _shifted(read(part), line)
            # the only text of the first line of a part, where it is no header
            first = next((line.strip(' \t\r,;#*[]"') for line in part.splitlines() if line.strip()), "")
            title = "" if any(separator in first for separator in OF_TABLES) else first[:60]
            named = title and all(title != other.sheet for other in out)
            out.append(replace(table, sheet=title if named else f"table {number}"))
        except BadInput:
            if number == len(parts) and not out:
                raise
        line += part.count("\n")
    return out


def _shifted(table: RawTable, lines: int) -> RawTable:
    """A table with the line numbers of the whole file."""
    faults = tuple((number + lines, said, text) for number, said, text in table.faults)
    return replace(table, rows=np.asarray(table.rows) + lines, faults=faults)
