"""Logs of JSON objects: one a line, or a document of them; what stands before the objects, base values of SenML."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from operator import lt
from pathlib import Path
from typing import Any

from ....models.errors import BadInput
from ..instruments import NAMES, UNITS
from ..moments import time_in
from ..names import is_time, joined
from ..raw import RawColumn, RawTable, Rejected, usable, with_faults
from .object_tables import DEEPEST, FEWEST, MOST_ITEMS, MOST_KEYS, Row, content_of, number_of, tables_of_rows
from .signalk import is_delta, tables_of_deltas

LONGEST_STAMP = 80
"""Characters before the object of a line."""
STAMP, TOPIC = "timestamp", "topic"
"""Keys of what stands beside an object."""
HEAD, MOST_SERIES = 20_000, 300
"""Characters at either end of a text among which units stand, and series of pairs of a document that are read."""
UNITS_OBJECT = re.compile(r'"units?"\s*:\s*(\{[^{}]*\})')
MOST_DOCUMENT = 200_000_000
"""Characters of a document that is read."""


def _is_json(text: str) -> bool:
    """Whether most of the first lines hold a JSON object, or the text is a JSON document."""
    head = text[:20000].lstrip("\ufeff \t\r\n")
    lines = [line for line in head.splitlines()[:60] if line.strip()]
    whole = lines[:-1] if len(text) > len(head) + 10 and len(lines) > 1 else lines
    objects = sum(_split(line) is not None for line in whole)
    return (bool(whole) and objects > 0.5 * len(whole)) or re.match(r"[\[{]\s*[\[{\"]", head) is not None


def read_json(text: str, path: Path) -> list[RawTable] | None:
    """The tables of a log of JSON objects: one for every path of Signal K, topic or kind of object; None where
    the text is no such log.

    Raises
    ------
    BadInput : it holds no objects with numbers, or is too large a document.
    """
    if not _is_json(text):
        return None
    faults: list[Rejected] = []
    found = list(_objects(text, path, faults))
    deltas = [(line, obj) for line, obj in found if is_delta(obj)]
    tables = tables_of_deltas(deltas, path) if len(deltas) > 0.5 * len(found) else tables_of_rows(_senml(found), path)
    tables = [table.told(partial(_with_unit, units=_units_of(text))) for table in tables]
    hint = "a log is an object a line with a time, names and numbers"
    tables = usable(tables, path, "no JSON objects with a time and numbers found", hint)
    tables[0] = replace(tables[0], done=("JSON", *tables[0].done))
    return with_faults(tables, faults, len(found) + len(faults))


def _units_of(text: str) -> dict[str, str]:
    """Name -> unit, of an object `"units": {"heading": "deg"}` at the begin or end of a text."""
    found = (content_of(match[1]) for part in (text[:HEAD], text[-HEAD:]) for match in UNITS_OBJECT.finditer(part))
    return {k: v for own in found if isinstance(own, dict) for k, v in own.items() if isinstance(v, str)}


def _with_unit(column: RawColumn, units: Mapping[str, str]) -> RawColumn:
    unit = units.get(column.name, units.get(column.name.rpartition(".")[2], ""))
    return replace(column, unit=unit) if unit and not (column.unit or column.known) else column


def _split(line: str) -> tuple[str, dict[str, Any]] | None:
    """(the stamp before an object, the object) of a line; None where it holds none."""
    start, stop = line.find("{"), line.rfind("}") + 1
    if not 0 <= start <= LONGEST_STAMP or line[stop:].strip(" \t\r,;]"):
        return None
    found = content_of(line[start:stop])
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
    content = content_of(text.strip("\ufeff"))
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
            paired = [pairs for one in content[:MOST_SERIES] for pairs in _pairs_of(one)]
            lists += paired or [(name, content)]
            for one in content if len(content) < MOST_ITEMS else ():
                tables += _table_of(one)
                _search([v for v in one.values() if isinstance(v, list | dict)], name, lists, tables, depth + 1)
        elif content and len(content) < MOST_ITEMS:
            for one in content:
                _search(one, name, lists, tables, depth + 1)
    elif isinstance(content, dict):
        lists += _pairs_of(content)
        tables += _table_of(content)
        series = {k: v for k, v in content.items() if isinstance(v, list) and v and not isinstance(v[0], dict | list)}
        sizes = {len(v) for v in series.values()}
        if len(series) > 1 and len(sizes) == 1 and len(series) <= MOST_KEYS:
            tables.append(series)
        for key, one in content.items():
            _search(one, str(key), lists, tables, depth + 1)


def _pairs_of(content: Mapping[str, Any]) -> list[tuple[str, list[Any]]]:
    """The series of an object that has a name and a list of pairs of time and value, or of value and time: objects of
    a topic each, under the unit that the object states."""
    name = next((str(content[key]) for key in content if joined(key) in NAMES | {"target", "label"}), "")
    unit = next((str(content[key]) for key in content if joined(key) in UNITS), "")
    for pairs in content.values():
        if not name or not isinstance(pairs, list) or len(pairs) < FEWEST:
            continue
        if not all(isinstance(pair, list) and len(pair) == 2 for pair in pairs):
            continue
        first, last = ([number_of(pair[i]) for pair in pairs] for i in (0, 1))
        times, values = (first, last) if all(map(lt, first, first[1:])) else (last, first)
        if all(map(lt, times, times[1:])):
            made = zip(times, values, strict=True)
            return [(name, [{"time": t, TOPIC: name, "value": v} | ({"unit": unit} if unit else {}) for t, v in made])]
    return []


def _table_of(content: Mapping[str, Any]) -> list[dict[str, list[Any]]]:
    """The table of an object that holds names of columns and rows of as many values, as InfluxDB answers."""
    names, rows = content.get("columns"), content.get("values", content.get("rows", content.get("data")))
    if not isinstance(names, list) or not isinstance(rows, list) or not all(isinstance(one, str) for one in names):
        return []
    if len(rows) < FEWEST or not all(isinstance(row, list) and len(row) == len(names) for row in rows):
        return []
    return [dict(zip(names, map(list, zip(*rows, strict=True)), strict=True))]


def _senml(found: Sequence[Row]) -> Sequence[Row]:
    """Records of sensor measurement lists (RFC 8428) under names in full, times from their base."""
    if not found or not all({"n", "v"} <= row.keys() for _, row in found[:FEWEST]):
        return found
    out, base = [], ("", 0.0)
    for line, row in found:
        base = (str(row.get("bn", base[0])), number_of(row.get("bt", base[1])))
        time = base[1] + number_of(row.get("t", 0.0))
        out.append((line, {"time": time, TOPIC: f"{base[0]}{row.get('n', '')}", "value": row.get("v"),
                           "unit": str(row.get("u", ""))}))  # fmt: skip
    return out
