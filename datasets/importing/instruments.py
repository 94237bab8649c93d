"""Tables whose rows come from several instruments: one table for every instrument, or for every named value."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .cells import GAPS
from .names import is_time, joined
from .raw import RawColumn, RawTable

TALKERS = frozenset(map(joined, ("talker", "source", "sensor", "device", "instrument", "sender", "geber", "talker id")))
NAMES = frozenset(map(joined, ("parameter", "signal", "channel", "variable", "tag", "quantity", "measurement", "item",
                               "parameter name", "signal name", "messgroesse", "kanal", "topic", "field")))  # fmt: skip
VALUES = frozenset(map(joined, ("value", "wert", "messwert", "reading", "data", "valeur", "valor", "verdi", "val")))
UNITS = frozenset(map(joined, ("unit", "units", "einheit", "unite", "unidad", "enhet")))
MOST = 60
"""Different names in a column that still names instruments or values."""


def by_instrument(table: RawTable) -> list[RawTable]:
    """The tables of a table: one for every named value in long form, one for every talker, or the table itself."""
    name, value = _texts(table, NAMES), next((c for c in table.columns if joined(c.name) in VALUES), None)
    if name is not None and value is not None and value.numeric:
        return _long(table, name, value)
    talker = _texts(table, TALKERS)
    return [table] if talker is None else _parts(table, talker)


def _texts(table: RawTable, wanted: frozenset[str]) -> RawColumn | None:
    """The first column of that name that holds a few different texts."""
    for column in table.columns:
        if joined(column.name) in wanted and not isinstance(column.values, np.ndarray) and not column.numeric:
            kinds = {value.strip() for value in column.values if value.strip().lower() not in GAPS}
            if 1 < len(kinds) <= MOST:
                return column
    return None


def _parts(table: RawTable, talker: RawColumn) -> list[RawTable]:
    """A table for every talker, of the columns that it fills."""
    out = []
    for kind in dict.fromkeys(str(value).strip() for value in talker.values):
        rows = [i for i, value in enumerate(talker.values) if str(value).strip() == kind]
        columns = [replace(c, values=_at(c, rows)) for c in table.columns if c is not talker]
        filled = tuple(c for c in columns if c.first(1))
        if len(filled) > 1:
            out.append(
                replace(
                    table, columns=filled, rows=table.rows[rows], sheet=kind, faults=table.faults if not out else ()
                )
            )
    return out or [table]


def _long(table: RawTable, name: RawColumn, value: RawColumn) -> list[RawTable]:
    """A table for every named value (of every talker) of a table in long form."""
    unit, talker = _one(table, UNITS), _one(table, TALKERS)
    times = [c for c in table.columns if is_time(c.name) or c.known == "time"] or list(table.columns[:1])
    keys = [(str(name.values[i]).strip(), str(talker.values[i]).strip() if talker else "") for i in range(table.n)]
    out = []
    for key in dict.fromkeys(keys):
        rows = [i for i, own in enumerate(keys) if own == key]
        if len(rows) < 3 or not key[0]:
            continue
        said = str(unit.values[rows[0]]).strip() if unit is not None else ""
        columns = [replace(c, values=_at(c, rows)) for c in times]
        columns.append(replace(value, name=key[0], unit=said or value.unit, values=_at(value, rows)))
        sheet = " ".join(part for part in (*key[1:], key[0]) if part)
        out.append(
            replace(
                table,
                columns=tuple(columns),
                rows=table.rows[rows],
                sheet=sheet,
                faults=table.faults if not out else (),
            )
        )
    return out or [table]


def _one(table: RawTable, wanted: frozenset[str]) -> RawColumn | None:
    return next((c for c in table.columns if joined(c.name) in wanted and not isinstance(c.values, np.ndarray)), None)


def _at(column: RawColumn, rows: Sequence[int]) -> tuple[str, ...] | np.ndarray:
    values = column.values
    return values[list(rows)] if isinstance(values, np.ndarray) else tuple(values[i] for i in rows)
