"""Signs that a file does not state: told by another channel, or asked."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from . import units_told
from .evidence import (
    ClockSeries,
    as_of_one_clock,
    body,
    cosine,
    follows,
    rate_ratio,
    sense,
    slope,
    sum_with_course,
    together,
)
from .finding import ColumnFinding, ask_sign
from .log import RawLog
from .reading import frame_stated

NEAR = 0.6
"""How far a course may be from the heading in the mean, rad."""
STRENGTHS = (0.3, 3.0)
"""Ratio of two sway speeds, or speeds forward, between which one tells of the other's sign."""
OUTWARD = 0.7
"""Correlation of a sway and a yaw rate from which on the drift is outward."""
QUARTER = math.pi / 2.0
TO_SIDES = ("starboard", "positive to starboard"), ("port", "positive to port")
_DOWN = ("starboard", "positive starboard down"), ("port", "positive port down")
_TO_EAST = ("east", "positive to east"), ("west", "positive to west")
WAYS = {
    "surge": (("forward", "positive forward"), ("astern", "positive astern")),
    "rudder_command": (("same", "as the rudder angle"), ("opposite", "against the rudder angle")),
    "magnetic_variation": _TO_EAST, "magnetic_deviation": _TO_EAST, "roll": _DOWN, "roll_rate": _DOWN,
}  # fmt: skip
"""Quantity -> key and text of the answers for the record's sign and for the other one; `TO_SIDES` of all others."""


def by_channel(log: RawLog, found: ColumnFinding) -> ColumnFinding:
    """The finding with the sign that another channel tells; unchanged where none does."""
    if found.signed or found.quantity is None or found.unit is None:
        return found
    ways = {"heading": _heading, "yaw_rate": _rate, "sway": _along, "surge": _along, "roll_rate": _rate}
    way = ways.get(found.quantity)
    return way(log, found) if way is not None else found


def _heading(log: RawLog, found: ColumnFinding) -> ColumnFinding:
    frame = frame_stated(found.table)
    if frame and found.unit is not None:
        quarter = round(QUARTER / found.unit.factor, 9)
        turned = {"sign": -1, "offset": quarter} if frame == "enu" else {}
        return found.told("stated", f"the file states axes {frame.upper()}", signed=True, **turned)
    series = log.series(found)
    if series is None:
        return found
    for name, north, east in log.tracks():
        told = sense(series, north, east)
        if told is not None:
            return _with_sense(found, told, f"agrees with {name}")
    rates = [(f, rate_ratio(series, s)) for f, s in log.all("yaw_rate") if _is_sure(f)]
    others = ((f, slope(s, series)) for f, s in log.all("heading") if f is not found)
    for other, ratio in (*rates, *others):
        if ratio is not None:
            return _as_turned(log, found, series, ratio, f"turns with {other.column.name}")
    return found


def _is_sure(rate: ColumnFinding) -> bool:
    """Whether the sign of a yaw rate is stated, or told by a track."""
    by = ("positive to", "turning of", "states it")
    return bool(rate.side or rate.column.known) or any(text in why for why in rate.why for text in by)


def _as_turned(log: RawLog, found: ColumnFinding, series: ClockSeries, ratio: float, why: str) -> ColumnFinding:
    """The finding of a heading by its ratio to another channel; where it turns against it, from which direction it
    counts is told by a track, if there is one."""
    tracks = list(log.tracks())
    for name, north, east in tracks if ratio < 0.0 else ():
        angle = sum_with_course(series, north, east)
        if angle is not None:
            return _with_sense(found, ("against", angle), f"{why}, and agrees with {name}")
    return found if tracks and ratio < 0.0 else _as_ratio(found, ratio, why)


def _as_ratio(found: ColumnFinding, ratio: float, why: str) -> ColumnFinding:
    """The finding with the sign of its ratio to another channel."""
    return found.told("other channel", why, signed=True, sign=1 if ratio > 0.0 else -1)


def _with_sense(found: ColumnFinding, told: tuple[str, float], why: str) -> ColumnFinding:
    assert found.unit is not None
    turned, angle = told
    if turned == "with" and abs(angle) < NEAR:
        return found.told("other channel", why, signed=True)
    if turned == "against" and abs(angle - QUARTER) < NEAR:
        offset = round(QUARTER / found.unit.factor, 9)
        said = f"counts counterclockwise from east: {why}"
        return found.told("other channel", said, signed=True, sign=-1, offset=offset)
    if turned == "against" and abs(angle) < NEAR:
        return found.told("other channel", f"counts counterclockwise from north: {why}", signed=True, sign=-1)
    return found


def _rate(log: RawLog, found: ColumnFinding) -> ColumnFinding:
    """The sign of a rate by the angle of which it is the rate, of the turning of the ship also by a track."""
    series = log.series(found)
    ratios = units_told.ratios(log, found, series, signed=True) if series is not None else ()
    for name, ratio in ratios:
        if ratio is not None:
            return _as_ratio(found, ratio, f"{'' if ratio > 0.0 else 'turned round: '}agrees with {name}")
    return found


