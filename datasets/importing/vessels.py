"""Rows of several vessels in one table: one is chosen by an identifier; and what AIS sends for 'not available'."""

from __future__ import annotations

from collections.abc import Mapping as Dict
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import TypeAlias

import numpy as np

from ...models.errors import BadInput
from ..io import MIN_SAMPLES
from .draft import Answer, Question
from .headers import read_header
from .mapping import Mapping, scalar
from .names import joined, named, words
from .quantities import names_in, quantities, vocabulary
from .raw import RawColumn, RawTable
from .times import find_time

VESSEL = "vessel"
"""Id of the question which vessel is wanted."""
SURE = 2
"""Of so many groups of the identifiers, distinct values mean distinct vessels; of the others where the rows tell it."""
MOST_SHOWN = 12


Groups: TypeAlias = tuple[RawColumn, Dict[str, np.ndarray]]
"""The column that says whose the rows of a table are, and the rows of each value with enough of them."""


def of_one_vessel(
    tables: Sequence[RawTable], mapping: Mapping | None, answers: Dict[str, str]
) -> tuple[list[RawTable], Question | None]:
    """The tables with the rows of one vessel, as the map or the answer says; and the question which one, if it is open.

    Raises
    ------
    BadInput : the answer is none of the vessels.
    """
    groups = {table.label: found for table in tables if (found := _groups(table)) is not None}
    names = list(dict.fromkeys(name for _, rows in groups.values() for name in rows))
    mapped = mapping.rows_of if mapping is not None else None
    wanted = answers.get(VESSEL) or (str(mapped) if mapped is not None else None)
    if wanted is not None and names and wanted not in names:
        raise BadInput(f"{wanted!r} is no vessel of the log", hint=f"give one of: {', '.join(names[:MOST_SHOWN])}")
    question = _which(tables, groups, names) if len(names) > 1 and wanted is None else None
    first = question.answers[0].key if question is not None else next(iter(names), None)
    used = [_with_rows(t, groups.get(t.label), wanted or first) for t in tables]
    return [_without_unknown(table) for table in used if table.n], question


@cache
def _identifiers() -> list[frozenset[str]]:
    """Names of columns that say whose a row is, without what separates their words, the most certain first."""
    return [frozenset(map(joined, names_in(text))) for text in vocabulary()["identifiers"]]


def _groups(table: RawTable) -> Groups | None:
    """The rows of each vessel; None where nothing says whose they are."""
    for rank, known in enumerate(_identifiers()):
        for column in (c for c in table.columns if joined(c.name) in known):
            rows = _rows_of(column)
            if (rows and rank < SURE) or (len(rows) > 1 and _tells(table, rows)):
                enough = {name: own for name, own in rows.items() if own.size >= MIN_SAMPLES}
                return (column, enough) if enough else None
    return None


def _rows_of(column: RawColumn) -> dict[str, np.ndarray]:
    """Value of a column, no gap -> its rows, those with the most first."""
    cells = column.numbers if column.texts is None else column.texts.trimmed
    values, place, counts = np.unique(cells, return_inverse=True, return_counts=True)
    if column.texts is None and values.size > 0.2 * cells.size:
        return {}
    order = np.argsort(-counts, kind="stable")
    sorted_rows = np.split(np.argsort(place, kind="stable"), np.cumsum(counts)[:-1])
    texts = [f"{value:.12g}" if isinstance(value, float) else str(value) for value in values.tolist()]
    unknown = ("", "nan", "0", "IMO0000000")
    return {texts[i]: np.sort(sorted_rows[i]) for i in order if texts[i] not in unknown}


def _tells(table: RawTable, rows: Dict[str, np.ndarray]) -> bool:
    """Whether values of a vague name are those of vessels: each with enough rows at the times of others."""
    large = [own for own in rows.values() if own.size >= MIN_SAMPLES]
    if len(large) < 2 or sum(own.size for own in large) < 0.9 * table.n:
        return False
    stays = sum(own.size - 1 for own in large) / max(1, table.n - 1)
    kept = [table.at(own) for own in large]
    filled = {frozenset(c.name for c in t.columns if np.isfinite(c.numbers).any()) for t in kept}
    may_be = [{quantity for column in t.columns for quantity in _may_be(column)} for t in kept]
    tracked = all(own & {"latitude", "north", "heading", "yaw_rate"} for own in may_be)
    return stays > 0.5 and len(filled) == 1 and tracked and _tells_time(table, large)


