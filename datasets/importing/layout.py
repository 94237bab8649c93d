"""The layout of a table of cells: its header, its row of units, its data, and rows that do not belong to it."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from ...models.errors import BadInput
from .beside import with_halves, with_minutes, with_notes, with_places, with_sides
from .cell_texts import CHUNK, Texts
from .cells import GAPS, PLAIN, is_number, table_style
from .cells import SAMPLE as STYLE_SAMPLE
from .headers import says_unit, scaled_unit, sign_stated
from .moments import with_plain_stamps
from .name_places import Names, other_separator, place_names
from .raw import RawColumn, RawTable, Rejected
from .units import tidy

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


def find_layout(lines: Sequence[Line]) -> Layout | None:
    """The layout of lines; None where no line holds data."""
    plain = [line for line in lines if not line.comment]
    widths = Counter(len(line.cells) for line in plain[-SAMPLE:] if is_data(line.cells))
    if not widths:
        return None
    width = widths.most_common(1)[0][0]
    start = _first_of_data(lines, width)
    if start is None:
        return None
    head = [line for line in lines[:start] if any(cell.strip() for cell in line.cells)]
    body = [line.cells for line in lines[start:] if not line.comment and len(line.cells) == width]
    return _below(head, body[:SAMPLE], start, width)


def _first_of_data(lines: Sequence[Line], width: int) -> int | None:
    """Index of the first line of data: one that more data follow, not a line with a number above a header."""
    filled = [i for i, line in enumerate(lines) if not line.comment and any(cell.strip() for cell in line.cells)]
    data = [len(lines[i].cells) == width and is_data(lines[i].cells) for i in filled]
    first = next((i for i, own, then in zip(filled, data, data[1:], strict=False) if own and then), None)
    return first if first is not None else next((i for i, own in zip(filled, data, strict=True) if own), None)


def _below(head: Sequence[Line], rows: Sequence[Sequence[str]], start: int, cells: int) -> Layout:
    """The layout of rows of so many cells, below the lines of a head."""
    width = cells
    listed = _listed_names(head)
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
        below, names = names, _with_groups(_fitted(near[-2].cells, width), names)
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
    differ = [bool(own and unit) and _other_size(own, unit) for (_, own), unit in zip(split, units, strict=True)]
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
    return _without_notes([line for line in able if _could_be_header(line.cells, rows, width)], width)


def _filled(line: Line) -> int:
    return sum(map(bool, _stripped(line.cells)))


def _without_notes(near: Sequence[Line], width: int) -> list[Line]:
    """Lines that could be headers, without those below the fullest one that fill less than half as many cells."""
    filled = [_filled(line) for line in near]
    fullest = filled.index(max(filled)) if filled else 0
    return [
        line for i, line in enumerate(near)
        if i <= fullest or 2 * filled[i] >= filled[fullest] or _units_row(line.cells, width)
    ]  # fmt: skip


def _other_size(one: str, other: str) -> bool:
    """Whether two texts are both units, and not the same."""
    sizes = [scaled_unit(text.strip("[]() ")) for text in (one, other)]
    return all(unit is not None for unit, _ in sizes) and sizes[0] != sizes[1]


def _could_be_header(cells: Sequence[str], rows: Sequence[Sequence[str]], width: int) -> bool:
    filled = [cell for cell in _stripped(cells) if cell]
    if any(is_number(cell) or TIME_LIKE.fullmatch(cell) for cell in filled):
        return False
    return (len(filled) >= 1 and _units_row(cells, width)) or _placed(cells, rows) is not None


def _whole_brackets(cells: Sequence[str]) -> list[str]:
    """Cells without empty ones at the end; a cell that was cut within brackets is one again."""
    out: list[str] = []
    for cell in _stripped(cells):
        cut = out and sum(out[-1].count(x) for x in "[(") > sum(out[-1].count(x) for x in "])")
        if cut:
            out[-1] = f"{out[-1]},{cell}"
        else:
            out.append(cell)
    return out


def _placed(cells: Sequence[str], rows: Sequence[Sequence[str]]) -> Names | None:
    """The names over the columns; None where the cells are no names of them."""
    return place_names(_whole_brackets(cells), rows, len(cells))


def _is_group_row(cells: Sequence[str], names: Sequence[str]) -> bool:
    """Whether a row above the names names groups of columns: several cells are filled, and fewer than there are names,
    or names are missing or stand twice below it."""
    filled = [cell for cell in _stripped(cells) if cell]
    below = [name for name in names if name]
    return len(filled) > 1 and (len(filled) < len(names) or len(below) < len(names) or len(set(below)) < len(below))


def _with_groups(groups: Sequence[str], names: Sequence[str]) -> list[str]:
    """Names with that of their group before them; a group reaches to the next one, over columns that have a name."""
    out, group = [], ""
    for own, name in zip(groups, names, strict=True):
        group = own or (group if name else "")
        out.append(f"{group} {name}".strip() if group != name else name)
    return out


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


def _listed_names(head: Sequence[Line]) -> dict[int, str]:
    """Column number -> name, from lines such as `column 3: heading [deg]`, or `3  PSI  deg`."""
    found = [NUMBERED.match(" ".join(line.cells)) for line in head]
    names = {int(match["number"]): _with_last_unit(match["name"].strip()) for match in found if match}
    return names if len(names) > 1 and sorted(names) == list(range(1, len(names) + 1)) else {}


def _with_last_unit(text: str) -> str:
    """A name whose last word is a unit, with that in brackets."""
    name, _, unit = text.rpartition(" ")
    return f"{name.strip()} [{unit}]" if name and says_unit(unit) and unit[0] not in "[(" else text


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
    cells = _joined(texts, layout.joined)
    style = table_style([texts[:STYLE_SAMPLE] for texts in cells])
    columns = [
        RawColumn(name, unit, texts, below=below, style=style)
        for name, unit, below, texts in zip(layout.names, layout.units, layout.below, cells, strict=True)
        if not (name.startswith("column ") and texts.unique() in ([], [""]))
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
        if line.comment:
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


def _joined(columns: list[Texts], joined: tuple[int, int] | None) -> list[Texts]:
    """The columns, those that are one joined with blanks."""
    if joined is None:
        return columns
    start, stop = joined[0], joined[0] + joined[1]
    one = Texts(map(" ".join, zip(*columns[start:stop], strict=True)))
    return [*columns[:start], one, *columns[stop:]]


def is_header_again(cells: Sequence[str], layout: Layout) -> bool:
    """Whether a row among the data names the columns, or their units, once more; none with a number does."""
    if any(map(PLAIN.fullmatch, cells)) or any(map(is_number, cells)):
        return False
    return _names_again(cells, layout) or _units_row(cells, layout.width)


def _names_again(cells: Sequence[str], layout: Layout) -> bool:
    """Whether more than half of the cells name columns of the table, in any order."""
    names = [name_and_unit(cell)[0] for cell in cells]
    return sum(name in layout.names for name in names) > 0.5 * layout.width
