"""NMEA 2000 as text: candump, YDVR and Actisense lines by the package nmea2000, and canboat's JSON."""

from __future__ import annotations

import datetime
import json
import re
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ....models.extras import extras_told
from ..moments import moment
from ..raw import RawColumn, RawTable, Rejected, usable, with_faults
from .fields import stated_fields, table_of_fields
from .object_tables import number_of

CANDUMP = re.compile(r"\s*\(\d+\.\d+\)\s+\S+\s+[0-9A-F]{8}(#|\s+\[\d\])")
SPACED = re.compile(r"\s*(\(\d+\.\d+\))\s+(\S+)\s+([0-9A-F]{8})\s+\[\d\]\s+((?:[0-9A-F]{2}\s*)+)$")
"""A frame as candump prints it on a terminal: its length in brackets, its bytes apart."""
YDVR = re.compile(r"\d\d:\d\d:\d\d\.\d{3}\s+[RT]\s+[0-9A-F]{8}(\s+[0-9A-F]{2})+", re.IGNORECASE)
PLAIN = re.compile(r"\d{4}-\d\d-\d\d[T-]\d\d:\d\d:\d\d\.\d+Z?,\d+,\d{5,6},\d+,\d+,\d+(,[0-9a-f]{2})+", re.IGNORECASE)
ACTISENSE = re.compile(r"A(\d\d)(\d\d)(\d\d\.\d{3}) [0-9A-F]{5} [0-9A-F]{5} [0-9A-F]+\s*$")
"""A message of Actisense's NMEA 2000 ASCII; its clock is a time of day."""
JSON_LINE = re.compile(r"\s*\{(?=.*\"fields\").*\"pgn\"\s*:\s*\"?\d+.*\}\s*,?\s*$")
DIRECTIONS = ("heading", "cog")
FULL_TURN = 6.2833
"""rad; a little more, for the rounding of a log."""
IN_DEGREES = {"rad": "deg", "rad/s": "deg/s"}


def read_n2k(text: str, path: Path) -> list[RawTable] | None:
    """A table for every PGN of every source that is known; None where most of the first lines are no messages.

    Raises
    ------
    BadInput : the package nmea2000 is missing, or no message is known.
    """
    first = [line for line in text[:20000].splitlines()[:100] if line.strip()][:-1]
    kinds = (CANDUMP, YDVR, PLAIN, ACTISENSE, JSON_LINE)
    if len(first) < 3 or sum(any(kind.match(line) for kind in kinds) for line in first) <= 0.8 * len(first):
        return None
    json_lines = JSON_LINE.match(next((line for line in text.splitlines() if '"pgn"' in line), "")) is not None
    messages, faults = (_from_json if json_lines else _decoded)(text, path)
    groups: dict[tuple[int, int, str], list[tuple[int, float, dict[str, Any]]]] = defaultdict(list)
    for line, pgn, source, time, fields in messages:
        # the number of the rudder or engine that a message is of, where it states one
        found = [value for name, value in fields.items() if name.endswith("instance") and value is not None]
        groups[pgn, source, (str(found[0]) if found else "")].append((line, time, fields))
    degrees = json_lines and not _in_radians(text[:400].replace(" ", ""), messages)
    dated = not any(YDVR.match(line) or ACTISENSE.match(line) for line in text.splitlines()[:20])
    made = (_table(path, key, own, degrees, dated) for key, own in groups.items())
    tables = usable(made, path, "no message of NMEA 2000 that can be used")
    return with_faults(tables, faults, len(messages) + len(faults))


