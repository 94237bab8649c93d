"""Units and signs that a file does not state: told by another channel, by what is physically possible, or asked."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from .evidence import (
    LEAST_TURN_RAD,
    ClockSeries,
    as_of_one_clock,
    body,
    cosine,
    follows,
    nearest,
    rate_ratio,
    sense,
    size_ratio,
    slope,
    sum_with_course,
    together,
    track_velocity,
)
from .finding import EITHER_SIDE, ColumnFinding, ask_scale, ask_sign, ask_unit, is_full_circle
from .log import RawLog, speeds
from .names import words
from .quantities import UNITS, LogUnit, candidates, quantities
from .reading import ask_foreign, frame_stated

LARGEST_RAD = {"rudder": 1.65, "rudder_command": 1.65, "roll": 1.6, "latitude": math.pi / 2.0, "longitude": 3.15,
               "magnetic_variation": 3.15, "magnetic_deviation": 1.6}  # fmt: skip
FULL_TURN, MANY_TURNS, UNWRAPPED = 6.3, 200.0, 40.0
"""Largest size of an angle, rad, in a column without a unit, in one with, which may go on turning, and in one without
that does."""
FASTEST_M_S, FASTEST_RAD_S, FASTEST_RPS = 60.0, 3.5, 100.0
LARGEST_RUDDER_DEG = 95.0
ALONG, NEARER = 0.95, 0.2
"""Mean cosine of course and track from which on they go together, and how near to one it is against another unit's."""
COPY = 1e-3
"""Largest difference, as a share of its largest number, of a column that is a copy of another one."""
WITHIN = {"angular rate": 0.25, "speed": 0.07, "length": 0.1, "angle": 0.2}
"""How near to a unit's factor the ratio to another channel must be."""
CLEARLY = 0.25
"""How much nearer one pair of units must fit than the next one: degrees and degrees a minute are 5 % from radians and
degrees a second."""
WITHIN_AVERAGED = 0.2
"""The same of a velocity to north or east beside that of a track, a mean over some seconds."""
WRAPPING = ("heading", "heading_magnetic", "course_over_ground")
"""Directions."""
SPEEDS = ("speed_over_ground", "speed_through_water", "surge")
FAR = 3.0
"""How much more a direction from the bow must move than what it is over ground."""


NO_NUMBERS = ("no numbers in the column",)
"""Why a column of texts is not used."""
WORDS_FOR_ANGLES = ("angle", " ang ", "winkel", "vinkel", "lage", "角", "ángulo", "angulo", "rsa")
"""Parts of the name of a rudder that is an angle."""


def unit_by_channel(log: RawLog, found: ColumnFinding) -> ColumnFinding:
    """The finding with the unit that another channel tells; unchanged where none does."""
    raw = log.series(found, raw=True) if found.quantity is not None and found.unit is None else None
    if raw is None:
        return found
    if found.foreign:  # a rudder in per cent or volts
        other = "rudder_command" if found.quantity == "rudder" else "rudder"
        for own, series in log.all(other, signed=False):
            if size := slope(series, raw):
                factor = float(f"{math.degrees(size):.3g}")
                why = f"one is {factor:g} deg: agrees with column {own.column.name}"
                return found.told("other channel", why, unit=UNITS["deg"], factor=factor, foreign="")
        return found
    copied = _by_copy(log, found, raw) or _by_course(log, found, raw) or _by_turns(log, found, raw)
    if copied is not None:
        return copied
    dimension = found.dimension
    averaged = found.quantity in ("velocity_north", "velocity_east")
    for name, size in sizes(log, found, raw):
        unit = nearest(size / found.factor, candidates(dimension), WITHIN_AVERAGED if averaged else WITHIN[dimension])
        if unit is not None:
            return found.told("other channel", f"{unit.name}: agrees with {name}", unit=unit)
        tenth = nearest(10.0 * size / found.factor, candidates(dimension), WITHIN[dimension])
        if tenth is not None and dimension == "speed" and not np.any(np.nan_to_num(found.column.numbers) % 1.0):
            factor = 0.1 * found.factor
            return found.told("other channel", f"0.1 {tenth.name}: agrees with {name}", unit=tenth, factor=factor)
    return found


