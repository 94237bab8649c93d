"""Units that a file does not state and no channel tells: those of a table are proposed together, and asked once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from . import meanings, units_told
from .draft import Answer, Question
from .finding import WITH_SIDE, ColumnFinding
from .log import RawLog
from .proposal import NONE, key_of
from .quantities import quantities
from .raw import RawTable
from .units import UNITS, LogUnit

YES = "1"
"""Key of the answer that all of it is right."""
PASSES = 3
"""How often columns are compared: one that is told may tell the next."""
FASTEST_TURN_DEG_S = 5.0
"""Largest number of a yaw rate in degrees a second; one beside degrees that is larger counts minutes."""
OF_INSTRUMENTS = ("speed_over_ground", "speed_through_water", "wind_speed")
"""Speeds that instruments on board show in knots."""
ANGLES = ("heading", "heading_magnetic", "course_over_ground", "rudder", "rudder_command")
"""Angles that a file has in one unit."""
MOST_RPS = 15.0
"""Largest number of a propeller's revolutions a second."""


def propose(log: RawLog, tables: Sequence[RawTable]) -> None:
    """Take the likely units of the columns of each table that have none, with one question for all of them; none where
    it is answered that they are not right, or only one is open."""
    for table in tables:
        places = [i for i, found in enumerate(log.findings) if found.table is table and is_open(found)]
        identifier = f"{table.label}/{len(places)} units"  # with more columns another question
        if len(places) < 2 or log.answers.get(identifier) == NONE:
            continue
        before = list(log.findings)
        _take_likely(log, table, places)
        likely = {i: log.findings[i] for i in places if log.findings[i].unit is not None}
        question = _question(identifier, list(likely.values()))
        sure = key_of(question, log.answers) is not None
        log.findings = before
        for i, found in likely.items():
            log.findings[i] = _meant(before[i], found, sure)
        if not sure:
            log.proposals.append(question)


def is_open(found: ColumnFinding) -> bool:
    """Whether nothing says the unit of a column whose dimension is known, and it is not all zero; a rudder beyond all
    angles is in another measure, which is asked alone."""
    dimensions = {quantities()[quantity].dimension for quantity in found.may_be}
    told = found.unit is not None or found.foreign or found.unread or found.questions
    known = found.column.finite
    beyond = bool(set(found.may_be) & set(WITH_SIDE)) and units_told.size_of(found) > units_told.LARGEST_RUDDER_DEG
    return len(dimensions) == 1 and not (told or beyond) and dimensions != {"force"} and bool(np.any(known))


def _take_likely(log: RawLog, table: RawTable, places: Sequence[int]) -> None:
    """Put the likely units into a log: lengths in metres, then what these and other columns tell, then by size."""
    for dimension in ("length", "angle", "angular rate", "speed", "rotation"):
        for i in places:
            found = log.findings[i]
            # the unit of a rudder that is open tells that of its order
            rudders = [f for f in log.findings if f.table is table and f.quantity == "rudder" and f.unit is None]
            waits = found.quantity == "rudder_command" and bool(rudders)
            if found.unit is None and found.dimension == dimension and not waits:
                log.findings[i] = replace(found, unit=_by_size(log, table, found))
        for _ in range(PASSES):
            for i, found in enumerate(log.findings):
                if found.table is table and found.may_be:
                    log.findings[i] = units_told.by_channel(log, meanings.settle(log, found))


def _by_size(log: RawLog, table: RawTable, found: ColumnFinding) -> LogUnit:
    """The likely unit of a column: that of the others of its table, or by its size."""
    size, in_radians = units_told.size_of(found), _in_radians(log, table)
    if found.dimension == "angle":
        most = units_told.LARGEST_RAD.get(found.may_be[0], units_told.UNWRAPPED)
        return UNITS["rad" if in_radians and size <= 1.02 * most else "deg"]
    if found.dimension == "angular rate":
        return UNITS["rad/s" if in_radians else "deg/s" if size <= FASTEST_TURN_DEG_S else "deg/min"]
    if found.dimension == "speed":
        return UNITS["m/s" if in_radians or found.may_be[0] not in OF_INSTRUMENTS else "kn"]
    if found.dimension == "length":
        return UNITS["mm" if _is_fast(log, table, found) else "m"]
    return UNITS["rps" if size <= MOST_RPS else "rpm"]


def _in_radians(log: RawLog, table: RawTable) -> bool:
    """Whether all angles of a table are in radians, or may be."""
    angles = [f for f in log.findings if f.table is table and f.may_be and f.may_be[0] in ANGLES]
    stated = {f.unit.name for f in angles if f.unit is not None}
    most = [1.02 * units_told.LARGEST_RAD.get(f.may_be[0], units_told.FULL_TURN) for f in angles]
    small = all(units_told.size_of(f) <= largest for f, largest in zip(angles, most, strict=True))
    return stated == {"rad"} or (not stated and small)


def _is_fast(log: RawLog, table: RawTable, found: ColumnFinding) -> bool:
    """Whether a position moves faster than any craft if it is in metres."""
    series = log.series(found, raw=True)
    if series is None or not np.isfinite(series.time).any():
        return False
    lasts = float(np.nanmax(series.time) - np.nanmin(series.time))
    moved = float(np.nanmax(series.values) - np.nanmin(series.values))
    return moved > units_told.FASTEST_M_S * lasts


def _meant(found: ColumnFinding, likely: ColumnFinding, sure: bool) -> ColumnFinding:
    """The finding of a column with its likely unit."""
    why = "as answered" if sure else "its unit is likely, by its size and how the columns move together"
    return replace(
        found, unit=likely.unit, factor=likely.factor, sure="stated" if sure else "guess", why=(*found.why, why),
        bounded=(*found.bounded, "unit"),
    )  # fmt: skip


def _question(identifier: str, likely: Sequence[ColumnFinding]) -> Question:
    told = ", ".join(f"{f.column.name} is {_said(f)}" for f in likely)
    text = f"The file does not state these units. By size and how the columns move together {told}. Is this right?"
    answers = (
        Answer(YES, "yes, all of it", "nothing more: the draft says it"),
        Answer(NONE, "no: ask for each column", "change the units of these columns"),
    )
    first = likely[0]
    return Question(identifier, "columns", first.table.label, first.column.name, text, answers)


def _said(found: ColumnFinding) -> str:
    """What a column may be, and its unit."""
    assert found.unit is not None
    unit = found.unit.name if found.factor == 1.0 else f"{found.factor:g} {found.unit.name}"
    return f"{' or '.join(quantity.replace('_', ' ') for quantity in found.may_be)} [{unit}]"
