"""Logs of single programs: MOOS (.alog), Hypack (RAW), tracks as XML, GPX and Training Center XML (TCX), in which
sports watches write them, and annotated CSV of InfluxDB."""

from __future__ import annotations

import csv
import math
import re
import xml.etree.ElementTree as Tree
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeAlias

import numpy as np

from ....models.errors import BadInput
from ....models.number_texts import DECIMAL
from ..cells import Texts
from ..instruments import UNITS
from ..moments import moment, without_zone
from ..names import joined, listed
from ..raw import RawColumn, RawTable, Rejected, usable, with_faults
from .fields import StatedField, stated_fields, table_of_fields

# ---- MOOS: a value of a variable a line, with the seconds since the log was started.

LINE = re.compile(rf"(?P<time>-?\d+\.\d+)\s+(?P<name>[A-Za-z]\w{{1,80}})\s+(?P<source>\S+)\s+(?P<value>{DECIMAL})\s*$")
START = re.compile(r"LOGSTART\s+(\d+\.?\d*)")
BY_MOOS = "MOOS states it"
ANGLES = ("RUDDER", "ELEVATOR")
"""Words in the name of a variable that is an angle in degrees."""


def read_alog(text: str, path: Path) -> list[RawTable] | None:
    """A table for every variable of numbers, None where the text is no log of MOOS; BadInput where there is none."""
    head = text[:6000]
    lines = [line for line in head.splitlines()[:40] if line.strip() and not line.startswith("%")][:-1]
    variables = [match["name"] for line in lines if (match := LINE.match(line))]
    told = len(variables) > 0.4 * len(lines) and sum(name.isupper() for name in variables) > 5
    if not (told or "%% LOG FILE" in head or "%% LOGSTART" in head):
        return None
    start = START.search(text[:20000])
    since = float(start[1]) if start else 0.0
    series: dict[str, list[tuple[int, float, float]]] = defaultdict(list)
    for number, line in enumerate(text.splitlines(), start=1):
        match = LINE.match(line) if len(line) < 1000 else None
        if match is not None:
            series[match["name"]].append((number, since + float(match["time"]), float(match["value"])))
    tables = []
    for name, own in series.items():
        if len(own) > 2:
            other = StatedField(name, "", "deg" if any(word in name for word in ANGLES) else "")
            _, quantity, unit = stated_fields("MOOS")["variable"].get(name, other)
            lines, times, values = zip(*own, strict=True)
            time = RawColumn("time", "s", np.array(times), "time" if start else "", BY_MOOS)
            column = RawColumn(name, unit, np.array(values), quantity, BY_MOOS if unit else "")
            tables.append(RawTable.of(path, (time, column), f"{len(own)} values", name, lines))
    return usable(tables, path, "no variable of the MOOS log holds numbers")


# ---- Hypack: a record a line, of a device that the header names.

DEVICE = re.compile(r'DEV\s+(?P<number>\d+)\s+\d+\s+"(?P<name>[^"]*)"')
BEGIN = re.compile(r"TND\s+(?P<hour>\d+):(?P<minute>\d+):(?P<second>\d+)\s+(?P<month>\d+)/(?P<day>\d+)/(?P<year>\d{4})")
BY_HYPACK = "Hypack's format states it"
READINGS = ("EC1", "EC2", "TID", "DFT")
"""Records of a single reading of a device, whose name says what it is."""
DAY = 86400.0