def _by_copy(log: RawLog, found: ColumnFinding, raw: ClockSeries) -> ColumnFinding | None:
    """The finding of an angle that another column holds in another unit, with the unit that their factor tells."""
    for other in log.findings if found.dimension == "angle" else ():
        pair = other is not found and bool(set(found.may_be) & set(other.may_be)) and other.column.numeric
        series = log.series(other, raw=True) if pair and not other.foreign else None
        shared = together(series, raw) if series is not None else None
        if shared is None:
            continue
        _, a, b = shared
        power, size = float(b @ b), float(np.abs(a).max())
        factor = float(a @ b) / power if power > 0.0 else 0.0
        if not factor or not float(np.abs(a - factor * b).max()) < COPY * size:
            continue
        for own, its in itertools.permutations((UNITS["deg"], UNITS["rad"]), 2):
            if abs(abs(factor) * its.factor / own.factor - 1.0) < COPY and other.unit in (None, its):
                why = f"{own.name}: column {other.column.name} is the same in {its.name}"
                return found.told("other channel", why, unit=own)
    return None


def _by_course(log: RawLog, found: ColumnFinding, raw: ClockSeries) -> ColumnFinding | None:
    """The finding of a course or heading with the one unit in which it goes along a track."""
    if found.quantity not in ("course_over_ground", "heading"):
        return None
    courses: list[tuple[str, tuple[ClockSeries, ...]]] = [(name, (course,)) for name, course in log.turns()]
    for name, course in log.turns(log.axes()):  # which may be exchanged
        courses.append((name, (course, replace(course, values=math.pi / 2.0 - course.values))))
    for name, senses in courses:
        fits: dict[str, float] = {}
        for course, unit in itertools.product(senses, (UNITS["deg"], UNITS["rad"])):
            shared = together(course, raw)
            if shared is not None and np.isfinite(shared[1]).any():
                along = float(np.nanmean(np.exp(1j * (shared[1] - unit.factor * shared[2]))).real)
                fits[unit.name] = max(along, fits.get(unit.name, -1.0))
        best, other = sorted(fits, key=lambda unit: -fits[unit]) if fits else ("", "")
        if fits and fits[best] > ALONG and 1.0 - fits[best] < NEARER * (1.0 - fits[other]):
            return found.told("other channel", f"{best}: goes along the track of {name}", unit=UNITS[best])
    return None


def _by_turns(log: RawLog, found: ColumnFinding, raw: ClockSeries) -> ColumnFinding | None:
    """The finding of a heading or yaw rate beside the other one, both without a unit, where one pair of units alone
    makes their turns alike."""
    other = {"heading": "yaw_rate", "yaw_rate": "heading"}.get(str(found.quantity))
    for beside in (f for f in log.findings if other and f.quantity == other and f.unit is None and not f.foreign):
        series = log.series(beside, raw=True)
        if series is None or not _goes_on(found if other == "yaw_rate" else beside):
            continue
        heading, rate = (raw, series) if other == "yaw_rate" else (series, raw)
        size = rate_ratio(heading, rate)
        able = itertools.product((UNITS["deg"], UNITS["rad"]), candidates("angular rate")) if size else ()
        misfits = [(abs(abs(size or 0.0) * angle.factor / unit.factor - 1.0), (angle, unit)) for angle, unit in able]
        near = sorted((m for m in misfits if m[0] < WITHIN["angular rate"]), key=lambda misfit: misfit[0])
        if near and all(near[0][0] < CLEARLY * misfit for misfit, _ in near[1:]):
            unit = near[0][1][other == "heading"]
            said = f"{unit.name}: in no other unit are its turns those of column {beside.column.name}"
            return found.told("other channel", said, unit=unit)
    return None