def _tells_time(table: RawTable, groups: Sequence[np.ndarray]) -> bool:
    """Whether the groups overlap in time: their rows alternate, or the time starts again with each."""
    first, *others = groups
    if any(((own > first[0]) & (own < first[-1])).sum() >= MIN_SAMPLES // 2 for own in others):
        return True
    time = find_time(table, None, {}).seconds(table)
    return time is not None and bool((np.diff(time[0]) < 0.0).any())


def _may_be(column: RawColumn) -> tuple[str, ...]:
    return (column.known,) if column.known else named(words(column.name)).may_be


def _with_rows(table: RawTable, groups: Groups | None, wanted: str | None) -> RawTable:
    """The table with the rows of the vessel that is wanted, none where it has none."""
    if groups is None:
        return table
    column, known = groups
    name = wanted if wanted in known else ""
    rows = known.get(name, np.zeros(0, dtype=int))
    if rows.size == table.n:
        return table
    told = f"{rows.size} of {table.n} rows are of {column.name} {name}; those of others are left out"
    return table.at(rows, done=(*table.done, told))


def _which(tables: Sequence[RawTable], groups: Dict[str, Groups], names: Sequence[str]) -> Question:
    counts = {name: sum(rows[name].size for _, rows in groups.values() if name in rows) for name in names}
    known = {name: sum(_known_cells(t, groups[t.label], name) for t in tables if t.label in groups) for name in names}
    ordered = sorted(names, key=lambda name: (-counts[name], -known[name]))
    label = next(iter(groups))
    answers = tuple(
        Answer(name, f"{name}{_called(tables, groups, name)}: {counts[name]} rows", f"rows_of: {scalar(name)}")
        for name in ordered[:MOST_SHOWN]
    )
    column, _ = groups[label]
    text = f"The rows are of {len(names)} vessels, by column {column.name!r}: which one is wanted?"
    number = f"{column.name} of another of them: rows_of: NUMBER" if len(names) > MOST_SHOWN else ""
    return Question(VESSEL, "file", label, column.name, text, answers, number)


def _known_cells(table: RawTable, groups: Groups, name: str) -> int:
    """How many cells of a vessel's rows tell something of its motion."""
    own = _without_unknown(table.at(groups[1][name])) if name in groups[1] else None
    told = [c for c in own.columns if c.numeric and np.nanmax(c.numbers) > np.nanmin(c.numbers)] if own else []
    return sum(int(np.isfinite(column.numbers).sum()) for column in told)


def _called(tables: Sequence[RawTable], groups: Dict[str, Groups], name: str) -> str:
    """The name of a vessel beside its identifier."""
    for table in tables:
        rows = groups[table.label][1].get(name) if table.label in groups else None
        column = next((c for c in table.columns if joined(c.name) in _identifiers()[3]), None)
        if rows is not None and column is not None and column is not groups[table.label][0]:
            return f" ({column.text(int(rows[0]))})" if column.text(int(rows[0])) else ""
    return ""


# ------------------------------------------------------------------------------------------------ AIS


def _without_unknown(table: RawTable) -> RawTable:
    """A table with gaps where AIS says 'not available'; of other tables headings of 511 deg among those to 360."""
    ais = any("mmsi" in words(column.name) for column in table.columns)
    table = table.told(_with_unit_of_ais, "of AIS: speeds in knots, angles in degrees") if ais else table
    unknown = {column.name: places for column in table.columns if (places := _unknown(column, ais)).any()}
    if not unknown:
        return table
    told = (f"{name}: {int(k.sum())} cells say 'not available' (AIS), taken as gaps" for name, k in unknown.items())

    def with_gaps(c: RawColumn) -> RawColumn:
        return replace(c, values=np.where(unknown[c.name], np.nan, c.cells.numbers)) if c.name in unknown else c

    return table.told(with_gaps, *told)


def _with_unit_of_ais(column: RawColumn) -> RawColumn:
    """A column of a table of AIS with the unit that the messages have, where the file states none."""
    may_be = _may_be(column)
    if column.unit or column.known or read_header(column.name, "").units:
        return column
    if "speed_over_ground" in may_be and column.numeric and not np.any(np.nan_to_num(column.numbers) % 1.0):
        return column  # whole numbers: knots, or tenths of them as the messages hold
    return replace(column, unit=next((unit for q in may_be if (unit := quantities()[q].unit_of_ais)), ""))


def _unknown(column: RawColumn, ais: bool) -> np.ndarray:
    """(N,) whether a cell holds what AIS sends for 'not available'."""
    wanted = next((q for q in _may_be(column) if q in quantities() and quantities()[q].unknown_to_ais), None)
    if wanted is None or not (ais or wanted == "heading") or not column.numeric:
        return np.zeros(1, dtype=bool)
    cells = column.cells.numbers
    unknown = np.isin(np.round(cells, 3), quantities()[wanted].unknown_to_ais)
    rest = cells[~unknown & np.isfinite(cells)]
    return unknown if ais or (rest.size and 6.3 < np.abs(rest).max() <= 360.0) else np.zeros(1, dtype=bool)