def read_hypack(text: str, path: Path) -> list[RawTable] | None:
    """A table for every device and kind of record, None where the text begins as no RAW file of Hypack; BadInput where
    no record can be used."""
    head = text[:20000]
    if not (re.match(r"\s*(FTP|VER|INF)\s", head) and re.search(r"^(DEV|EOH)\b", head, re.MULTILINE)):
        return None
    devices = {match["number"]: match["name"] for match in map(DEVICE.match, text.splitlines()) if match}
    begin, records = BEGIN.search(text), stated_fields("Hypack")
    rows: dict[tuple[str, str], list[tuple[int, list[float]]]] = defaultdict(list)
    faults: list[Rejected] = []
    count = 0
    for number, line in enumerate(text.splitlines(), start=1):
        kind, *cells = line.split() or [""]
        if (kind not in records and kind not in READINGS) or len(cells) < 2:
            continue
        count += 1
        try:
            numbers = [float(cell) for cell in cells[1:]]
        except ValueError:
            numbers = []
        if len(numbers) <= max(map(int, records.get(kind, ())), default=0) + 1:
            faults.append((number, f"no numbers of a record {kind}", line))
        else:
            rows[kind, cells[0]].append((number, numbers))
    tables = [_device(path, key, own, devices, begin) for key, own in rows.items() if len(own) > 2]
    hint = f"read are {', '.join((*records, *READINGS))}"
    return with_faults(usable(tables, path, "no record of the file can be used", hint), faults, count)


def _device(
    path: Path, key: tuple[str, str], own: list, devices: dict[str, str], begin: re.Match | None
) -> RawTable | None:
    kind, device = key
    name = devices.get(device, "")
    seconds = np.array([numbers[0] for _, numbers in own])
    seconds = seconds + DAY * np.cumsum(np.concatenate([[0.0], np.diff(seconds) < -DAY / 2.0]))
    day = moment("{year}-{month}-{day}".format_map(begin.groupdict())) if begin else math.nan
    source = f"{BY_HYPACK}: {kind} of device {device} {name}".strip()
    time = RawColumn("time", "s", seconds) if day != day else RawColumn("time", "", without_zone(day + seconds))
    time, lines = replace(time, source=source), [line for line, _ in own]
    if kind in READINGS:
        columns = (time, RawColumn(name or kind, "", np.array([numbers[1] for _, numbers in own])))
        return RawTable.of(path, columns, f"{len(own)} records", f"{kind} {device}", lines)
    fields = stated_fields("Hypack")[kind]
    values = {place: np.array([numbers[1 + int(place)] for _, numbers in own]) for place in fields}
    return table_of_fields(path, fields, values, time, f"{len(own)} records", f"{kind} {device}", lines)


# ---- Tracks as XML.

TRACKS = {"GPX": "<gpx", "TCX": "<TrainingCenterDatabase"}
"""Kind -> how its document begins."""


def read_track(text: str, path: Path) -> list[RawTable] | None:
    """The points of all tracks of a GPX or TCX file, None where the text is neither; BadInput where there are none, or
    the file declares entities."""
    kind = next((kind for kind, begin in TRACKS.items() if begin in text[:4000]), None)
    if kind is None:
        return None
    if "<!DOCTYPE" in text or "<!ENTITY" in text:  # of a stranger
        raise BadInput(f"a {kind} file that declares entities", file=path, hint="export it again")
    try:
        root = Tree.fromstring(text.encode("utf-8"))
    except (Tree.ParseError, ValueError, RecursionError) as error:
        raise BadInput(f"not a {kind} file that can be read ({error})", file=path) from None
    ((tag, fields),) = stated_fields(kind).items()
    points = [_texts(point) for point in root.iter() if _tag(point) == tag]
    points = [point for point in points if kind == "GPX" or point.get("time")]
    columns = [
        RawColumn(name, unit, tuple(point.get(field, "") for point in points), quantity, f"{kind} states it")
        for field, (name, quantity, unit) in fields.items()
        if any(point.get(field) for point in points)
    ]
    if not columns:
        raise BadInput(f"no track in the {kind} file", file=path)
    times = RawColumn("time", "", tuple(point.get("time", "") for point in points), "", f"{kind} states it: UTC")
    return [RawTable.of(path, (times, *columns), f"{kind}, {len(points)} points")]


def _tag(element: Tree.Element) -> str:
    """The tag of an element in lower case, without its namespace."""
    return str(element.tag).rpartition("}")[2].lower()


def _texts(point: Tree.Element) -> dict[str, str]:
    """Attribute of a point, or tag of an element within it -> its text."""
    return {**{_tag(child): (child.text or "").strip() for child in point.iter()}, **point.attrib}