def without_wind_from_bow(log: RawLog) -> None:
    """Leave out a wind whose direction turns back as the ship turns, as the apparent one from the bow does."""
    for found, direction in list(log.all("wind_direction")):
        heading = next((series for f, series in log.all("heading") if f.table.clock == found.table.clock), None)
        shared = together(heading, direction, angle_first=True, angle_second=True) if heading is not None else None
        if shared is None or np.ptp(shared[1]) < LEAST_TURN_RAD or found.column.known or "quantity" in found.bounded:
            continue
        # how far angles are from all being one
        stays, turns = (1.0 - abs(np.mean(np.exp(1j * angle))) for angle in (shared[1] + shared[2], shared[2]))
        why = "it turns back as the ship turns: a wind that counts from the bow"
        for own in (
            [f for f in log.findings if f.quantity in ("wind_direction", "wind_speed")] if turns > FAR * stays else []
        ):
            log.change(own, own.unused(why) if own.table is found.table else own)


def sizes(log: RawLog, found: ColumnFinding, raw: ClockSeries) -> Iterator[tuple[str, float]]:
    """(name of another channel, SI units for one of the column's numbers)."""
    return ((name, abs(size)) for name, size in ratios(log, found, raw) if size)


def ratios(
    log: RawLog, found: ColumnFinding, raw: ClockSeries, signed: bool = False
) -> Iterator[tuple[str, float | None]]:
    """(name of another channel, its ratio to the column's numbers); None where they do not go together.

    signed : of channels whose sign is known.  Those on the clock of the column come first.
    """
    quantity = str(found.quantity)

    def columns(*wanted: str) -> Iterator[tuple[str, ClockSeries]]:
        others = sorted(log.all(*wanted, signed=signed), key=lambda pair: pair[1].clock != raw.clock)
        return ((f"column {f.column.name}", series) for f, series in others)

    if quantity == "yaw_rate":
        yield from ((name, rate_ratio(angle, raw)) for name, angle in columns("heading", "heading_magnetic"))
        yield from ((f"the turning of {name}", rate_ratio(course, raw)) for name, course in log.turns())
    elif quantity == "roll_rate":
        yield from ((name, rate_ratio(roll, raw)) for name, roll in columns("roll"))
    elif quantity in ("heading", "heading_magnetic", "course_over_ground", "roll"):
        for name, rate in columns("roll_rate" if quantity == "roll" else "yaw_rate"):
            size = rate_ratio(raw, rate)
            yield name, size and 1.0 / size
    elif quantity in ("rudder", "rudder_command"):
        other = "rudder_command" if quantity == "rudder" else "rudder"
        yield from ((name, slope(angle, raw)) for name, angle in columns(other))
    elif quantity in SPEEDS:
        for name, speed in speeds([*log.tracks(), *log.axes()]):
            yield f"the speed of {name}", size_ratio(speed, raw)
        yield from ((name, size_ratio(speed, raw)) for name, speed in columns(*SPEEDS))
    elif quantity in ("velocity_north", "velocity_east"):
        for name, north, east in log.tracks():
            yield name, slope(north if quantity == "velocity_north" else east, raw)
    elif quantity in ("north", "east"):  # the speed along both positions of the table, in their unit
        other = "east" if quantity == "north" else "north"
        pair = next((f for f in log.findings if f.quantity == other and f.table is found.table), None)
        second = log.series(pair, raw=True) if pair is not None else None
        velocity = track_velocity(raw, second) if second is not None else None
        for _, track in speeds([("", *velocity)]) if velocity is not None else ():
            yield from ((name, size_ratio(speed, track)) for name, speed in columns("speed_over_ground", "surge"))


def size_of(found: ColumnFinding) -> float:
    """The 99 % quantile of the sizes of the numbers."""
    numbers = found.factor * found.column.numbers
    if found.may_be[:1] and found.may_be[0] in EITHER_SIDE and is_full_circle(found):
        turn = 360.0 if np.nanmax(numbers) > 7.0 else 2.0 * math.pi
        numbers = (numbers + turn / 2.0) % turn - turn / 2.0
    known = np.abs(numbers[np.isfinite(numbers)])
    return float(np.quantile(known, 0.99)) if known.size else 0.0


