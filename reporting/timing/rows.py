"""Rows of the timings: what `tests/timing` measures, one JSON object a line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from ...models.data_file import json_of
from ...models.errors import BadInput


@dataclass(frozen=True)
class Row:
    """A measured pair, value or growing cost.

    what, unit : what is compared, in which unit.
    ours, other : medians of this package and of the other side, None where there is none.
    ratio, low, high, repeats : median, least and largest ratio of the repeats, and how many there were.
    target, reached : the target as text, and whether it is reached; None where nothing could be judged.
    remark, limit : what else is to be known; what keeps the figure from its target.
    axis, points : of a growing cost: 'samples', 'parameters' or 'records', and pairs (size, CPU s).
    run : of a tiny run of a suite: cpu_s, parent_cpu_s, start_cpu_s, stored_bytes, parent_bytes, fixed_bytes.
    code, load : version of the code, and the load average of the machine while it was measured.
    """

    what: str
    unit: str
    ours: float | None = None
    other: float | None = None
    ratio: float | None = None
    low: float | None = None
    high: float | None = None
    repeats: int = 0
    target: str = ""
    reached: bool | None = None
    remark: str = ""
    limit: str = ""
    axis: str = ""
    points: Sequence[Sequence[float]] = ()
    run: Mapping[str, float] | None = None
    code: str = ""
    load: float | None = None


NAMES = frozenset(entry.name for entry in fields(Row))


def read_rows(path: Path) -> list[Row]:
    """The rows of a file; of rows with the same `what` the last one counts.

    Raises
    ------
    BadInput : there is no such file, or a line is not a row.
    """
    try:
        lines = path.read_bytes().splitlines()
    except OSError as error:
        raise BadInput("cannot be read", file=path, hint="`make timing` writes it") from error
    found = {}
    for place, line in enumerate(lines, 1):
        row = _row(json_of(line, path, place), path, place)
        found[row.what] = row
    if not found:
        raise BadInput("holds no rows", file=path)
    return list(found.values())


def _row(facts: Any, path: Path, place: int) -> Row:
    if not isinstance(facts, dict) or not {"what", "unit"} <= facts.keys():
        raise BadInput("is not a row of timings", file=path, row=place)
    return Row(**{name: value for name, value in facts.items() if name in NAMES})
