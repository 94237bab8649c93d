"""Logs of autopilots: ArduPilot dataflash (.bin) by pymavlink, PX4 (.ulg) by pyulog."""

from __future__ import annotations

import io
import re
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..raw import RawColumn, RawTable, usable
from .extras import as_file, needed
from .ros import yaw_and_roll

Fields = dict[str, tuple[str, str, str]]
ARDUPILOT: dict[str, Fields] = {
    "ATT": {"Yaw": ("yaw", "heading", "deg"), "Roll": ("roll", "roll", "deg")},
    "GPS": {"Lat": ("latitude", "latitude", "deg"), "Lng": ("longitude", "longitude", "deg"),
            "Spd": ("speed over ground", "speed_over_ground", "m/s"),
            "GCrs": ("course over ground", "course_over_ground", "deg")},
    "IMU": {"GyrZ": ("yaw rate of the gyro", "yaw_rate", "rad/s")},
    "XKF1": {"VN": ("velocity north", "velocity_north", "m/s"), "VE": ("velocity east", "velocity_east", "m/s")},
    "RCOU": {f"C{i}": (f"output {i}", "", "us") for i in range(1, 9)},
}  # fmt: skip
PX4: dict[str, Fields] = {
    "vehicle_local_position": {
        "x": ("north", "north", "m"), "y": ("east", "east", "m"), "vx": ("velocity north", "velocity_north", "m/s"),
        "vy": ("velocity east", "velocity_east", "m/s"), "heading": ("heading", "heading", "rad"),
    },
    "vehicle_angular_velocity": {
        "xyz[2]": ("yaw rate", "yaw_rate", "rad/s"), "xyz[0]": ("roll rate", "roll_rate", "rad/s"),
    },
    "actuator_outputs": {f"output[{i}]": (f"output {i}", "", "us") for i in range(8)},
    "actuator_motors": {f"control[{i}]": (f"motor {i}", "", "") for i in range(4)},
    "actuator_servos": {f"control[{i}]": (f"servo {i}", "", "") for i in range(4)},
}  # fmt: skip
"""Message -> field -> (name, quantity that the format states, unit): SI or degrees, NED, forward-right-down."""
INSTANCE = ("I", "C")
"""Fields that number the sensor or the filter core of a message."""
FUNCTION = re.compile(r"SERVO(?P<output>\d{1,2})_FUNCTION")
STEERING = {21.0: "rudder", 26.0: "rudder"}
"""Function of an ArduPilot's output -> what the column of it is called: rudder, and ground steering."""
PX4_TOPICS = (*PX4, "vehicle_attitude")
PX4_RECEIVERS = ("vehicle_gps_position", "sensor_gps")
PX4_RECEIVER: Fields = {
    "lat": ("latitude", "latitude", "1e-7 deg"), "lon": ("longitude", "longitude", "1e-7 deg"),
    "latitude_deg": ("latitude", "latitude", "deg"), "longitude_deg": ("longitude", "longitude", "deg"),
}  # fmt: skip
"""Fields of their topics; positions of older logs are whole numbers of 1e-7 degrees."""
MOST = 5_000_000
READS_A_BYTE = 10
"""A sound log needs less than one: two for a message, which has three bytes or more, in each of two passes."""
FIX = 3.0
"""Kind of a receiver's fix, in both logs, from which it has a position in the plane and its height."""


def read_ardupilot(data: bytes, path: Path) -> list[RawTable]:
    """A table for every known kind of message; needs pymavlink."""
    module = needed("pymavlink.DFReader", "pymavlink", "an ArduPilot log", path)
    found: dict[str, list[dict[str, float]]] = defaultdict(list)
    parameters: dict[str, float] = {}
    with as_file(data, ".bin") as name:
        log = _advancing(module.DFReader_binary)(name, zero_time_base=False)
        for _ in range(MOST):
            message = log.recv_msg()
            if message is None:
                break
            kind = message.get_type()
            if kind in ARDUPILOT:
                held = {n: getattr(message, n, None) for n in (*ARDUPILOT[kind], *INSTANCE, "Status")}
                row = {n: float(value) for n, value in held.items() if isinstance(value, int | float)}
                found[instance(kind, row)].append({"TimeUS": float(message.TimeUS), **row})
            elif kind == "PARM":
                parameters[str(message.Name)] = float(message.Value)
        log.close()
    return ardupilot_tables(found, parameters, path)


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
    made = usable(tables, path, "no message of the log can be used", f"read are {', '.join(ARDUPILOT)}")
    return [table.told(lambda c: replace(c, called=steer.get(c.name, c.called))) for table in made]


