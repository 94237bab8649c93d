"""Logs of single programs: MOOS (.alog), Hypack (RAW), and tracks as XML: GPX, and Training Center XML
(TCX), in which sports watches write them."""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as Tree
from collections import defaultdict
from dataclasses import replace
from pathlib import Path

import numpy as np

from ....models.errors import BadInput
from ....models.number_texts import DECIMAL
from ..moments import moment, without_zone
from ..raw import RawColumn, RawTable, Rejected, usable, with_faults
from .fields import StatedField, stated_fields, table_of_fields

# ---- MOOS: a value of a variable a line, with the seconds since the log was started.

LINE = re.compile(rf"(?P<time>-?\d+\.\d+)\s+(?P<name>[A-Za-z]\w{{1,80}})\s+(?P<source>\S+)\s+(?P<value>{DECIMAL})\s*$")
START = re.compile(r"LOGSTART\s+(\d+\.?\d*)")
BY_MOOS = "MOOS states it"
ANGLES = ("RUDDER", "ELEVATOR")
"""Words in the name of a variable that is an angle in degrees."""


def _is_alog(text: str) -> bool:
    """Whether a text is a log of MOOS."""
    head = text[:6000]
    if "%% LOG FILE" in head or "%% LOGSTART" in head:
        return True
    lines = [line for line in head.splitlines()[:40] if line.strip() and not line.startswith("%")][:-1]
    variables = [match["name"] for line in lines if (match := LINE.match(line))]
    return len(variables) > 0.4 * len(lines) and sum(name.isupper() for name in variables) > 5


def read_alog(text: str, path: Path) -> list[RawTable] | None:
    """A table for every variable of numbers, None where the text is no log of MOOS; BadInput where there is none."""
    if not _is_alog(text):
        return None
    start = START.search(text[:20000])
    since = float(start[1]) if start else 0.0
    series: dict[str, list[tuple[int, float, float]]] = defaultdict(list)
    for number, line in enumerate(text.splitlines(), start=1):
        match = LINE.match(line) if len(line) < 1000 else None
        if match is not None:
            series[match["name"]].append((number, since + float(match["time"]), float(match["value"])))
    tables = [_variable(path, name, own, bool(start)) for name, own in series.items() if len(own) > 2]
    return usable(tables, path, "no variable of the MOOS log holds numbers")


def _variable(path: Path, name: str, own: list[tuple[int, float, float]], dated: bool) -> RawTable:
    other = StatedField(name, "", "deg" if any(word in name for word in ANGLES) else "")
    _, quantity, unit = stated_fields("MOOS")["variable"].get(name, other)
    lines, times, values = zip(*own, strict=True)
    time = RawColumn("time", "s", np.array(times), "time" if dated else "", BY_MOOS)
    column = RawColumn(name, unit, np.array(values), quantity, BY_MOOS if unit else "")
    return RawTable.of(path, (time, column), f"{len(own)} values", name, lines)


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
        numbers = _numbers(cells[1:])
        if numbers is None or len(numbers) <= max(map(int, records.get(kind, ())), default=0) + 1:
            faults.append((number, f"no numbers of a record {kind}", line))
        else:
            rows[kind, cells[0]].append((number, numbers))
    tables = [_device(path, key, own, devices, begin) for key, own in rows.items() if len(own) > 2]
    hint = f"read are {', '.join((*records, *READINGS))}"
    return with_faults(usable(tables, path, "no record of the file can be used", hint), faults, count)


def _numbers(cells: list[str]) -> list[float] | None:
    try:
        return [float(cell) for cell in cells]
    except ValueError:
        return None


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
    ((tag, fields),) = stated_fields(kind).items()
    points = [_texts(point) for point in _root(text, path, kind).iter() if _tag(point) == tag]
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


def _root(text: str, path: Path, kind: str) -> Tree.Element:
    """The root of an XML document of a stranger: BadInput where it declares entities, or is damaged."""
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise BadInput(f"a {kind} file that declares entities", file=path, hint="export it again")
    try:
        return Tree.fromstring(text.encode("utf-8"))
    except (Tree.ParseError, ValueError, RecursionError) as error:
        raise BadInput(f"not a {kind} file that can be read ({error})", file=path) from None


def _tag(element: Tree.Element) -> str:
    """The tag of an element in lower case, without its namespace."""
    return str(element.tag).rpartition("}")[2].lower()


def _texts(point: Tree.Element) -> dict[str, str]:
    """Attribute of a point, or tag of an element within it -> its text."""
    return {**{_tag(child): (child.text or "").strip() for child in point.iter()}, **point.attrib}
