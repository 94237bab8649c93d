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
from ..raw import RawColumn, RawTable, Rejected, usable, with_faults
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
        if kind == "PARM" and (value := _parameter(cells)):
            parameters |= value
        if kind not in fields or kind not in names:
            continue
        count += 1
        row = _row(names[kind], cells)
        if row is None:
            faults.append((number, f"not the fields of {kind}", line))
        else:
            rows[instance(kind, row)].append(row)
    return with_faults(ardupilot_tables(rows, parameters, path), faults, count)


def _parameter(cells: list[str]) -> dict[str, float]:
    """Name and value of a parameter, wherever they stand in its line; nothing where they do not."""
    name = next((i for i, cell in enumerate(cells) if re.match(r"[A-Z]", cell)), len(cells))
    return {cells[name]: float(cells[name + 1])} if name + 1 < len(cells) and PLAIN.fullmatch(cells[name + 1]) else {}


def _row(names: list[str], cells: list[str]) -> dict[str, float] | None:
    """Field -> number of a message; None where it has other fields or no time."""
    if len(cells) != len(names):
        return None
    row = {name: number_of(cell) for name, cell in zip(names, cells, strict=True)}
    return row if np.isfinite(seconds(row)) else None


def ardupilot_tables(
    found: Mapping[str, Sequence[Mapping[str, float]]], parameters: Mapping[str, float], path: Path
) -> list[RawTable]:
    """A table for every known kind of message; outputs that steer, by the parameters SERVOn_FUNCTION, are called so.

    found : kind of message, as `instance` has it -> field -> number, of each message.

    Raises
    ------
    BadInput : no field of the messages is known.
    """
    tables = (_ardupilot_table(path, kind, own) for kind, own in found.items() if len(own) > 2)
    steer = {f"output {match['output']}": STEERING[value] for name, value in parameters.items()
             if (match := FUNCTION.fullmatch(name)) and value in STEERING}  # fmt: skip
    made = usable(tables, path, "no message of the log can be used", f"read are {', '.join(stated_fields(ARDUPILOT))}")
    return [table.told(lambda c: replace(c, called=steer.get(c.name, c.called))) for table in made]


def _ardupilot_table(path: Path, kind: str, own: Sequence[Mapping[str, float]]) -> RawTable | None:
    names = dict.fromkeys(name for row in own for name in row)  # a log may state a message anew
    values = {name: np.array([row.get(name, np.nan) for row in own]) for name in names}
    times = np.array([seconds(row) for row in own])
    return _table(path, kind, times, values, ARDUPILOT, kind.split(" ")[0])


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

    topics = ULog(_Counted(data), [*stated_fields(PX4)]).data_list
    return usable((_topic(path, topic) for topic in topics), path, "no message of the log can be used")


def _topic(path: Path, topic: Any) -> RawTable | None:
    values = {name: np.asarray(numbers, dtype=float) for name, numbers in topic.data.items()}
    name = topic.name + (f" {topic.multi_id}" if topic.multi_id else "")
    times = values["timestamp"] * 1e-6
    if topic.name == ATTITUDE and all(f"q[{i}]" in values for i in range(4)):
        values = dict(zip(("yaw", "roll"), yaw_and_roll(*(values[f"q[{i}]"] for i in range(4))), strict=True))
    return _table(path, name, times, values, PX4, topic.name)


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