def by_physics(log: RawLog, found: ColumnFinding) -> ColumnFinding:
    """The finding with the only unit that is possible, where there is only one."""
    if found.quantity is None or found.unit is not None or found.foreign or found.unread:
        return found
    if not np.isfinite(found.column.numbers).any():
        if found.quantity in ("latitude", "longitude") and found.column.first(1):
            return found.told("stated", "degrees and minutes, as the cells show", unit=UNITS["deg min"])
        return found.unused(*NO_NUMBERS)
    if found.quantity in WRAPPING and in_tenths(found) and np.abs(np.diff(found.column.finite)).max() > 3000.0:
        why = "whole numbers that jump by 3600 can only be tenths of a degree"
        return found.told("physics", why, unit=UNITS["deg"], factor=0.1 * found.factor)
    unit, why = _possible(log, found)
    return found.told("physics", why, unit=unit) if unit is not None else found


def _possible(log: RawLog, found: ColumnFinding) -> tuple[LogUnit | None, str]:
    quantity, size = str(found.quantity), size_of(found)
    told = f"values up to {size:.6g} can only be"
    if quantity in ("latitude", "longitude"):
        least, other, limit = (90.0, "longitude", 180.0) if found.quantity == "latitude" else (180.0, "latitude", 90.0)
        numbers = found.column.finite
        if least * 1.0001 < size <= 100.0 * least and np.all(np.abs(numbers) % 100.0 < 60.0):
            return UNITS["deg min"], f"{told} degrees and minutes (ddmm.mmm)"
        if 1e6 < size <= least * 1e7 and np.all(numbers == np.round(numbers)):
            return UNITS["1e-7 deg"], f"{told} 1e-7 degrees"
        if size > least * 1.0001:
            return None, ""
        pairs = [f for f in log.findings if f.quantity == other and f.table is found.table]
        for beside in pairs:
            if beside.unit is not None:
                return beside.unit, f"{beside.unit.name}, as column {beside.column.name} beside it"
        # the other coordinate, without a unit yet, can only be degrees and minutes, or could be
        minutes = bool(pairs) and size_of(pairs[0]) > limit * 1.0001
        sure = size > LARGEST_RAD[str(found.quantity)] * 1.01 and not minutes
        return (UNITS["deg"], f"{told} degrees") if sure else (None, "")
    if quantity in ("rudder", "rudder_command"):
        said = f"{found.column.name.lower()} {' '.join(words(found.column.name))} "
        angle = any(word in said for word in WORDS_FOR_ANGLES)
        return (UNITS["deg"], f"{told} degrees") if angle and 1.65 < size <= LARGEST_RUDDER_DEG else (None, "")
    if quantity == "roll" and is_full_circle(found):
        radians = np.nanmax(found.column.numbers) < 7.0
        shares = found.column.numbers / (2.0 * math.pi if radians else 360.0)
        if float(np.nanmean((shares > 0.25) & (shares < 0.75))) < 0.01:  # at both ends, and not between them
            return UNITS["rad" if radians else "deg"], f"{told} a full circle round zero"
    if found.dimension == "angle":
        if found.may_be[0] in WRAPPING and in_tenths(found):
            return None, ""
        most = LARGEST_RAD.get(quantity, UNWRAPPED if _goes_on(found) else FULL_TURN)
        return (UNITS["deg"], f"{told} degrees") if most < size <= 3600.0 and size > 1.02 * most else (None, "")
    if quantity == "propeller" and size > 110.0:
        return UNITS["rpm"], f"{told} revolutions a minute"
    return None, ""


def in_tenths(found: ColumnFinding) -> bool:
    """Whether whole numbers beyond a turn may be tenths of a degree: a direction jumps by ten turns, or by none."""
    known = found.column.finite
    if not known.size or np.any(known % 1.0) or not 361.0 < known.max() <= 3600.0 or known.min() < 0.0:
        return False
    jumps = np.abs(np.diff(known))
    return not np.any((jumps > 180.0) & (jumps < 3000.0))


