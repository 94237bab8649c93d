"""Logs of JSON objects: one a line, or a document of them; Signal K deltas, topics and values, nested objects."""

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
from ..names import is_time, joined, named
from ..raw import RawColumn, RawTable, Rejected
from ..stamp_texts import time_in
from .signalk import is_delta, values_of

LONGEST_STAMP = 80
"""Characters before the object of a line."""
KINDS = frozenset(
    map(joined, ("class", "type", "msg type", "message type", "kind", "event", "sensor", "device", "node"))
)
"""Names of a key that says what kind of record an object is."""
STAMP, TOPIC = "timestamp", "topic"
MOST_DOCUMENT, MOST_KEYS, MOST_KINDS, MOST_ITEMS, DEEPEST = 200_000_000, 300, 60, 16, 8
"""Characters of a document, keys of an object, kinds of objects, items of an array, and levels that are read."""
FEWEST = 3
HALVES = re.compile(r"\\u[dD][89a-fA-F][0-9a-fA-F]{2}")
"""Escapes of half a letter, which no text holds alone."""

Row = tuple[int, dict[str, Any]]


def looks_like_json(text: str) -> bool:
    """Whether most of the first lines hold a JSON object, or the text is a JSON document."""
    head = text[:20000].lstrip("\ufeff \t\r\n")
    lines = [line for line in head.splitlines()[:60] if line.strip()]
    whole = lines[:-1] if len(text) > len(head) + 10 and len(lines) > 1 else lines
    objects = sum(_split(line) is not None for line in whole)
    return (bool(whole) and objects > 0.5 * len(whole)) or re.match(r"[\[{]\s*[\[{\"]", head) is not None


def read_json(text: str, path: Path) -> list[RawTable]:
    """The tables of a log of JSON objects: one for every path of Signal K, topic or kind of object.

    Raises
    ------
    BadInput : it holds no objects with numbers, or is too large a document.
    """
    faults: list[Rejected] = []
    found = list(_objects(text, path, faults))
    deltas = [(line, obj) for line, obj in found if is_delta(obj)]
    tables = _of_deltas(deltas, path) if len(deltas) > 0.5 * len(found) else tables_of_rows(_senml(found), path)
    if not tables:
        hint = "a log is an object a line with a time, names and numbers"
        raise BadInput("no JSON objects with a time and numbers found", file=path, hint=hint)
    first = tables[0]
    lines = len(found) + len(faults)
    head = RawTable(first.file, first.columns, first.rows, first.sheet, first.clock, done=("JSON", *first.done),
                    faults=tuple(faults), lines=lines)  # fmt: skip
    return [head, *tables[1:]]


def _loads(text: str) -> Any:
    """The content of a JSON text, halves of letters in it left out; None where it is none."""
    try:
        return json.loads(HALVES.sub("?", text))
    except (ValueError, RecursionError):
        return None


def _split(line: str) -> tuple[str, dict[str, Any]] | None:
    """(the stamp before an object, the object) of a line; None where it holds none."""
    start, stop = line.find("{"), line.rfind("}") + 1
    if not 0 <= start <= LONGEST_STAMP or line[stop:].strip(" \t\r,;]"):
        return None
    found = _loads(line[start:stop])
    return (line[:start].strip(" \t,;:\"'[]("), found) if isinstance(found, dict) else None


def _beside(text: str) -> dict[str, str]:
    """The time that stands before an object, and the name behind it."""
    time, rest = time_in(text)
    named = [word for word in re.split(r"[\s;,\[\]|]+", rest) if re.search(r"[^\W\d]{2}", word)]
    return {STAMP: time or text, **({TOPIC: named[-1].rstrip(":")} if time and named else {})}


def _objects(text: str, path: Path, faults: list[Rejected]) -> Iterator[Row]:
    """(line, object) of a log; a stamp before an object becomes its time."""
    if text.strip().count("\n") + 1 < FEWEST or not any(_split(line) for line in text[:20000].splitlines()[:3]):
        yield from _of_document(text, path)
        return
    for number, line in enumerate(text.splitlines(), start=1):
        if (parts := _split(line)) is not None:
            stamp, found = parts
            beside = _beside(stamp) if stamp and not any(map(is_time, found)) else {}
            yield number, (beside | found)
        elif line.strip(" \t[],"):
            faults.append((number, "no JSON object", line))


def _of_document(text: str, path: Path) -> Iterator[Row]:
    """The objects of a document: those of its lists, with the name of the list where there are several; or the rows of
    its lists of equal length."""
    if len(text) > MOST_DOCUMENT:
        raise BadInput(f"a JSON document of more than {MOST_DOCUMENT:,} characters", file=path,
                       hint="write an object a line")  # fmt: skip
    content = _loads(text.strip("\ufeff"))
    lists: list[tuple[str, list[Any]]] = []
    tables: list[dict[str, list[Any]]] = []
    _search(content, "", lists, tables)
    long = [(name, own) for name, own in lists if len(own) >= FEWEST]
    rows = [({TOPIC: name} if len(long) > 1 else {}) | one for name, own in long for one in own]
    for table in tables:
        size = len(next(iter(table.values())))
        if size > len(rows):
            rows = [dict(zip(table, row, strict=True)) for row in zip(*table.values(), strict=True)]
    yield from enumerate(rows, start=1)


