"""ROS messages in columns: stamps in two parts, quaternions, frames; of CSV files of a topic, and of bags."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ....models.errors import BadInput
from ....models.extras import extras_told
from ..raw import RawColumn, RawTable, usable
from .fields import StatedField, stated_fields

QUATERNION = re.compile(
    r"(?P<prefix>.*?(?:orientation|quaternion|quat|rotation|\bq))(?:[._]?(?P<part>[xyzw0-3])|\[(?P<index>[0-3])\])$",
    re.IGNORECASE,
)
JOINT = re.compile(r"(?:.*[./])?(?P<field>name|position)\[?(?P<number>\d+)\]?", re.IGNORECASE)
SECONDS = re.compile(r"(?P<prefix>.*?(?:stamp|time))[._]?(?:secs?|seconds)$", re.IGNORECASE)
NANOSECONDS = re.compile(r"(?P<prefix>.*?(?:stamp|time))[._]?(?:nsecs?|nanosecs?|nanoseconds)$", re.IGNORECASE)
DOWN, UP = (
    re.compile(r"(^|[_/])(ned|frd)($|[_/])", re.IGNORECASE),
    re.compile(r"(^|[_/])(enu|flu)($|[_/])", re.IGNORECASE),
)
ABOUT_Z = ("yaw rate", "velocity y")
MOST_FIELDS, MOST_MESSAGES, LONGEST_ARRAY = 120, 2_000_000, 32


def with_ros(table: RawTable) -> RawTable:
    """A table with its ROS fields told: units by their messages, signs by the frame, yaw of a quaternion, one stamp."""
    joints = {  # of a JointState, rad, `position[0]` beside `name[0]`
        match["number"]: re.sub(r"[_ ]?joint$", "", column.first(1)[0])
        for column in table.columns
        if (match := JOINT.fullmatch(column.name)) and match["field"] == "name" and column.first(1)
    }
    by = "its ROS message states rad"
    table = table.told(
        lambda c: (
            replace(c, called=joints[match["number"]], unit=c.unit or "rad", source=by)
            if (match := JOINT.fullmatch(c.name)) and match["field"] == "position" and match["number"] in joints
            else c
        )
    )
    paths = [re.sub(r"^(field|data)\.", "", column.name.strip("/").replace("/", ".")) for column in table.columns]
    turned = _quaternion(table.columns, paths)
    stamped = _stamp(table.columns, paths)
    known = stated_fields("ROS")["field"].items()
    fields = [next((f for form, f in known if re.search(form, path, re.IGNORECASE)), None) for path in paths]
    if (
        turned is None
        and stamped is None
        and not any("." in path and field for path, field in zip(paths, fields, strict=True))
    ):
        return table
    # the frames of the pose and of the rates: of an odometry those of the header and of the child (nav_msgs), else one
    named = {
        wanted: column.first(1)[0]
        for wanted in ("child_frame_id", "frame_id")
        for column, path in zip(table.columns, paths, strict=True)
        if re.search(rf"(?<!child_){wanted}$", path.lower()) and column.texts is not None and column.first(1)
    }
    fixed = named.get("frame_id", named.get("child_frame_id", ""))
    frame = named.get("child_frame_id", fixed)
    told = zip(table.columns, fields, strict=True)
    columns = [_told(c, f, fixed if f and f.name.startswith("position") else frame, paths) for c, f in told]
    status = next((c for c, p in zip(columns, paths, strict=True) if p.lower().endswith("status.status")), None)
    if status is not None and status.numeric:  # positions of NavSatFix messages without a fix are gaps
        lost = status.numbers < 0.0
        columns = [
            replace(c, values=np.where(lost, np.nan, c.numbers)) if c.called in ("latitude", "longitude") else c
            for c in columns
        ]
    yaw = {"down": "clockwise from north (NED)", "up": "counterclockwise from east (ENU)"}.get(_axis(fixed))
    for made in (stamped, turned):
        if made is not None:
            parts, extra = made
            columns = [
                replace(c, known="not used", source=f"part of {extra[0].name}") if i in parts else c
                for i, c in enumerate(columns)
            ]
            columns += [replace(c, said=(*c.said, yaw)) if c.called == "yaw" and yaw else c for c in extra]
    said = "; ".join(
        f"frame {one}: z points {_axis(one)}" if _axis(one) else f"frame {one or 'unknown'}: its axes are not stated"
        for one in dict.fromkeys((fixed, frame))
    )
    return replace(table, columns=tuple(columns), done=(*table.done, f"ROS messages; {said}"))


def _axis(frame: str) -> str:
    return "down" if DOWN.search(frame) else "up" if UP.search(frame) else ""


def _told(column: RawColumn, field: StatedField | None, frame: str, paths: Sequence[str]) -> RawColumn:
    if field is None or column.unit:
        return column
    name, _, unit = field
    body = any(path.endswith("child_frame_id") for path in paths)
    if name.startswith("velocity") and body:
        name = "surge" if name.endswith("x") else "sway"
    said = ("positive to starboard",) if name == "roll rate" and _axis(frame) else ()
    if name in (*ABOUT_Z, "sway") and _axis(frame):
        said = ("positive to starboard",) if _axis(frame) == "down" else ("positive to port",)
    if name.startswith("position") and _axis(frame):
        ned = _axis(frame) == "down"
        name = ("north" if ned else "east") if name.endswith("x") else ("east" if ned else "north")
    by = f"its ROS message states {unit}"
    return replace(column, unit=unit, called=name, said=(*column.said, *said), source=by)


def _quaternion(columns: Sequence[RawColumn], paths: Sequence[str]) -> tuple[set[int], list[RawColumn]] | None:
    """(columns of the parts, yaw and roll) of the first quaternion; None where there is none."""
    parts: dict[str, dict[str, int]] = {}
    for i, path in enumerate(paths):
        if (match := QUATERNION.fullmatch(path)) and columns[i].numeric:
            parts.setdefault(match["prefix"], {})[(match["part"] or match["index"]).lower()] = i
    named = ((prefix, _axes(columns, own)) for prefix, own in parts.items() if len(own) == 4)
    whole = next(((prefix, own) for prefix, own in named if own), None)
    if whole is None:
        return None
    prefix, own = whole
    x, y, z, w = (columns[own[axis]].numbers for axis in "xyzw")
    yaw, roll = yaw_and_roll(w, x, y, z)
    by = f"by the quaternion {prefix}"
    made = [
        RawColumn(f"yaw of {prefix}", "rad", yaw, source=by, called="yaw"),
        RawColumn(f"roll of {prefix}", "rad", roll, source=by, called="roll", said=("positive to starboard",)),
    ]
    return set(own.values()), made


def _axes(columns: Sequence[RawColumn], own: Mapping[str, int]) -> Mapping[str, int]:
    """Axis -> column of the parts of a quaternion; nothing where numbered ones are none.

    Of a ship that hardly rolls, x and y are the small ones.
    """
    if not set(own) <= set("0123"):
        return own if set(own) == set("xyzw") else {}
    sizes = [float(np.nanmean(columns[own[k]].numbers ** 2)) for k in sorted(own)]
    axes = "wxyz" if sizes[1] + sizes[2] < sizes[0] + sizes[1] else "xyzw"
    return {axis: own[k] for axis, k in zip(axes, sorted(own), strict=True)} if abs(sum(sizes) - 1.0) < 0.1 else {}


def yaw_and_roll(w: np.ndarray, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Angles (N,), rad, about z and x of a rotation from the fixed frame's axes to the body's, in the order z, y, x.

    Diebel 2006, Representing Attitude, eq 290.
    """
    size = w * w + x * x + y * y + z * z
    with np.errstate(invalid="ignore", divide="ignore"):
        yaw = np.arctan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)
        roll = np.arctan2(2.0 * (w * x + y * z), w * w - x * x - y * y + z * z)
    sound = np.isfinite(size) & (np.abs(size - 1.0) < 0.1)
    return np.where(sound, yaw, np.nan), np.where(sound, roll, np.nan)