def _ardupilot_table(path: Path, kind: str, own: Sequence[Mapping[str, float]]) -> RawTable | None:
    names = dict.fromkeys(name for row in own for name in row)  # a log may state a message anew
    values = {name: np.array([row.get(name, np.nan) for row in own]) for name in names}
    times = np.array([seconds(row) for row in own])
    if kind.startswith("GPS"):
        values = _with_fix(values, values.get("Status", np.full(times.size, FIX)))
    return _table(path, kind, times, values, ARDUPILOT[kind.split(" ")[0]], "ArduPilot's log states it")


def instance(kind: str, row: Mapping[str, float]) -> str:
    """The kind of a message, with a number behind it for the second and later sensors."""
    number = next((row[name] for name in INSTANCE if name in row), 0.0)
    return f"{kind} {number:g}" if number else kind


def seconds(row: Mapping[str, float]) -> float:
    """Time of a message, s since boot."""
    return 1e-6 * row["TimeUS"] if "TimeUS" in row else 1e-3 * row.get("TimeMS", float("nan"))


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
    module = needed("pyulog", "pyulog", "a PX4 log", path)
    topics = module.ULog(_Counted(data), [*PX4_TOPICS, *PX4_RECEIVERS]).data_list
    return usable((_topic(path, topic) for topic in topics), path, "no message of the log can be used")


def _topic(path: Path, topic: Any) -> RawTable | None:
    values = {name: np.asarray(numbers, dtype=float) for name, numbers in topic.data.items()}
    name = topic.name + (f" {topic.multi_id}" if topic.multi_id else "")
    times, by = values["timestamp"] * 1e-6, "PX4's log states it"
    if topic.name == "vehicle_attitude" and all(f"q[{i}]" in values for i in range(4)):
        yaw, roll = yaw_and_roll(*(values[f"q[{i}]"] for i in range(4)))
        fields = {"yaw": ("heading", "heading", "rad"), "roll": ("roll", "roll", "rad")}
        return _table(path, name, times, {"yaw": yaw, "roll": roll}, fields, by)
    if topic.name in PX4_RECEIVERS:
        values = _with_fix(values, values.get("fix_type", np.full(times.size, FIX)))
        return _table(path, name, times, values, PX4_RECEIVER, by)
    return _table(path, name, times, values, PX4.get(topic.name, {}), by)


def with_px4(table: RawTable) -> RawTable:
    """A CSV file of a topic of PX4, called by it as pyulog writes it, with the units and axes of the topic."""
    topic = next((name for name in PX4_TOPICS if re.search(rf"(^|_){name}_\d+\.csv$", table.file)), None)
    stamp = table.column("timestamp")
    if topic is None or stamp is None:
        return table
    fields = PX4.get(topic, {}) | {stamp.name: ("", "time", "us")}

    def told(c: RawColumn) -> RawColumn:
        if c.name in fields:
            _, quantity, unit = fields[c.name]
            return replace(c, known=quantity, unit=unit, source="PX4's log states it")
        return replace(c, said=(*c.said, "clockwise from north (NED)")) if c.called == "yaw" else c

    return table.told(told, f"PX4, topic {topic}")


def _with_fix(values: dict[str, np.ndarray], fix: np.ndarray) -> dict[str, np.ndarray]:
    """What a receiver gives while it has no fix is no measurement."""
    return {name: np.where(fix < FIX, np.nan, own) for name, own in values.items()}


def _table(
    path: Path, kind: str, times: np.ndarray, values: dict[str, np.ndarray], fields: Fields, by: str
) -> RawTable | None:
    columns = [RawColumn("time since boot", "s", times, "time", by)]
    for field, (name, quantity, unit) in fields.items():
        if field in values and np.isfinite(values[field]).any():
            columns.append(RawColumn(name, unit, values[field], quantity, by))
    return RawTable.of(path, columns, f"{times.size} messages {kind}", kind) if len(columns) > 1 else None
