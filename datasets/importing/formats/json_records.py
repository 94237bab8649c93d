"""Logs of JSON objects: one a line, or a document of them; what stands before the objects, base values of SenML."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from operator import lt
from pathlib import Path
from typing import Any

import numpy as np

from ....models.errors import BadInput
from ..instruments import NAMES, UNITS
from ..moments import time_in
from ..names import is_time, joined
from ..raw import RawColumn, RawTable, Rejected, usable, with_faults
from .fields import stated_fields
from .object_tables import DEEPEST, FEWEST, MOST_ITEMS, MOST_KEYS, Row, content_of, number_of, tables_of_rows

LONGEST_STAMP = 80
"""Characters before the object of a line."""
STAMP, TOPIC = "timestamp", "topic"
"""Keys of what stands beside an object."""
HEAD, MOST_SERIES = 20_000, 300
"""Characters at either end of a text among which units stand, and series of pairs of a document that are read."""
UNITS_OBJECT = re.compile(r'"units?"\s*:\s*(\{[^{}]*\})')
MOST_DOCUMENT = 200_000_000
"""Characters of a document that is read."""


def read_json(text: str, path: Path) -> list[RawTable] | None:
    """The tables of a log of JSON objects: one for every path of Signal K, topic or kind of object; None where
    the text is no such log.

    Raises
    ------
    BadInput : it holds no objects with numbers, or is too large a document.
    """
    # most of the first lines hold a JSON object, or the text is a JSON document
    head = text[:20000].lstrip("\ufeff \t\r\n")
    lines = [line for line in head.splitlines()[:60] if line.strip()]
    whole = lines[:-1] if len(text) > len(head) + 10 and len(lines) > 1 else lines
    objects = sum(_split(line) is not None for line in whole)
    if not ((bool(whole) and objects > 0.5 * len(whole)) or re.match(r"[\[{]\s*[\[{\"]", head) is not None):
        return None
    faults: list[Rejected] = []
    found = list(_objects(text, path, faults))
    of_deltas = sum(is_delta(obj) for _, obj in found) > 0.5 * len(found)
    tables = tables_of_deltas(found, path) if of_deltas else tables_of_rows(_senml(found), path)
    # an object `"units": {"heading": "deg"}` at the begin or end of the text
    stated = (content_of(match[1]) for part in (text[:HEAD], text[-HEAD:]) for match in UNITS_OBJECT.finditer(part))
    units = {k: v for own in stated if isinstance(own, dict) for k, v in own.items() if isinstance(v, str)}
    tables = [table.told(partial(_with_unit, units=units)) for table in tables]
    hint = "a log is an object a line with a time, names and numbers"
    tables = usable(tables, path, "no JSON objects with a time and numbers found", hint)
    tables[0] = replace(tables[0], done=("JSON", *tables[0].done))
    return with_faults(tables, faults, len(found) + len(faults))


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


# ---- Signal K: the units and signs that its paths state, in deltas and in tables whose columns are named by paths.

BY, RUDDER = "Signal K states it", "starboard"
"""Who states it, and the side of a positive rudder angle."""
MOST = {"rad": 6.3, "rad/s": 1.6, "m/s": 60.0, "deg": 180.0, "rps": 100.0}
"""Largest size of a number of a unit; beyond it whoever wrote the table has changed the units."""


def is_delta(message: dict[str, Any]) -> bool:
    """Whether a JSON object is a Signal K delta."""
    updates = message.get("updates")
    return isinstance(updates, list) and all(isinstance(u, dict) and isinstance(u.get("values"), list) for u in updates)


def values_of(message: dict[str, Any], stamp: str) -> Iterator[tuple[str, str, str, float]]:
    """(time, source, path, number) of the values of a delta; the time of one that states none is `stamp`."""
    for update in message["updates"]:
        time = str(update.get("timestamp") or stamp)
        stated = update.get("source") if isinstance(update.get("source"), dict) else {}
        label = ".".join(str(stated[key]) for key in ("label", "src", "talker") if key in stated)
        source = str(update.get("$source") or label)
        for entry in update["values"]:
            if isinstance(entry, dict):
                yield from ((time, source, *one) for one in _numbers(str(entry.get("path", "")), entry.get("value")))


def _numbers(path: str, value: Any) -> Iterator[tuple[str, float]]:
    """(path, number) of a value, or of the parts of one such as a position."""
    if isinstance(value, dict):
        for key, part in value.items():
            yield from _numbers(f"{path}.{key}".strip("."), part) if not isinstance(part, dict) else ()
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield path, float(value) if abs(value) < 1e300 else float("nan")


def with_signal_k(table: RawTable) -> RawTable:
    """A table whose columns that are named by paths have the units and signs of Signal K, unless they have others."""
    told = table.told(_told, "names and units of Signal K")
    return told if told.columns != table.columns else table


def _told(column: RawColumn) -> RawColumn:
    paths = stated_fields("Signal K")["delta"]
    ends = ((p, re.escape(p).replace(r"\*", r"[^.]+")) for p in paths)
    path = next((p for p, end in ends if re.search(rf"(?<![a-z]){end}(?:[._]value)?$", column.name)), None)
    if path is None or column.known or column.unit or not column.numeric:
        return column
    _, quantity, unit = paths[path]
    if np.nanmax(np.abs(column.numbers)) > MOST[unit]:
        return column
    side = RUDDER if quantity.startswith("rudder") else ""
    return replace(column, unit=unit, known=quantity, source=f"{BY}: {path}", side=side)


def tables_of_deltas(found: Sequence[Row], path: Path) -> list[RawTable]:
    """A table for every path of every source of the vessel itself; where the log does not say which one that is, with
    the vessel of every row."""
    deltas = [(line, message, str(message.get("context", ""))) for line, message in found if is_delta(message)]
    hellos = {str(message["self"]) for _, message in found if isinstance(message.get("self"), str)}
    own = {"", "vessels.self", *hellos, *(f"vessels.{name}" for name in hellos)}
    vessels = {context for *_, context in deltas}
    if mine := vessels & own or (vessels if len(vessels) == 1 else set()):
        deltas = [(line, message, "") for line, message, context in deltas if context in mine]
    series: dict[tuple[str, str], list[tuple[int, str, float, str]]] = defaultdict(list)
    for line, message, context in deltas:
        for time, source, name, number in values_of(message, str(message.get("timestamp", ""))):
            series[source, name].append((line, time, number, context))
    several = len({source for source, _ in series}) > 1
    tables = []
    for (source, name), rows in series.items():
        if len(rows) < FEWEST or not name:
            continue
        lines, times, numbers, contexts = zip(*rows, strict=True)
        time = RawColumn("time", "", times, "", f"{BY}: UTC")
        column = RawColumn(name, "", np.array(numbers), source=f"source {source}" if source else "")
        vessel = (RawColumn("vessel id", "", contexts),) if any(contexts) else ()
        sheet = f"{source} {name}".strip() if several else name
        tables.append(RawTable.of(path, (time, column, *vessel), f"{len(rows)} values", sheet, lines))
    return tables
