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

Fields = dict[str, tuple[str, str]]
_POSITION: Fields = {"lat": ("latitude", "1e-7 deg"), "lon": ("longitude", "1e-7 deg")}
_ATTITUDE: Fields = {
    "yaw": ("heading", "rad"), "yawspeed": ("yaw_rate", "rad/s"), "roll": ("roll", "rad"),
    "rollspeed": ("roll_rate", "rad/s"), "pitch": ("not used", "rad"), "pitchspeed": ("not used", "rad/s"),
}  # fmt: skip
MAVLINK: dict[str, Fields] = {
    "ATTITUDE": _ATTITUDE,
    "ATTITUDE_QUATERNION": {"yawspeed": ("yaw_rate", "rad/s"), "rollspeed": ("roll_rate", "rad/s")},
    "GLOBAL_POSITION_INT": _POSITION | {
        "vx": ("velocity_north", "cm/s"), "vy": ("velocity_east", "cm/s"), "vz": ("not used", "cm/s"),
        "alt": ("not used", "mm"), "relative_alt": ("not used", "mm"), "hdg": ("not used", "cdeg"),
    },
    "LOCAL_POSITION_NED": {
        "x": ("north", "m"), "y": ("east", "m"), "z": ("not used", "m"), "vx": ("velocity_north", "m/s"),
        "vy": ("velocity_east", "m/s"), "vz": ("not used", "m/s"),
    },
    "GPS_RAW_INT": _POSITION | {
        "vel": ("speed_over_ground", "cm/s"), "cog": ("course_over_ground", "cdeg"), "alt": ("not used", "mm"),
    },
    "VFR_HUD": {"groundspeed": ("speed_over_ground", "m/s"), "heading": ("not used", "deg")},
    "AHRS2": _POSITION | {"yaw": ("not used", "rad"), "roll": ("not used", "rad"), "pitch": ("not used", "rad")},
    "SERVO_OUTPUT_RAW": {f"servo{i}_raw": ("", "us") for i in range(1, 17)},
    "RC_CHANNELS": {f"chan{i}_raw": ("not used", "us") for i in range(1, 19)},
}  # fmt: skip
"""Message -> field -> (quantity, unit) by MAVLink's common set; NED, forward-right-down.  The heading in hundredths of
degrees of a position and that in whole degrees are the yaw again, which is finer."""
UBLOX: Fields = {
    "lat": ("latitude", "1e-7 deg"), "lon": ("longitude", "1e-7 deg"), "velN": ("velocity_north", "mm/s"),
    "velE": ("velocity_east", "mm/s"), "velD": ("not used", "mm/s"), "gSpeed": ("speed_over_ground", "mm/s"),
    "headMot": ("course_over_ground", "1e-5 deg"), "headVeh": ("not used", "1e-5 deg"), "hMSL": ("not used", "mm"),
    "height": ("not used", "mm"), "iTOW": ("not used", "ms"), "nano": ("not used", "ns"),
}  # fmt: skip
"""Field of NAV-PVT -> (quantity, unit)."""
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
    if table.sheet in MAVLINK:
        by, fields = f"MAVLink states it: {table.sheet}", MAVLINK[table.sheet]
        return [table.told(lambda c: _stated(c, fields, last_part(c.name), by))]
    names = {column.name for column in table.columns}
    if "iTOW" not in names or len(names & set(UBLOX)) <= 3:
        return [table]
    told = table.told(lambda c: _stated(c, UBLOX, c.name, "u-blox states it: NAV-PVT"), "units of u-blox NAV-PVT")
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
        by = f"{'ArduPilot' if kind in ARDUPILOT else 'MAVLink'} states it: {kind}"
        of_log = {name: (quantity, unit) for name, (_, quantity, unit) in ARDUPILOT.get(kind, {}).items()}
        fields = MAVLINK.get(kind, of_log)
        told = [_stated(c, fields, field, by) for c, field in own if field not in CLOCKS or not shared]
        done = (*table.done, f"{rows.size} messages {kind}")
        out.append(table.at(rows, (*shared, *told), sheet=kind, done=done))
    return faults_once(out) or [table]


def _stated(column: RawColumn, fields: Mapping[str, tuple[str, str]], field: str, by: str) -> RawColumn:
    """A column with the quantity and unit of its field, unless its header states another unit or its numbers do."""
    quantity, unit = fields.get(field, ("", ""))
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
