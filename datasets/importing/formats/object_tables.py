"""Tables of objects that may hold further ones: rows of JSON, points of InfluxDB, messages of MAVLink."""

from __future__ import annotations

import json
import re
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ....models.errors import BadInput
from ..headers import read_header
from ..instruments import NAMES, UNITS, VALUES, last_part
from ..layout import distinct
from ..names import is_time, joined, listed, named
from ..raw import RawColumn, RawTable

KINDS = listed("object_kinds")
"""Names of a key that says what kind of record an object is."""
MOST_KEYS, MOST_KINDS, MOST_ITEMS, DEEPEST = 300, 60, 16, 8
"""Keys of an object, kinds of objects, items of an array, and levels that are read."""
COORDINATES = re.compile(r"(?:^|\.)coordinates\[([01])\]$")
FEWEST = 3
"""Objects below which there is no table."""
HALVES = re.compile(r"\\u[dD][89a-fA-F][0-9a-fA-F]{2}")
"""Escapes of half a letter, which no text holds alone."""

Row = tuple[int, dict[str, Any]]
"""Line of a file, and the object on it."""


def tables_of_rows(found: Sequence[Row], path: Path) -> list[RawTable]:
    """A table for every topic or kind of object, or for all objects.

    found : (line, object) each; objects may hold further ones.
    """
    rows = [(line, dict(_flat(obj))) for line, obj in found]
    groups: dict[str, list[Row]] = defaultdict(list)
    name, kind = _key(rows, NAMES), _key(rows, KINDS)
    for line, row in rows:
        groups[str(row.get(name, row.get(kind, ""))) if name or kind else ""].append((line, row))
    if len(groups) > MOST_KINDS:
        groups = {"": rows}
    if not name and not kind:
        groups = _by_keys(rows)
    keys = (name, kind) if len(groups) > 1 else ("", "")
    tables = [_table(own, keys, sheet, path) for sheet, own in groups.items()]
    return [table for table in tables if table is not None]


def _by_keys(rows: Sequence[Row]) -> dict[str, list[Row]]:
    """Rows by what they hold besides a time, where different objects share nothing but it."""
    groups: dict[frozenset[str], list[Row]] = defaultdict(list)
    times = {key for key in {key for _, row in rows for key in row} if is_time(_last(key))}
    for line, row in rows:
        groups[frozenset(row.keys() - times)].append((line, row))
    usual = {keys: own for keys, own in groups.items() if len(own) >= max(FEWEST, 0.02 * len(rows))}
    keys = list(usual)
    apart = all(not a & b for i, a in enumerate(keys) for b in keys[:i])
    if not 1 < len(usual) <= MOST_KINDS or not apart:
        return {"": list(rows)}
    return {", ".join(sorted(_last(key) for key in keys))[:60]: own for keys, own in usual.items()}


def _key(rows: Sequence[Row], wanted: frozenset[str]) -> str:
    """The key of that name that tells the objects apart; '' for none."""
    for key in rows[0][1] if rows else ():
        if joined(_last(key)) in wanted:
            kinds = [row.get(key) for _, row in rows]
            texts = {one for one in kinds if isinstance(one, str)}
            if 1 < len(texts) <= MOST_KINDS and sum(isinstance(one, str) for one in kinds) > 0.9 * len(rows):
                return key
    return ""


def content_of(text: str) -> Any:
    """The content of a JSON text, halves of letters in it left out; None where it is none."""
    try:
        return json.loads(HALVES.sub("?", text))
    except (ValueError, RecursionError):
        return None


def _last(key: str) -> str:
    return key.rpartition(".")[2]


