"""Signal K: the units and signs that its paths state, in deltas and in tables whose columns are named by paths."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..raw import RawColumn, RawTable
from .fields import stated_fields
from .object_tables import FEWEST, Row

BY, RUDDER = "Signal K states it", "starboard"
"""Who states it, and the side of a positive rudder angle."""
MOST = {"rad": 6.3, "rad/s": 1.6, "m/s": 60.0, "deg": 180.0}
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
    path = next((p for p in paths if re.search(rf"(?<![a-z]){re.escape(p)}(?:[._]value)?$", column.name)), None)
    if path is None or column.known or column.unit or not column.numeric:
        return column
    _, quantity, unit = paths[path]
    if np.nanmax(np.abs(column.numbers)) > MOST[unit]:
        return column
    side = RUDDER if quantity.startswith("rudder") else ""
    return replace(column, unit=unit, known=quantity, source=f"{BY}: {path}", side=side)


def tables_of_deltas(deltas: Sequence[Row], path: Path) -> list[RawTable]:
    """A table for every path of every source."""
    series: dict[tuple[str, str], list[tuple[int, str, float]]] = defaultdict(list)
    for line, message in deltas:
        for time, source, name, number in values_of(message, str(message.get("timestamp", ""))):
            series[source, name].append((line, time, number))
    several = len({source for source, _ in series}) > 1
    tables = []
    for (source, name), own in series.items():
        if len(own) < FEWEST or not name:
            continue
        lines, times, numbers = zip(*own, strict=True)
        time = RawColumn("time", "", times, "", f"{BY}: UTC")
        column = RawColumn(name, "", np.array(numbers), source=f"source {source}" if source else "")
        sheet = f"{source} {name}".strip() if several else name
        tables.append(RawTable.of(path, (time, column), f"{len(own)} values", sheet, lines))
    return tables
