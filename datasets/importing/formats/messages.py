"""Columns that are fields of known messages: of MAVLink as MESSAGE.field, of u-blox receivers by their names."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..headers import scaled_unit
from ..instruments import last_part
from ..moments import days_since_1970
from ..raw import RawColumn, RawTable, faults_once
from .autopilots import ARDUPILOT
from .fields import StatedField, stated_fields

MAVLINK = "MAVLink"
DATE = ("year", "month", "day", "hour", "min", "sec")
CLOCKS = ("time_boot_ms", "time_usec", "time_unix_usec")
COLUMN = re.compile(r"(?:mavlink_)?(?P<message>[A-Z][A-Z0-9_]+?)(?:_t)?(?:\[\d+\])?\.(?P<field>\w+)")
WHOLE = {"1e-7 deg": 1.8e9, "1e-5 deg": 3.6e7, "cdeg": 36000.0, "cm/s": 1e4, "mm/s": 1e5}
"""Unit of whole numbers -> their largest size: a program that writes other numbers has changed the units."""


def with_messages(table: RawTable) -> list[RawTable]:
    """The tables of a table: with the units that MAVLink or u-blox states, one for every message of MAVLink."""
    matches = [COLUMN.fullmatch(column.name) for column in table.columns]
    if any(match is not None for match in matches):
        return _by_message(table, matches)
    if table.sheet in stated_fields(MAVLINK):
        by, fields = f"MAVLink states it: {table.sheet}", stated_fields(MAVLINK)[table.sheet]
        return [table.told(lambda c: _stated(c, fields, last_part(c.name), by))]
    names = {column.name for column in table.columns}
    fields = stated_fields("u-blox")["NAV-PVT"]
    if "iTOW" not in names or len(names & set(fields)) <= 3:
        return [table]
    told = table.told(lambda c: _stated(c, fields, c.name, "u-blox states it: NAV-PVT"), "units of u-blox NAV-PVT")
    made = _moments(table)
    return [replace(told, columns=(made, *(c for c in told.columns if c.name not in DATE))) if made else told]


def _moments(table: RawTable) -> RawColumn | None:
    """The UTC of NAV-PVT, of the columns of its parts; None where these are not whole."""
    found = [table.column(name) for name in (*DATE, "nano")]
    parts = [column.numbers for column in found if column is not None and column.numeric]
    if len(parts) < len(found) or not all(np.isfinite(part).all() and np.abs(part).max() < 2e9 for part in parts):
        return None
    year, month, day, hour, minute, second, nano = parts
    seconds = 86400.0 * days_since_1970(year, month, day) + 3600.0 * hour + 60.0 * minute + second + 1e-9 * nano
    return RawColumn("UTC", "s", seconds, "time", "u-blox states it: NAV-PVT")


def _by_message(table: RawTable, matches: list[re.Match[str] | None]) -> list[RawTable]:
    """A table for every message, of the rows that hold it, with the columns that are of no message."""
    pairs = list(zip(table.columns, matches, strict=True))
    shared = [column for column, match in pairs if match is None]
    kinds = dict.fromkeys(match["message"] for _, match in pairs if match is not None)
    out = []
    for kind in kinds:
        own = [(column, match["field"]) for column, match in pairs if match is not None and match["message"] == kind]
        rows = np.flatnonzero(np.any([np.isfinite(column.numbers) for column, _ in own], axis=0))
        if rows.size < 3:
            continue
        program = ARDUPILOT if kind in stated_fields(ARDUPILOT) else MAVLINK
        by, fields = f"{program} states it: {kind}", stated_fields(program).get(kind, {})
        told = [_stated(c, fields, field, by) for c, field in own if field not in CLOCKS or not shared]
        done = (*table.done, f"{rows.size} messages {kind}")
        out.append(table.at(rows, (*shared, *told), sheet=kind, done=done))
    return faults_once(out) or [table]


def _stated(column: RawColumn, fields: Mapping[str, StatedField], field: str, by: str) -> RawColumn:
    """A column with the quantity and unit of its field, unless its header states another unit or its numbers do."""
    _, quantity, unit = fields.get(field, ("", "", ""))
    column = replace(column, called=field) if field != column.name else column
    known = column.finite
    if not unit or not known.size or (column.unit and scaled_unit(column.unit) != scaled_unit(unit)):
        return column
    whole = np.array_equal(known, np.round(known)) and np.abs(known).max() <= WHOLE.get(unit, np.inf)
    if unit in WHOLE and not whole:
        return column
    base, factor = scaled_unit(unit)
    if base is None or factor == 1.0:
        return replace(column, unit=unit, known=quantity, source=by)
    return replace(column, unit=base.name, values=factor * column.numbers, known=quantity, source=by)