def _search(content: Any, name: str, lists: list[tuple[str, list[Any]]], tables: list[dict], depth: int = 0) -> None:
    """Lists of objects, and objects of lists of equal length, anywhere in a document."""
    if depth > DEEPEST:
        return
    if isinstance(content, list):
        if content and all(isinstance(one, dict) for one in content):
            lists.append((name, content))
        elif content and len(content) < MOST_ITEMS:
            for one in content:
                _search(one, name, lists, tables, depth + 1)
    elif isinstance(content, dict):
        series = {k: v for k, v in content.items() if isinstance(v, list) and v and not isinstance(v[0], dict | list)}
        sizes = {len(v) for v in series.values()}
        if len(series) > 1 and len(sizes) == 1 and len(series) <= MOST_KEYS:
            tables.append(series)
        for key, one in content.items():
            _search(one, str(key), lists, tables, depth + 1)


# ------------------------------------------------------------------------------------------------ Signal K


def _of_deltas(deltas: Sequence[Row], path: Path) -> list[RawTable]:
    """A table for every path of every source."""
    series: dict[tuple[str, str], list[tuple[int, str, float]]] = defaultdict(list)
    for line, message in deltas:
        for time, source, name, number in values_of(message, str(message.get(STAMP, ""))):
            series[source, name].append((line, time, number))
    several = len({source for source, _ in series}) > 1
    tables = []
    for (source, name), own in series.items():
        if len(own) < FEWEST or not name:
            continue
        times = RawColumn("time", "", tuple(time for _, time, _ in own), "", "Signal K states it: UTC")
        column = RawColumn(
            name, "", np.array([number for *_, number in own]), source=f"source {source}" if source else ""
        )
        sheet = f"{source} {name}".strip() if several else name
        rows = np.array([line for line, *_ in own])
        tables.append(RawTable(path.name, (times, column), rows, sheet, path.name, done=(f"{len(own)} values",)))
    return tables


# ------------------------------------------------------------------------------------------------ records


def _senml(found: Sequence[Row]) -> Sequence[Row]:
    """Records of sensor measurement lists (RFC 8428) under names in full, times from their base."""
    if not found or not all({"n", "v"} <= row.keys() for _, row in found[:FEWEST]):
        return found
    out, base = [], ("", 0.0)
    for line, row in found:
        base = (str(row.get("bn", base[0])), _number(row.get("bt", base[1])))
        time = base[1] + _number(row.get("t", 0.0))
        out.append((line, {"time": time, TOPIC: f"{base[0]}{row.get('n', '')}", "value": row.get("v"),
                           "unit": str(row.get("u", ""))}))  # fmt: skip
    return out


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


def tables_or_refusal(found: Sequence[Row], path: Path, what: str) -> list[RawTable]:
    """The tables of rows of one kind of file; BadInput where none holds numbers, `what` being what a row is."""
    tables = tables_of_rows(found, path)
    if not tables:
        raise BadInput(f"no {what} with numbers found", file=path)
    return tables


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


def _last(key: str) -> str:
    return key.rpartition(".")[2]


def _flat(value: Any, prefix: str = "", depth: int = 0) -> Iterator[tuple[str, Any]]:
    """(path, number or text) of what an object holds; objects written as texts within it are read as well."""
    if isinstance(value, str) and value[:1] == "{" and isinstance(inner := _loads(value), dict):
        value = inner
    if isinstance(value, dict) and depth < DEEPEST:
        for key, one in value.items():
            yield from _flat(one, f"{prefix}.{key}".strip("."), depth + 1)
    elif isinstance(value, list):
        if 0 < len(value) <= MOST_ITEMS and all(isinstance(one, int | float) for one in value):
            yield from ((f"{prefix}[{i}]", one) for i, one in enumerate(value))
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
    rows = np.array([line for line, _ in own])
    return RawTable(path.name, tuple(columns), rows, sheet, path.name, done=(f"{len(own)} objects",))


def _column(
    key: str, own: Sequence[Row], units: dict[str, str], keys: Sequence[str], topic: str, group: str
) -> RawColumn:
    """A key as a column: the value of a topic is called as the topic; one with a unit beside it has that."""
    place = key.rpartition(".")[0]
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
    header = read_header(called)
    if group and not valued and not any(named(own).may_be for own in (header.words, *(w for w, _ in header.suffixes))):
        called = f"{last_part(group)} {called}"
    return RawColumn(name, unit, _cells(values, numbers), called=called if called != name else "")


def _cells(values: Sequence[Any], numbers: bool) -> Any:
    """Values as numbers (N,) where all are, or else as texts."""
    if not numbers:
        return tuple("" if value is None else str(value) for value in values)
    return np.array([_number(value) for value in values])


def _number(value: Any) -> float:
    try:
        return float("nan") if value is None else float(value)
    except (OverflowError, TypeError, ValueError):  # a whole number of hundreds of digits, or none
        return float("nan")