def _goes_on(found: ColumnFinding) -> bool:
    """Whether a direction never jumps back by a turn: in radians it may be beyond one."""
    known = found.column.finite
    return quantities()[str(found.quantity)].wraps and bool(np.abs(np.diff(known)).max(initial=0.0) < math.pi)


def impossible(found: ColumnFinding) -> bool:
    """Whether the numbers cannot be in the unit that is stated."""
    known = found.column.finite
    if found.unit is None or found.quantity is None or not known.size or found.unit.name == "deg min":
        return False
    size = size_of(found) * found.unit.factor
    if found.dimension == "angle":
        wraps = quantities()[found.quantity].wraps
        # a direction that begins some turns away from 0 and makes few of them is in degrees
        far = abs(known[0]) > 4.0 * math.pi and np.ptp(known) < 8.0 * math.pi + abs(known[0])
        most = MANY_TURNS if wraps else LARGEST_RAD.get(found.quantity, FULL_TURN)
        return bool(wraps and found.unit.name == "rad" and far) or size > 1.02 * most
    limits = {"speed": FASTEST_M_S, "angular rate": FASTEST_RAD_S, "rotation": FASTEST_RPS}
    return size > limits.get(found.dimension, math.inf)


def possible(found: ColumnFinding) -> list[LogUnit] | None:
    """The units in which the numbers can be; None where they can be in none."""
    able = [unit for unit in candidates(found.dimension) if not impossible(replace(found, unit=unit))]
    return able or None


def ask_for_unit(found: ColumnFinding) -> ColumnFinding:
    """The finding with the question for its unit; of a rudder degrees or radians, or a share of the largest angle: per
    cent, or -1 to 1."""
    name, size = found.column.name, size_of(found)
    if found.foreign:
        return ask_foreign(found)
    text = f"What is the unit of {name!r} ({str(found.quantity).replace('_', ' ')}, values up to {size:.4g})?"
    text += f" {found.unread!r} is no unit that is known." if found.unread else ""
    of_rudder = found.quantity in ("rudder", "rudder_command")
    if of_rudder and size <= 110.0:
        full = 1.0 if size <= 1.05 else 100.0
        number = f"degrees at {full:g}, where it is a share of the largest angle"
        scaled = ask_scale(found, text, number, "deg", (35.0,), full)
        *units, unused = ask_unit(found, text, possible(found)).questions[-1].answers
        share = replace(scaled.questions[-1].answers[0], text=f"a share of 35 deg, {full:g} is the whole")
        question = replace(scaled.questions[-1], answers=(*units, share, unused))
        return replace(scaled, questions=(*found.questions, question))
    whole = not np.any(found.column.finite % 1.0)
    rudder = of_rudder and size <= 10.0 * LARGEST_RUDDER_DEG
    if whole and found.dimension == "angle" and (rudder or (found.quantity in WRAPPING and in_tenths(found))):
        text = f"{text} Is one of the file a tenth of a degree, or a degree?"
        return ask_scale(found, text, "degrees of one of the file", "deg", (0.1, 1.0), 1.0)
    return ask_unit(found, text, possible(found))


# ---- Signs that a file does not state: told by another channel, or asked.

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


def sign_by_channel(log: RawLog, found: ColumnFinding) -> ColumnFinding:
    """The finding with the sign that another channel tells; unchanged where none does."""
    if found.signed or found.quantity is None or found.unit is None:
        return found
    ways = {"heading": _heading, "yaw_rate": _rate, "sway": _along, "surge": _along, "roll_rate": _rate}
    way = ways.get(found.quantity)
    return way(log, found) if way is not None else found


