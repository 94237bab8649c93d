"""Logs of autopilots: ArduPilot dataflash, binary by pymavlink or as text, in which FMT lines name the fields of the
messages that follow, and PX4 (.ulg) by pyulog."""

from __future__ import annotations

import io
import re
from collections import defaultdict
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ....models.extras import extras_told
from ....models.temporary import temporary_folder
from ..cells import PLAIN
from ..headers import scaled_unit
from ..instruments import last_part
from ..moments import days_since_1970
from ..raw import RawColumn, RawTable, Rejected, faults_once, usable, with_faults
from .fields import StatedField, stated_fields, table_of_fields
from .object_tables import number_of
from .ros import yaw_and_roll

ARDUPILOT, PX4 = "ArduPilot", "PX4"
FORMAT = re.compile(r"FMT,\s*\d+,\s*\d+,\s*(?P<kind>\w{1,4}),\s*(?P<format>\w+)?,\s*(?P<names>.*)")
INSTANCE = ("I", "C")
"""Fields that number the sensor or the filter core of a message."""
FUNCTION = re.compile(r"SERVO(?P<output>\d{1,2})_FUNCTION")
STEERING = {21.0: "rudder", 26.0: "rudder"}
"""Function of an ArduPilot's output -> what the column of it is called: rudder, and ground steering."""
RECEIVERS, ATTITUDE = ("vehicle_gps_position", "sensor_gps"), "vehicle_attitude"
"""Topics of PX4 of its receivers, and of the quaternion of its attitude."""
MOST = 5_000_000
READS_A_BYTE = 10
"""A sound log needs less than one: two for a message, which has three bytes or more, in each of two passes."""
FIX, FIX_FIELDS = 3.0, ("Status", "fix_type")
"""Kind of a receiver's fix from which it has a position in the plane and its height, and its fields in both logs."""


def read_ardupilot(data: bytes, path: Path) -> list[RawTable]:
    """A table for every known kind of message; needs pymavlink."""
    with extras_told():
        from pymavlink.DFReader import DFReader_binary

    found: dict[str, list[dict[str, float]]] = defaultdict(list)
    parameters: dict[str, float] = {}
    fields = stated_fields(ARDUPILOT)
    with as_file(data, ".bin") as name:
        log = _advancing(DFReader_binary)(name, zero_time_base=False)
        for _ in range(MOST):
            message = log.recv_msg()
            if message is None:
                break
            kind = message.get_type()
            if kind in fields:
                held = {n: getattr(message, n, None) for n in (*fields[kind], *INSTANCE, "Status")}
                row = {n: float(value) for n, value in held.items() if isinstance(value, int | float)}
                found[instance(kind, row)].append({"TimeUS": float(message.TimeUS), **row})
            elif kind == "PARM":
                parameters[str(message.Name)] = float(message.Value)
        log.close()
    return ardupilot_tables(found, parameters, path)


def read_dataflash(text: str, path: Path) -> list[RawTable] | None:
    """A table for every known kind of message, None where the text begins as no dataflash log; BadInput where there is
    none."""
    first = [line for line in text[:4000].splitlines() if line.strip()][:10]
    if sum(FORMAT.match(line) is not None for line in first) < min(3, max(len(first) - 1, 1)):
        return None
    fields = stated_fields(ARDUPILOT)
    names: dict[str, list[str]] = {}
    rows: dict[str, list[dict[str, float]]] = defaultdict(list)
    faults: list[Rejected] = []
    parameters: dict[str, float] = {}
    count = 0
    for number, line in enumerate(text.splitlines(), start=1):
        if match := FORMAT.match(line):
            names[match["kind"]] = [name.strip() for name in match["names"].split(",")]
            continue
        kind, *cells = [cell.strip() for cell in line.split(",")]
        name = next((i for i, cell in enumerate(cells) if kind == "PARM" and re.match(r"[A-Z]", cell)), len(cells))
        if name + 1 < len(cells) and PLAIN.fullmatch(cells[name + 1]):
            parameters[cells[name]] = float(cells[name + 1])
        if kind not in fields or kind not in names:
            continue
        count += 1
        fits = len(cells) == len(names[kind])
        row = {name: number_of(cell) for name, cell in zip(names[kind], cells, strict=True)} if fits else {}
        if not np.isfinite(seconds(row)):
            faults.append((number, f"not the fields of {kind}", line))
        else:
            rows[instance(kind, row)].append(row)
    return with_faults(ardupilot_tables(rows, parameters, path), faults, count)


def ardupilot_tables(
    found: Mapping[str, Sequence[Mapping[str, float]]], parameters: Mapping[str, float], path: Path
) -> list[RawTable]:
    """A table for every known kind of message; outputs that steer, by the parameters SERVOn_FUNCTION, are called so.

    found : kind of message, as `instance` has it -> field -> number, of each message.

    Raises
    ------
    BadInput : no field of the messages is known.
    """
    tables = []
    for kind, own in found.items():
        if len(own) > 2:
            names = dict.fromkeys(name for row in own for name in row)  # a log may state a message anew
            values = {name: np.array([row.get(name, np.nan) for row in own]) for name in names}
            times = np.array([seconds(row) for row in own])
            tables.append(_table(path, kind, times, values, ARDUPILOT, kind.split(" ")[0]))
    steer = {f"output {match['output']}": STEERING[value] for name, value in parameters.items()
             if (match := FUNCTION.fullmatch(name)) and value in STEERING}  # fmt: skip
    made = usable(tables, path, "no message of the log can be used", f"read are {', '.join(stated_fields(ARDUPILOT))}")
    return [table.told(lambda c: replace(c, called=steer.get(c.name, c.called))) for table in made]