def _flat(value: Any, prefix: str = "", depth: int = 0) -> Iterator[tuple[str, Any]]:
    """(path, number or text) of what an object holds; objects written as texts within it are read as well."""
    if isinstance(value, str) and value[:1] == "{" and isinstance(inner := content_of(value), dict):
        value = inner
    if isinstance(value, dict) and depth < DEEPEST:
        for key, one in value.items():
            yield from _flat(one, f"{prefix}.{key}".strip("."), depth + 1)
    elif isinstance(value, list):
        plain = all(isinstance(one, int | float | dict) for one in value) and depth < DEEPEST
        for i, one in enumerate(value) if 0 < len(value) <= MOST_ITEMS and plain else ():
            yield from _flat(one, f"{prefix}[{i}]", depth + 1)
    elif isinstance(value, bool | int | float | str):
        yield prefix, value


def _table(own: Sequence[Row], told: tuple[str, str], sheet: str, path: Path) -> RawTable | None:
    """The table of some objects; `told` are the keys that say of which topic and kind they are, '' for none."""
    keys = list(dict.fromkeys(key for _, row in own for key in row if key not in told))
    if len(own) < FEWEST or not keys:
        return None
    if len(keys) > MOST_KEYS:
        raise BadInput(f"objects with {len(keys)} keys; at most {MOST_KEYS} are read", file=path,
                       hint="export the values that tell of the ship's motion")  # fmt: skip
    stated = [key for key in keys if joined(_last(key)) in UNITS]
    units = {key: next(str(row[key]) for _, row in own if key in row) for key in stated}
    columns = [_column(key, own, units, keys, sheet if told[0] else "", sheet) for key in keys if key not in units]
    if not any(column.numeric for column in columns if not is_time(column.name)):
        return None
    names = distinct([column.name for column in columns])
    columns = [replace(column, name=name) for column, name in zip(columns, names, strict=True)]
    return RawTable.of(path, columns, f"{len(own)} objects", sheet, [line for line, _ in own])


def _column(
    key: str, own: Sequence[Row], units: dict[str, str], keys: Sequence[str], topic: str, group: str
) -> RawColumn:
    """A key as a column: the value of a topic is called as the topic; one with a unit beside it has that."""
    place = key.rpartition(".")[0]
    if axis := COORDINATES.search(key):  # of GeoJSON
        quantity = ("longitude", "latitude")[int(axis[1])]
        return RawColumn(key, "deg", _cells([row.get(key) for _, row in own], True), quantity, "GeoJSON states it")
    values = [row.get(key) for _, row in own]
    numbers = all(value is None or isinstance(value, bool | int | float) for value in values)
    alone = sum(_last(other) == _last(key) for other in keys) < 2
    if is_time(_last(key)):
        return RawColumn(_last(key) if alone else key, "", _cells(values, numbers))
    valued = joined(_last(key)) in VALUES
    unit = next((text for other, text in units.items() if other.rpartition(".")[0] == place), "") if valued else ""
    name = (place or topic or key) if valued else key
    called = last_part(f"{topic}.{place}" if valued else key) if alone or valued else name
    if len(called) < 3 and place and not valued:
        called = f"{last_part(place)} {called}"
    if place and not valued and not _is_known(called) and _is_known(f"{last_part(place)} {called}"):
        called = f"{last_part(place)} {called}"
    if group and not valued and not _is_known(called):
        called = f"{last_part(group)} {called}"
    return RawColumn(name, unit, _cells(values, numbers), called=called if called != name else "")


def _is_known(name: str) -> bool:
    """Whether a name, with or without a unit at its end, is that of a quantity."""
    header = read_header(name)
    return any(named(own).may_be for own in (header.words, *(head for head, _ in header.suffixes)))


def _cells(values: Sequence[Any], numbers: bool) -> Any:
    """Values as numbers (N,) where all are, or else as texts."""
    if not numbers:
        return tuple("" if value is None else str(value) for value in values)
    return np.array([number_of(value) for value in values])


def number_of(value: Any) -> float:
    """The number of a value of an object; nan where it is none."""
    try:
        return float("nan") if value is None else float(value)
    except (OverflowError, TypeError, ValueError):  # a whole number of hundreds of digits, or none
        return float("nan")