def _decoded(text: str, path: Path) -> tuple[list[tuple[int, int, int, float, dict[str, Any]]], list[Rejected]]:
    with extras_told():
        from nmea2000 import NMEA2000Decoder

    decoder = NMEA2000Decoder()
    known = stated_fields("NMEA 2000")
    out: list[tuple[int, int, int, float, dict[str, Any]]] = []
    faults: list[Rejected] = []
    for number, line in enumerate(text.splitlines(), start=1):
        if not line.strip():
            continue
        try:
            frame = SPACED.match(line.strip())
            compact = f"{frame[1]} {frame[2]} {frame[3]}#{''.join(frame[4].split())}" if frame else line.strip()
            message = decoder.decode(compact)
        except Exception:  # whatever the package raises on a damaged line
            faults.append((number, "no message of NMEA 2000", line))
            continue
        if message is not None and str(message.PGN) in known:
            fields = {re.sub(r"\W|_", "", field.id).lower(): field.value for field in message.fields}
            clock = ACTISENSE.match(line.strip())
            stamp = message.timestamp.replace(tzinfo=datetime.UTC).timestamp()
            stamp = 3600.0 * int(clock[1]) + 60.0 * int(clock[2]) + float(clock[3]) if clock else stamp
            out.append((number, message.PGN, message.source, stamp, fields))
    return out, faults


def _from_json(text: str, path: Path) -> tuple[list[tuple[int, int, int, float, dict[str, Any]]], list[Rejected]]:
    out: list[tuple[int, int, int, float, dict[str, Any]]] = []
    faults: list[Rejected] = []
    for number, line in enumerate(text.splitlines(), start=1):
        if '"pgn"' not in line:
            continue
        try:
            content = json.loads(line.strip().rstrip(","))
            stamp = moment(str(content["timestamp"]))
            if stamp != stamp:
                raise ValueError(content["timestamp"])
            fields = {re.sub(r"[^a-z]", "", str(key).lower()): _bare(one) for key, one in content["fields"].items()}
            out.append((number, int(content["pgn"]), int(content.get("src", 0)), stamp, fields))
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError, ArithmeticError):
            faults.append((number, "no message of canboat", line))
    return out, faults


def _in_radians(head: str, messages: Sequence[tuple[int, int, int, float, dict[str, Any]]]) -> bool:
    """Whether canboat printed angles in radians: its first line states it; where that is missing, no direction is
    beyond a full turn, and some are no tenths, the digits that it prints of degrees."""
    if '"units":"' in head:
        return '"units":"si"' in head
    numbers = [_number(fields.get(name)) for *_, fields in messages for name in DIRECTIONS]
    known = np.array([number for number in numbers if number == number])
    return (
        bool(known.size) and bool(np.all(known < FULL_TURN)) and not np.allclose(known, np.round(known, 1), atol=1e-6)
    )


def _bare(value: Any) -> Any:
    """The value of a field; of `{"value": 1, "name": "Magnetic"}` its name."""
    return value.get("name", value.get("value")) if isinstance(value, dict) else value


def _table(path: Path, key: tuple[int, int, str], own: list, degrees: bool, dated: bool) -> RawTable | None:
    pgn, source, instance = key
    stated = stated_fields("NMEA 2000").get(str(pgn), {}) if len(own) > 2 else {}
    units = IN_DEGREES if degrees else {}
    stated = {name: field._replace(unit=units.get(field.unit, field.unit)) for name, field in stated.items()}
    times = np.array([time for _, time, _ in own])
    by = f"NMEA 2000 states it: PGN {pgn} of source {source}"
    time = RawColumn("time", "s", times if dated else times % 86400.0, "time", by)
    values = {name: np.array([_value(name, fields) for *_, fields in own]) for name in stated}
    sheet = f"{pgn} of {source}" + (f", instance {instance}" if instance else "")
    return table_of_fields(path, stated, values, time, f"{len(own)} messages", sheet, [line for line, *_ in own])


def _value(name: str, fields: dict[str, Any]) -> float:
    """The number of a field; of a direction, whose name says from which north, nan where it counts from another one."""
    field, _, north = name.partition(" from ")
    text = str(fields.get("reference", fields.get("cogreference"))).lower()
    own = "magnetic north" if text[:3] == "mag" or text == "1" else "any north"
    own = "true north" if text.startswith("true") or text == "0" else own
    return _number(fields.get(field)) if not north or north == own else np.nan


def _number(value: Any) -> float:
    return number_of(value if isinstance(value, int | float) and not isinstance(value, bool) else None)