def instance(kind: str, row: Mapping[str, float]) -> str:
    """The kind of a message, with a number behind it for the second and later sensors."""
    number = next((row[name] for name in INSTANCE if name in row), 0.0)
    return f"{kind} {number:g}" if number else kind


def seconds(row: Mapping[str, float]) -> float:
    """Time of a message, s since boot."""
    return 1e-6 * row["TimeUS"] if "TimeUS" in row else 1e-3 * row.get("TimeMS", float("nan"))


@contextmanager
def as_file(data: bytes, suffix: str) -> Generator[str]:
    """The path of a copy of data, for a library that reads files only."""
    with temporary_folder() as folder:
        copy = folder / f"log{suffix}"
        copy.write_bytes(data)
        yield str(copy)


def _advancing(reader: Any) -> Any:
    """pymavlink's reader, which would read a message of no length without end; ValueError at one."""

    class Advancing(reader):
        def recv_msg(self) -> Any:
            before, message = self.offset, super().recv_msg()
            if message is not None and self.offset <= before:
                raise ValueError("a message of no length")
            return message

    return Advancing


class _Counted(io.BytesIO):
    """A log that is read no more often than it has bytes for: pyulog goes back and forth at a cut end without end."""

    def __init__(self, data: bytes) -> None:
        super().__init__(data)
        self._left = READS_A_BYTE * len(data)

    def read(self, size: int | None = -1, /) -> bytes:
        self._left -= 1
        if self._left < 0:
            raise OSError("read without end")
        return super().read(size)


def read_px4(data: bytes, path: Path) -> list[RawTable]:
    """A table for every known topic; needs pyulog."""
    with extras_told():
        from pyulog import ULog

    tables = []
    for topic in ULog(_Counted(data), [*stated_fields(PX4)]).data_list:
        values = {name: np.asarray(numbers, dtype=float) for name, numbers in topic.data.items()}
        name = topic.name + (f" {topic.multi_id}" if topic.multi_id else "")
        times = values["timestamp"] * 1e-6
        if topic.name == ATTITUDE and all(f"q[{i}]" in values for i in range(4)):
            values = dict(zip(("yaw", "roll"), yaw_and_roll(*(values[f"q[{i}]"] for i in range(4))), strict=True))
        tables.append(_table(path, name, times, values, PX4, topic.name))
    return usable(tables, path, "no message of the log can be used")


def with_px4(table: RawTable) -> RawTable:
    """A CSV file of a topic of PX4, called by it as pyulog writes it, with the units and axes of the topic."""
    topics = [name for name in stated_fields(PX4) if name not in RECEIVERS]
    topic = next((name for name in topics if re.search(rf"(^|_){name}_\d+\.csv$", table.file)), None)
    stamp = table.column("timestamp")
    if topic is None or stamp is None:
        return table
    fields = stated_fields(PX4)[topic] | {stamp.name: StatedField("", "time", "us")}

    def told(c: RawColumn) -> RawColumn:
        if c.name in fields:
            return replace(c, known=fields[c.name].quantity, unit=fields[c.name].unit, source="PX4's log states it")
        return replace(c, said=(*c.said, "clockwise from north (NED)")) if c.called == "yaw" else c

    return table.told(told, f"PX4, topic {topic}")


def _table(
    path: Path, kind: str, times: np.ndarray, values: dict[str, np.ndarray], program: str, message: str
) -> RawTable | None:
    """The table of a message; what a receiver gives while it has no fix is no measurement."""
    fix = next((values[name] for name in FIX_FIELDS if name in values), np.full(times.size, FIX))
    values = {name: np.where(fix < FIX, np.nan, own) for name, own in values.items()}
    time = RawColumn("time since boot", "s", times, "time", f"{program}'s log states it")
    return table_of_fields(
        path, stated_fields(program).get(message, {}), values, time, f"{times.size} messages {kind}", kind
    )


# ---- Columns that are fields of known messages: of MAVLink as MESSAGE.field, of u-blox receivers by their names.

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
    found = [table.column(name) for name in (*DATE, "nano")]
    parts = [column.numbers for column in found if column is not None and column.numeric]
    if len(parts) < len(found) or not all(np.isfinite(part).all() and np.abs(part).max() < 2e9 for part in parts):
        return [told]
    year, month, day, hour, minute, second, nano = parts
    moments = 86400.0 * days_since_1970(year, month, day) + 3600.0 * hour + 60.0 * minute + second + 1e-9 * nano
    made = RawColumn("UTC", "s", moments, "time", "u-blox states it: NAV-PVT")
    return [replace(told, columns=(made, *(c for c in told.columns if c.name not in DATE)))]


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
