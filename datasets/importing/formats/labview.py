"""LabVIEW measurement files (.lvm): a header of names and values, one or more segments of rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from ..cell_texts import Texts
from ..cells import Style
from ..layout import distinct, name_and_unit
from ..raw import RawColumn, RawTable, usable

END = "***End_of_Header***"
SINCE_1904 = -2082844800.0
"""Seconds since 1970 of LabVIEW's begin of time."""
BY = "the LabVIEW file states it"


@dataclass
class LabViewSegment:
    """The header of a segment, key -> its cells; the names of its columns, and its rows with their line numbers."""

    head: dict[str, list[str]] = field(default_factory=dict)
    names: list[str] = field(default_factory=list)
    rows: list[tuple[int, list[str]]] = field(default_factory=list)

    def number(self, key: str, place: int, default: float) -> float:
        """The number that a line of the header states for a channel; that of the last one where it states fewer."""
        cells = self.head.get(key, [])
        return _float(cells[min(place, len(cells) - 1)], default) if cells else default


def read_labview(text: str, path: Path) -> list[RawTable] | None:
    """A table for every segment, or for every channel with a time of its own, None where the text is no LabVIEW
    measurement file; BadInput where there is no data."""
    if not text[:100].lstrip("\ufeff \t\r\n").startswith("LabVIEW Measurement"):
        return None
    lines = text.lstrip("\ufeff").splitlines()
    separator = "," if any(line.lower().startswith("separator,") for line in lines[:40]) else "\t"
    head, segments = _segments(lines, separator)
    style: Style = "comma" if head.get("Decimal_Separator", ["."])[:1] == [","] else "point"
    named = [(f"segment {i + 1}" if len(segments) > 1 else "", segment) for i, segment in enumerate(segments)]
    tables = [table for sheet, segment in named for table in _tables(segment, head, style, path, sheet)]
    return usable(tables, path, "no segment of the LabVIEW file holds rows of numbers", "export it as CSV")


def _segments(lines: Sequence[str], separator: str) -> tuple[dict[str, list[str]], list[LabViewSegment]]:
    """(the header of the file, its segments)."""
    file_head: dict[str, list[str]] = {}
    head, place, segments = file_head, "file", [LabViewSegment()]
    for number, line in enumerate(lines, start=1):
        cells = [cell.strip() for cell in line.split(separator)]
        if cells[0] == END:
            place = "between" if place == "file" else "names"
            head = {}
        elif place in ("file", "head"):
            head[cells[0]] = _filled(cells[1:])
        elif place == "names" and any(cells):
            segments[-1].names, place = cells, "rows"
        elif place in ("rows", "between") and cells[0] == "Channels":
            segments.append(LabViewSegment({cells[0]: _filled(cells[1:])}))
            head, place = segments[-1].head, "head"
        elif place == "rows" and any(cells):
            segments[-1].rows.append((number, cells))
        elif place == "between" and any(cells):  # a file without headers of segments
            segments[-1].names, place = cells, "rows"
    return file_head, [segment for segment in segments if len(segment.rows) > 2]


def _filled(cells: list[str]) -> list[str]:
    while cells and not cells[-1]:
        cells.pop()
    return cells


def _tables(
    segment: LabViewSegment, file: Mapping[str, list[str]], style: Style, path: Path, sheet: str
) -> list[RawTable]:
    """One table of a segment; where every channel has times of its own (X_Columns Multi), one for each."""
    names = [name for name in segment.names if name.lower() != "comment"]
    timed = [i for i, name in enumerate(names) if name.lower().startswith("x_value")]
    kind = (segment.head.get("X_Columns") or file.get("X_Columns") or ["One"])[0].lower()
    channels = [i for i in range(len(names)) if i not in timed]
    groups = (
        _groups(timed, channels, len(names)) if timed and kind == "multi" else [(timed[0] if timed else None, channels)]
    )
    rows = np.array([line for line, _ in segment.rows])
    texts = [Texts([cells[i] if i < len(cells) else "" for _, cells in segment.rows]) for i in range(len(names))]
    units = dict(zip(channels, segment.head.get("Y_Unit_Label", []), strict=False))
    absolute = (file.get("Time_Pref") or [""])[0].lower() == "absolute"
    out = []
    for place, (at, group) in enumerate(groups):
        own = texts[at] if at is not None and texts[at].unique() != [""] else None
        time = _time(
            own, segment.number("X0", place, 0.0), segment.number("Delta_X", place, np.nan), absolute, rows.size
        )
        made = _columns([(names[i], units.get(i, ""), texts[i]) for i in group], style)
        part = sheet if len(groups) == 1 else f"{sheet} {made[0].name if made else ''}".strip()
        if made:
            columns = (*(replace(column, style=style) for column in time), *made)
            out.append(RawTable.of(path, columns, "LabVIEW measurement file", part, rows))
    return out


def _groups(timed: Sequence[int], channels: Sequence[int], width: int) -> list[tuple[int, list[int]]]:
    """(place of the times, places of the channels behind it up to the next times)."""
    ends = [*timed[1:], width]
    return [(at, [i for i in channels if at < i < end]) for at, end in zip(timed, ends, strict=True)]


def _time(texts: Texts | None, start: float, step: float, absolute: bool, count: int) -> tuple[RawColumn, ...]:
    """The column of the times: as it stands, or by the first time and the step; none where neither is known."""
    if texts is None and not step > 0.0:
        return ()
    column = RawColumn("X_Value", "s", texts if texts is not None else start + step * np.arange(count), source=BY)
    if not absolute or not np.nanmedian(column.numbers) > -SINCE_1904:
        return (column,)
    return (RawColumn("time", "", column.numbers + SINCE_1904, "time", BY),)


def _columns(channels: Sequence[tuple[str, str, Texts]], style: Style) -> list[RawColumn]:
    """Columns of (name, label of the unit, cells)."""
    split = [name_and_unit(name) for name, _, _ in channels]
    titles = distinct([name for name, _ in split])
    return [
        RawColumn(title, unit or label, texts, style=style)
        for title, (_, unit), (_, label, texts) in zip(titles, split, channels, strict=True)
    ]


def _float(text: str, default: float) -> float:
    try:
        return float(text.replace(",", "."))
    except ValueError:
        return default