def _stamp(columns: Sequence[RawColumn], paths: Sequence[str]) -> tuple[set[int], list[RawColumn]] | None:
    """(columns of the parts, seconds since 1970) of a stamp in seconds and nanoseconds."""
    for i, path in enumerate(paths):
        match = SECONDS.fullmatch(path)
        for j, other in enumerate(paths):
            small = NANOSECONDS.fullmatch(other) if match else None
            if match and small and small["prefix"] == match["prefix"]:
                seconds = columns[i].numbers + 1e-9 * columns[j].numbers
                made = RawColumn(f"{match['prefix']} in seconds", "s", seconds, "time", "ROS stamp")
                return {i, j}, [made]
    return None


def read_bag(path: Path) -> list[RawTable]:
    """A table for every topic of a ROS 1 or ROS 2 bag with numbers; needs rosbags."""
    with extras_told():
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    with AnyReader([path], default_typestore=store) as bag:
        tables = [_topic(bag, connection, path) for connection in bag.connections]
    return [with_ros(table) for table in usable(tables, path, "no topic of the bag holds numbers")]


def _topic(bag: Any, connection: Any, path: Path) -> RawTable | None:
    rows: list[dict[str, Any]] = []
    stamps: list[float] = []
    for number, (_, stamp, raw) in enumerate(bag.messages([connection])):
        if number >= MOST_MESSAGES:
            raise BadInput(f"topic {connection.topic} has more than {MOST_MESSAGES} messages", file=path)
        row = dict(_flat(bag.deserialize(raw, connection.msgtype)))
        if not row or len(row) > MOST_FIELDS:
            return None
        rows.append(row)
        stamps.append(stamp * 1e-9)
    if len(rows) < 3:
        return None
    names = list(rows[0])
    known = "" if any(map(SECONDS.fullmatch, names)) else "time"
    columns = [RawColumn("time of the bag", "s", np.array(stamps), known, "the bag's clock")]
    for name in names:
        values = [row.get(name) for row in rows]
        if all(isinstance(value, str) for value in values):
            cells: Any = tuple(values)
        else:
            cells = np.array([np.nan if isinstance(v, str) or v is None else float(v) for v in values])
        columns.append(RawColumn(name, "", cells))
    return RawTable.of(path, columns, f"{len(rows)} messages {connection.msgtype}", connection.topic.strip("/"))


def _flat(message: Any, prefix: str = "", depth: int = 0) -> list[tuple[str, Any]]:
    """(path, number or text) of the fields of a message; arrays only up to `LONGEST_ARRAY` numbers."""
    out: list[tuple[str, Any]] = []
    for name in getattr(message, "__dataclass_fields__", ()):
        if name.startswith("__") or "covariance" in name:
            continue
        value, path = getattr(message, name), f"{prefix}{name}"
        if isinstance(value, bool | int | float | str | np.number):
            out.append((path, value))
        elif isinstance(value, list | tuple | np.ndarray):
            if 0 < len(value) <= LONGEST_ARRAY and all(isinstance(one, int | float | str | np.number) for one in value):
                out += [(f"{path}[{i}]", one) for i, one in enumerate(value)]
        elif depth < 6:
            out += _flat(value, f"{path}.", depth + 1)
    return out