def _along(log: RawLog, found: ColumnFinding) -> ColumnFinding:
    """The sign of a speed forward or sideways by a track and a heading, or by the drift in a turn."""
    told = by_track(log, found)
    if told is not None:
        return _as_ratio(found, told[0], f"agrees with {told[1]} and the heading")
    rate = _turned_outward(log, found) if found.quantity == "sway" else None
    if rate is not None and rate.signed:
        why = f"to the side to which column {rate.column.name} is positive: the ship drifts outward"
        return _as_ratio(found, rate.sign, why)
    return found


def by_track(log: RawLog, found: ColumnFinding) -> tuple[int, str] | None:
    """(sign of the numbers of a speed forward or sideways, name of the track that tells it); None where none does."""
    series = log.series(found, raw=True)
    if series is None or found.unit is None:
        return None
    size = found.unit.factor * found.factor
    for _, psi in log.all("heading"):
        for name, north, east in log.tracks():
            parts = body(psi, north, east)
            ratio = slope(parts[0 if found.quantity == "surge" else 1], series) if parts is not None else None
            if ratio is not None and STRENGTHS[0] < abs(ratio) / size < STRENGTHS[1]:
                return (1 if ratio > 0.0 else -1), name
    return None


def _turned_outward(log: RawLog, found: ColumnFinding) -> ColumnFinding | None:
    """The yaw rate of the same table that is positive to the same side as a sway: in right-handed axes both are, and a
    ship that turns drifts outward; None where the numbers do not say both."""
    sway = log.series(found, raw=True)
    rates = (f for f in log.findings if f.quantity == "yaw_rate" and f.table is found.table and f.unit is not None)
    for rate in rates:
        series = log.series(rate, raw=True)
        shared = together(sway, series) if sway is not None and series is not None else None
        if shared is not None and found.sign == 1 and cosine(shared[1], shared[2]) < -OUTWARD:
            return rate
    return None


def command_sign(log: RawLog, found: ColumnFinding) -> ColumnFinding:
    """A rudder command with the sign of the rudder, which follows it."""
    series = log.series(found) if found.unit is not None else None
    other = log.first("rudder")
    if other is None:
        return replace(found, signed=True)
    told = follows(as_of_one_clock(other[1], series), series) if series is not None else None
    if told is None:
        return found
    return _as_ratio(found, told, f"{'' if told > 0 else 'turned round: '}column {other[0].column.name} follows it")


# ------------------------------------------------------------------------------------------------ questions


def waits(log: RawLog, found: ColumnFinding) -> str:
    """The column whose sign is asked and will tell this one's; '' where there is none."""
    if found.quantity == "sway":
        rate = _turned_outward(log, found)
        return rate.column.name if rate is not None else ""
    if found.quantity != "yaw_rate":
        return ""
    series = log.series(found)
    for other in log.findings:
        opened = other.unit is not None and "heading" in other.may_be and not (other.signed and other.quantity)
        angle = log.series(other) if opened else None
        if angle is not None and series is not None and rate_ratio(angle, series) is not None:
            return other.column.name
    return ""


def ask(log: RawLog, found: ColumnFinding) -> ColumnFinding:
    """The finding with the question for its sign, or as one that waits for another's."""
    name, unit = found.column.name, found.unit
    assert unit is not None
    if not np.any(np.nan_to_num(found.column.numbers)):
        return found.told("physics", "zero throughout: both ways are the same", signed=True)
    waiting = waits(log, found)
    if waiting:
        return found.told("other channel", f"its sign is told by {waiting}, whose own is asked")
    if found.quantity == "heading":
        quarter = round(QUARTER / unit.factor, 9)
        text = f"Which way does {name!r} count? No other channel tells it."
        return ask_sign(found, text, [
            ("clockwise", "clockwise from north, as a compass", {}),
            ("counterclockwise from east", "counterclockwise from east (ENU)", {"offset": quarter, "sign": -1}),
            ("counterclockwise from north", "counterclockwise from north", {"sign": -1}),
        ])  # fmt: skip
    quantity = str(found.quantity)
    (key, said), (other, against) = WAYS.get(quantity, TO_SIDES)
    text = f"Which way is {name!r} positive?"
    if quantity == "rudder_command":
        text += " The rudder does not follow it clearly."
    elif quantity not in WAYS or quantity.startswith("roll"):
        text = f"Which way is {name!r} ({quantity.replace('_', ' ')}) positive? No other channel tells it."
    return ask_sign(found, text, [(key, said, {}), (other, against, {"sign": -1})])


def against_track(log: RawLog, found: ColumnFinding) -> str:
    """What contradicts the way that a heading counts; '' where nothing does."""
    series = log.series(found)
    if series is None:
        return ""
    for name, north, east in log.tracks():
        told = sense(series, north, east)
        if told is None:
            continue
        if told[0] == "against":
            return f"it turns against {name}"
        if abs(told[1]) > 1.0:
            return f"{name} lead {math.degrees(told[1]):+.0f} deg away from it"
    return ""


def turns_against(log: RawLog, found: ColumnFinding) -> str:
    """The velocities to north and east whose course turns against a heading; '' where none does."""
    series = log.series(found)
    for first, north in log.all("velocity_north") if series is not None else ():
        for second, east in log.all("velocity_east"):
            told = sense(series, north, east) if first.table is second.table and series is not None else None
            if told is not None and told[0] == "against":
                return f"{first.column.name}, {second.column.name}"
    return ""
