"""MOOS logs (.alog): a value of a variable a line, with the seconds since the log was started."""

from __future__ import annotations

import re
from collections import defaultdict
from pathlib import Path

import numpy as np

from ....models.number_texts import DECIMAL
from ..raw import RawColumn, RawTable, usable
from .fields import StatedField, stated_fields

LINE = re.compile(rf"(?P<time>-?\d+\.\d+)\s+(?P<name>[A-Za-z]\w{{1,80}})\s+(?P<source>\S+)\s+(?P<value>{DECIMAL})\s*$")
START = re.compile(r"LOGSTART\s+(\d+\.?\d*)")
BY = "MOOS states it"
ANGLES = ("RUDDER", "ELEVATOR")
"""Words in the name of a variable that is an angle in degrees."""


def _is_alog(text: str) -> bool:
    """Whether a text is a log of MOOS."""
    head = text[:6000]
    if "%% LOG FILE" in head or "%% LOGSTART" in head:
        return True
    lines = [line for line in head.splitlines()[:40] if line.strip() and not line.startswith("%")][:-1]
    variables = [match["name"] for line in lines if (match := LINE.match(line))]
    return len(variables) > 0.4 * len(lines) and sum(name.isupper() for name in variables) > 5


def read_alog(text: str, path: Path) -> list[RawTable] | None:
    """A table for every variable of numbers, None where the text is no log of MOOS; BadInput where there is none."""
    if not _is_alog(text):
        return None
    start = START.search(text[:20000])
    since = float(start[1]) if start else 0.0
    series: dict[str, list[tuple[int, float, float]]] = defaultdict(list)
    for number, line in enumerate(text.splitlines(), start=1):
        match = LINE.match(line) if len(line) < 1000 else None
        if match is not None:
            series[match["name"]].append((number, since + float(match["time"]), float(match["value"])))
    tables = [_table(path, name, own, bool(start)) for name, own in series.items() if len(own) > 2]
    return usable(tables, path, "no variable of the MOOS log holds numbers")


def _table(path: Path, name: str, own: list[tuple[int, float, float]], dated: bool) -> RawTable:
    other = StatedField(name, "", "deg" if any(word in name for word in ANGLES) else "")
    _, quantity, unit = stated_fields("MOOS")["variable"].get(name, other)
    lines, times, values = zip(*own, strict=True)
    time = RawColumn("time", "s", np.array(times), "time" if dated else "", BY)
    column = RawColumn(name, unit, np.array(values), quantity, BY if unit else "")
    return RawTable.of(path, (time, column), f"{len(own)} values", name, lines)
