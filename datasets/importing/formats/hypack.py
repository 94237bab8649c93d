"""Hypack RAW files: a record a line, of a device that the header names."""

from __future__ import annotations

import datetime
import re
from collections import defaultdict
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..moments import without_zone
from ..raw import RawColumn, RawTable, Rejected, usable, with_faults
from .fields import stated_fields, table_of_fields

DEVICE = re.compile(r'DEV\s+(?P<number>\d+)\s+\d+\s+"(?P<name>[^"]*)"')
BEGIN = re.compile(r"TND\s+(?P<hour>\d+):(?P<minute>\d+):(?P<second>\d+)\s+(?P<month>\d+)/(?P<day>\d+)/(?P<year>\d{4})")
BY = "Hypack's format states it"
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
    tables = [_table(path, key, own, devices, begin) for key, own in rows.items() if len(own) > 2]
    hint = f"read are {', '.join((*records, *READINGS))}"
    return with_faults(usable(tables, path, "no record of the file can be used", hint), faults, count)


def _numbers(cells: list[str]) -> list[float] | None:
    try:
        return [float(cell) for cell in cells]
    except ValueError:
        return None


def _table(
    path: Path, key: tuple[str, str], own: list, devices: dict[str, str], begin: re.Match | None
) -> RawTable | None:
    kind, device = key
    name = devices.get(device, "")
    seconds = np.array([numbers[0] for _, numbers in own])
    seconds = seconds + DAY * np.cumsum(np.concatenate([[0.0], np.diff(seconds) < -DAY / 2.0]))
    day = _day(begin)
    source = f"{BY}: {kind} of device {device} {name}".strip()
    time = RawColumn("time", "s", seconds) if day is None else RawColumn("time", "", without_zone(day + seconds))
    time, lines = replace(time, source=source), [line for line, _ in own]
    if kind in READINGS:
        columns = (time, RawColumn(name or kind, "", np.array([numbers[1] for _, numbers in own])))
        return RawTable.of(path, columns, f"{len(own)} records", f"{kind} {device}", lines)
    fields = stated_fields("Hypack")[kind]
    values = {place: np.array([numbers[1 + int(place)] for _, numbers in own]) for place in fields}
    return table_of_fields(path, fields, values, time, f"{len(own)} records", f"{kind} {device}", lines)


def _day(begin: re.Match | None) -> float | None:
    """Seconds since 1970 of the day on which the file begins; None where the header states none."""
    if begin is None:
        return None
    try:
        date = datetime.datetime(int(begin["year"]), int(begin["month"]), int(begin["day"]), tzinfo=datetime.UTC)
    except ValueError:
        return None
    return date.timestamp()
