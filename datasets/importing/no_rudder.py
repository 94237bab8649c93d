"""A log without a known rudder, or without what tells the turning: which columns could be it, and what is asked."""

from __future__ import annotations

from collections.abc import Mapping as Dict
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..rudder_sign import SIGN_SHARE
from ..yaw_response import yaw_response
from .draft import Answer, Question
from .evidence import ClockSeries, together
from .finding import WITH_SIDE, ColumnFinding
from .log import RawLog
from .mapping import Mapping, flow
from .names import named, words
from .raw import RawTable
from .units import unit_of

RUDDER, TURNING = "rudder", "turning"
"""Ids of the questions."""
PROPELLERS = "propellers"
"""Id of the question which columns are two propellers that steer."""
NONE = "none"
"""The answer that there is no rudder."""
LARGEST_DEG = 60.0
PULSE_US, PER_CENT = (700.0, 2300.0), 100.0
"""Range of a servo's pulse, and of a share of the largest angle."""
NAMELESS = ("no known name", "not in the map")
"""Why a column that may be anything is not used."""
DECIDED = ("the map says so", "not used, as answered")
"""Why a column is not used that the user left out."""
ACCELERATIONS = frozenset({"accel", "acceleration", "acc", "accy"})
"""Words for what a yaw rate follows as it does a rudder."""


def questions(
    tables: Sequence[RawTable], log: RawLog, mapping: Mapping | None, answers: Dict[str, str]
) -> list[Question]:
    """Questions for the column of the rudder, and for one that tells the turning, where none is known or asked."""
    may_be = {quantity for f in log.findings for quantity in f.may_be}
    asked = []
    opened = any(question.id == PROPELLERS for f in log.findings for question in f.questions)
    none = answers.get(RUDDER) == NONE or (mapping is not None and mapping.rudder == NONE)
    if is_unsteered(may_be) and not opened and not none and (able := _rudders(log)):
        asked.append(_which_rudder(able))
    if not may_be & {"heading", "heading_magnetic", "yaw_rate", "latitude", "north"}:
        asked.append(_which_turning(tables, log))
    return asked


def is_unsteered(quantities_of_log: set[str]) -> bool:
    """Whether none of the quantities is what a ship is steered by."""
    return not quantities_of_log & set(WITH_SIDE) and not quantities_of_log >= {"thrust_port", "thrust_starboard"}


def _rudders(log: RawLog) -> list[ColumnFinding]:
    """Columns that could be the rudder: called so and not read, or without a known name, as large as a rudder, and the
    yaw rate answers them, where there is one: that of a sensor, a heading, or a track."""
    angles = [s for _, s in log.all("heading", "heading_magnetic", signed=False)] or [s for _, s in log.turns()]
    turning = [series for _, series in log.all("yaw_rate", signed=False)] or list(map(_derivative, angles))
    return [f for f in log.findings if _is_called(f) or (_is_servo_like(f) and _answered_by(log, f, turning))]


def _is_refused(found: ColumnFinding) -> bool:
    """Whether the name of a column says that it is something else: then only what answers it tells."""
    return set(found.why).isdisjoint(NAMELESS)


def _is_called(found: ColumnFinding) -> bool:
    """Whether an unused column that varies is called a rudder."""
    column = found.column
    called = set(named(words(column.called or column.name)).may_be) & set(WITH_SIDE)
    known = column.finite
    own = not column.known and not set(found.why) & set(DECIDED)
    return bool(called) and own and not found.may_be and column.numeric and float(np.ptp(known)) > 0.0


def _derivative(angle: ClockSeries) -> ClockSeries:
    known = np.isfinite(angle.values) & np.isfinite(angle.time)
    time, values = angle.time[known], np.unwrap(angle.values[known])
    rises = np.diff(time, prepend=-np.inf) > 0.0
    time, values = time[rises], values[rises]
    return replace(angle, time=time, values=np.gradient(values, time) if time.size > 1 else np.zeros(time.size))


def _is_servo_like(found: ColumnFinding) -> bool:
    """Whether an unused column without a known name has the size and the unit of a rudder."""
    column = found.column
    if found.may_be or column.known or set(found.why) & set(DECIDED) or not column.numeric:
        return False
    if _is_refused(found) and set(words(column.name)) & ACCELERATIONS:
        return False
    if column.unit and unit_of(column.unit) is not None and unit_of(column.unit, "angle") is None:
        return False
    known = column.finite
    low, high = np.quantile(known, [0.01, 0.99]).tolist()
    if low == high or np.unique(known).size < 3:
        return False
    either_side = low < 0.0 < high and -low < 10.0 * high and high < -10.0 * low
    return is_pulse(known) or (either_side and max(-low, high) <= max(LARGEST_DEG, PER_CENT))


def is_pulse(numbers: np.ndarray) -> bool:
    """Whether numbers (N,) may be the pulses of a servo, in us, to both sides of its middle."""
    known = numbers[np.isfinite(numbers)]
    low, high = np.quantile(known, [0.01, 0.99]).tolist() if known.size else (0.0, 0.0)
    return PULSE_US[0] <= low < 1500.0 < high <= PULSE_US[1]


def _answered_by(log: RawLog, found: ColumnFinding, turning: Sequence[ClockSeries]) -> bool:
    """Whether a yaw rate answers the column as one answers a rudder; also where none can be compared with it."""
    series = log.series(found, raw=True)
    compared = [] if series is None else [share for r in turning if (share := response(series, r)) is not None]
    if series is None or not compared:
        return not _is_refused(found)
    return any(compared)


def response(steering: ClockSeries, rate: ClockSeries) -> float | None:
    """The share of the yaw rate that what steers explains, with the sign of its gain; 0 where it explains little, None
    where they cannot be compared."""
    shared = together(steering, rate)
    if shared is None or not np.ptp(shared[1]) > 0.0 or not np.ptp(shared[2]) > 0.0:
        return None
    told = yaw_response(shared[0], shared[2], shared[1])
    return told.share * told.gain if told is not None and told.is_sure(SIGN_SHARE) else 0.0


def _which_rudder(able: Sequence[ColumnFinding]) -> Question:
    listed = ", ".join(f.column.name for f in able)
    answers = tuple(_as(f, RUDDER) for f in able)
    none = Answer(NONE, "there is no rudder in this log: sensors can be checked, no model identified", "rudder: none")
    text = f"No column is known to be the rudder angle: is it one of these, or is there none? Columns: {listed}."
    first = able[0]
    return Question(RUDDER, "quantity", first.table.label, first.column.name, text, (*answers, none), without=NONE)


def _which_turning(tables: Sequence[RawTable], log: RawLog) -> Question:
    able = [f for f in log.findings if f.column.numeric and np.ptp(f.column.finite) > 0]
    answers = tuple(_as(f, quantity) for f in able for quantity in ("heading", "yaw_rate"))
    names = ", ".join(column.name for table in tables for column in table.columns)
    text = f"No column is known to be the heading or the yaw rate: which one is it? Columns: {names}."
    return Question(TURNING, "quantity", tables[0].label, tables[0].columns[0].name, text, answers)


def _as(found: ColumnFinding, quantity: str) -> Answer:
    line = flow({"column": found.column.name, "to": quantity, "unit": "?"})
    text = f"{found.column.name} is the {quantity.replace('_', ' ')}"
    return Answer(f"{found.table.label}/{found.column.name}/{quantity}", text, line)