def _heading(log: RawLog, found: ColumnFinding) -> ColumnFinding:
    frame = frame_stated(found.table.notes)
    if frame and found.unit is not None:
        quarter = round(QUARTER / found.unit.factor, 9)
        turned = {"enu": {"sign": -1, "offset": quarter}, "nwu": {"sign": -1}}.get(frame, {})
        return found.told("stated", f"the file states axes {frame.upper()}", signed=True, **turned)
    series = log.series(found)
    if series is None:
        return found
    for name, north, east in log.tracks():
        told = sense(series, north, east)
        if told is not None:
            return _with_sense(found, told, f"agrees with {name}")
    # of yaw rates those whose sign is stated, or told by a track
    by = ("positive to", "turning of", "states it")
    sure = (
        (f, s) for f, s in log.all("yaw_rate") if f.side or f.column.known or any(x in w for w in f.why for x in by)
    )
    rates = ((f, rate_ratio(series, s)) for f, s in sure)
    others = ((f, slope(s, series)) for f, s in log.all("heading") if f is not found)
    for other, ratio in itertools.chain(rates, others):
        if ratio is not None:
            why = f"turns with {other.column.name}"
            tracks = list(log.tracks()) if ratio < 0.0 else []  # which tell from which direction it counts
            for name, north, east in tracks:
                angle = sum_with_course(series, north, east)
                if angle is not None:
                    return _with_sense(found, ("against", angle), f"{why}, and agrees with {name}")
            return found if tracks else _as_ratio(found, ratio, why)
    return found


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
    for name, ratio in ratios(log, found, series, signed=True) if series is not None else ():
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


def as_rudder(log: RawLog, found: ColumnFinding) -> ColumnFinding:
    """A rudder command with the sign of the rudder, as both state their sides, or as the rudder follows it."""
    if found.quantity != "rudder_command" or found.signed:
        return found
    side = next((f.side for f in log.findings if f.quantity == "rudder" and f.side), "")
    if side and found.side:
        same = side == found.side
        return found.told("stated", f"positive to {found.side}", signed=True, sign=1 if same else -1)
    series = log.series(found) if found.unit is not None else None
    other = log.first("rudder")
    if other is None:
        return replace(found, signed=True)
    told = follows(as_of_one_clock(other[1], series), series) if series is not None else None
    if told is None:
        return found
    return _as_ratio(found, told, f"{'' if told > 0 else 'turned round: '}column {other[0].column.name} follows it")


def checked(log: RawLog, found: ColumnFinding) -> ColumnFinding:
    """The finding, with a question for its sign where a track or a heading contradicts the one that is stated."""
    name, quantity, series = found.column.name, str(found.quantity), log.series(found)
    if series is None:
        return found
    if quantity == "heading":
        for track, north, east in log.tracks():
            way = sense(series, north, east)
            if way is not None and (way[0] == "against" or abs(way[1]) > 1.0):
                lead = f"{track} lead {math.degrees(way[1]):+.0f} deg away from it"
                against = f"it turns against {track}" if way[0] == "against" else lead
                asked = ask_for_sign(log, replace(found, signed=False, sign=1, offset=0.0))
                text = f"Which way does {name!r} count? {against}."
                return replace(asked, questions=(replace(asked.questions[-1], text=text),))
        return found
    if quantity == "yaw_rate":
        headings = sorted(log.all("heading"), key=lambda pair: pair[1].clock != series.clock)
        ratios = ((rate_ratio(angle, series), repr(f.column.name)) for f, angle in headings)
        told = next(((ratio > 0.0, f"{said} says") for ratio, said in ratios if ratio is not None), None)
    else:
        moving = quantity in ("surge", "sway") and not found.column.known
        by = by_track(log, found) if moving else None
        told = None if by is None else (by[0] == found.sign, f"{by[1]} with the heading say")
    if told is None or told[0]:
        return found
    text = f"{name!r} is said to be {found.convention}, and {told[1]} the opposite: which way is it positive?"
    same, other = WAYS.get(quantity, TO_SIDES)
    answers = [(*same, {"sign": 1}), (*other, {"sign": -1})]
    return ask_sign(replace(found, signed=False), text, answers if quantity == "yaw_rate" else answers[::-1])


def ask_open(log: RawLog, found: ColumnFinding) -> ColumnFinding:
    """The finding with the question for its sign, if it is open and nothing tells it."""
    if found.quantity is None or found.unit is None or found.signed or found.questions:
        return found
    told = as_rudder(log, sign_by_channel(log, found))
    return told if told.signed else ask_for_sign(log, told)


def ask_for_sign(log: RawLog, found: ColumnFinding) -> ColumnFinding:
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