# ---- InfluxDB's annotated CSV: blocks of rows below annotations, long or with a column a field.

ANNOTATION = re.compile(r"#(datatype|group|default)\b", re.IGNORECASE)
TIME, FIELD, VALUE, MEASUREMENT = "_time", "_field", "_value", "_measurement"
OWN = ("", "result", "table", "_start", "_stop", TIME, FIELD, VALUE, MEASUREMENT)
"""Columns of InfluxDB itself; the others of a block in long form are tags."""
MOST_SERIES, FEWEST = 200, 3


Block: TypeAlias = tuple[list[str], list[tuple[int, list[str]]]]
"""The names of a block, and its rows with their line numbers."""


def read_influx(text: str, path: Path) -> list[RawTable] | None:
    """A table for every series, None where the text begins neither with annotations nor with a header of InfluxDB;
    BadInput where no block has times and values."""
    first = text[:4000].lstrip("\ufeff\r\n ").partition("\n")[0]
    if ANNOTATION.match(first) is None and not {TIME, VALUE} <= {name.strip() for name in first.split(",")}:
        return None
    faults: list[Rejected] = []
    # the blocks of a file; a new one begins behind annotations or a blank line
    blocks: list[Block] = []
    waiting = True
    for number, line in enumerate(text.lstrip("\ufeff").splitlines(), start=1):
        if not line.strip(" ,\r") or ANNOTATION.match(line):
            waiting = True
            continue
        cells = next(csv.reader([line[:20000]]), [])
        if waiting and (TIME in cells or not blocks):
            blocks.append(([cell.strip() for cell in cells], []))
        elif blocks and len(cells) == len(blocks[-1][0]):
            blocks[-1][1].append((number, cells))
        else:
            faults.append((number, f"{len(cells)} cells under {len(blocks[-1][0]) if blocks else 0} columns", line))
        waiting = False
    found = [table for block in blocks for table in _tables(block, path)]
    hint = "export it with a header, as annotated CSV"
    return with_faults(usable(found, path, "no block with times and values", hint), faults)


def _tables(block: Block, path: Path) -> Iterator[RawTable]:
    names, rows = block
    if TIME not in names or not rows:
        return
    if VALUE in names and FIELD in names:
        yield from _long(block, path)
        return
    columns = [(name, [cells[i] for _, cells in rows]) for i, name in enumerate(names) if name not in OWN]
    made = [RawColumn(name, "", Texts(cells)) for name, cells in columns if any(cells)]
    if made:
        times = _times([cells[names.index(TIME)] for _, cells in rows])
        yield RawTable.of(path, (times, *made), "InfluxDB", rows=[number for number, _ in rows])


def _long(block: Block, path: Path) -> Iterator[RawTable]:
    """A table for every field of every measurement and set of tags."""
    names, rows = block
    place = {name: i for i, name in enumerate(names)}
    tags = [i for name, i in place.items() if name not in OWN]
    groups: dict[tuple[str, ...], list[tuple[int, list[str]]]] = defaultdict(list)
    for number, cells in rows:
        measurement = cells[place[MEASUREMENT]] if MEASUREMENT in place else ""
        groups[measurement, cells[place[FIELD]], *(cells[i] for i in tags)].append((number, cells))
    several = [k for k, i in enumerate(tags) if len({key[2 + k] for key in groups}) > 1]
    for (measurement, name, *values), own in list(groups.items())[:MOST_SERIES]:
        if len(own) < FEWEST:
            continue
        unit = next((v for v, i in zip(values, tags, strict=True) if joined(names[i]) in UNITS), "")
        called = measurement if joined(name) in listed("values") and measurement else name
        sheet = " ".join(dict.fromkeys(part for part in (measurement, name, *(values[k] for k in several)) if part))
        column = RawColumn(called, unit, Texts([cells[place[VALUE]] for _, cells in own]))
        times = _times([cells[place[TIME]] for _, cells in own])
        yield RawTable.of(path, (times, column), f"{len(own)} values", sheet, [number for number, _ in own])


def _times(cells: Sequence[str]) -> RawColumn:
    return RawColumn("time", "", Texts(cells), source="InfluxDB states it: UTC")


# ---- Smoothed best estimates of a trajectory (SBET): rows of 17 binary numbers without a header.

FIELDS = 17
SECOND, LATITUDE, LONGITUDE, X_SPEED, Y_SPEED, ROLL, HEADING, WANDER, YAW_RATE = 0, 1, 2, 4, 5, 7, 9, 10, 16
ROW = np.dtype(("<f8", FIELDS))
HEAD_ROWS = 50
"""Rows that tell whether a file is of this form."""
LONGEST_STEP, FASTEST = 60.0, 100.0
"""Seconds between rows, and m/s, that such a file holds at most."""
RADIUS, AGREES = 6.371e6, 0.1
"""Radius of the earth, m, and the share of the speed within which velocities and positions agree."""
BY = "the SBET form states it"


def looks_like_sbet(data: bytes) -> bool:
    """Whether a binary file begins with rows of times, positions and angles."""
    size = min(len(data) // ROW.itemsize, HEAD_ROWS)
    if size < 3 or len(data) % ROW.itemsize:
        return False
    rows = np.frombuffer(data, dtype=ROW, count=size)
    if not np.isfinite(rows).all():
        return False
    steps = np.diff(rows[:, SECOND])
    limits = {LATITUDE: np.pi / 2.0, LONGITUDE: 7.0, X_SPEED: FASTEST, Y_SPEED: FASTEST, ROLL: 4.0, HEADING: 7.0}
    inside = all(np.abs(rows[:, place]).max() <= most for place, most in limits.items())
    return inside and bool((steps > 0.0).all() and steps.max() < LONGEST_STEP and np.ptp(rows[:, LATITUDE]) < 0.1)


def read_sbet(data: bytes, path: Path) -> list[RawTable]:
    """The rows of an SBET file: times in seconds of the GPS week, angles in radians.

    The heading counts from the wander azimuth frame, which is turned by the wander angle from north.
    """
    rows = np.frombuffer(data, dtype=ROW)
    values = {str(place): rows[:, place].copy() for place in range(FIELDS)}
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        values[str(HEADING)] = (rows[:, HEADING] - rows[:, WANDER]) % (2.0 * np.pi)
        # velocities to north and east: of the axes that programs use the ones that agree with the positions, or none
        heading = values[str(HEADING)]
        north, east = (RADIUS * np.gradient(rows[:, place], rows[:, SECOND]) for place in (LATITUDE, LONGITUDE))
        track = np.stack([north, east * np.cos(rows[:, LATITUDE])])
        tried = [_turned(rows[:, X_SPEED], rows[:, Y_SPEED], angle)
                 for angle in (rows[:, WANDER], -rows[:, WANDER], heading)]  # fmt: skip
        misfits = [float(np.nanmedian(np.abs(own - track))) for own in tried]
        best = int(np.argmin(misfits))
        agrees = misfits[best] < AGREES * float(np.nanmedian(np.hypot(*track)))
        values |= dict(zip(("north", "east"), tried[best], strict=True)) if agrees else {}
    fields = stated_fields("SBET")["row"] | stated_fields("SBET")["velocity"]
    time = RawColumn("GPS seconds of week", "s", values[str(SECOND)], "", BY)
    return usable([table_of_fields(path, fields, values, time, f"SBET, {len(rows)} rows")], path, "no rows of numbers")


def _turned(x: np.ndarray, y: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """(2, N) to north and east of a vector along axes that are turned clockwise by an angle."""
    return np.stack([x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)])


# ---- Text of Applanix's POS Export Utility: what its axes state of the roll.

POSPAC_TITLE = "POS Export Utility"


def with_pospac(table: RawTable) -> RawTable:
    """A table of that program: its axes are forward, right, down."""
    if not any(POSPAC_TITLE in note for note in table.notes):
        return table
    return table.told(
        lambda c: replace(c, said=(*c.said, "positive to starboard")) if c.name.strip().lower() == "roll" else c,
        f"{POSPAC_TITLE}: axes forward, right, down",
    )
