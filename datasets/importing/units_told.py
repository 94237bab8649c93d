"""Units that a file does not state: told by another channel, by what is physically possible, or asked."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from .evidence import ClockSeries, nearest, rate_ratio, size_ratio, slope, together, track_velocity
from .finding import EITHER_SIDE, ColumnFinding, ask_scale, ask_unit, is_full_circle
from .log import RawLog, speeds
from .quantities import quantities
from .reading import ask_foreign
from .units import UNITS, LogUnit, candidates

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
WITHIN_AVERAGED = 0.2
"""The same of a velocity to north or east beside that of a track, a mean over some seconds."""
WRAPPING = ("heading", "heading_magnetic", "course_over_ground")
"""Directions."""
SPEEDS = ("speed_over_ground", "speed_through_water", "surge")


def by_channel(log: RawLog, found: ColumnFinding) -> ColumnFinding:
    """The finding with the unit that another channel tells; unchanged where none does."""
    if found.quantity is None or found.unit is not None:
        return found
    raw = log.series(found, raw=True)
    if raw is None:
        return found
    if found.foreign:
        return _rudder_scale(log, found, raw)
    copied = _by_copy(log, found, raw) or _by_course(log, found, raw) or _by_turns(log, found, raw)
    if copied is not None:
        return copied
    dimension = quantities()[found.quantity].dimension
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
    if found.dimension != "angle":
        return None
    for other in log.findings:
        pair = other is not found and bool(set(found.may_be) & set(other.may_be)) and other.column.numeric
        series = log.series(other, raw=True) if pair and not other.foreign else None
        size = copy_factor(series, raw) if series is not None else None
        for own, its in itertools.permutations((UNITS["deg"], UNITS["rad"]), 2):
            fits = size is not None and abs(abs(size) * its.factor / own.factor - 1.0) < COPY
            if fits and other.unit in (None, its):
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
        pairs = [
            (angle, unit)
            for angle in (UNITS["deg"], UNITS["rad"])
            for unit in candidates("angular rate")
            if size and abs(abs(size) * angle.factor / unit.factor - 1.0) < WITHIN["angular rate"]
        ]
        if len(pairs) == 1:
            unit = pairs[0][other == "heading"]
            said = f"{unit.name}: in no other unit are its turns those of column {beside.column.name}"
            return found.told("other channel", said, unit=unit)
    return None


def copy_factor(one: ClockSeries, other: ClockSeries) -> float | None:
    """What the second series is to be multiplied by to be the first; None where it is no copy."""
    shared = together(one, other)
    if shared is None:
        return None
    _, a, b = shared
    power, size = float(b @ b), float(np.abs(a).max())
    factor = float(a @ b) / power if power > 0.0 else 0.0
    return factor if factor and float(np.abs(a - factor * b).max()) < COPY * size else None


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
    elif quantity in ("north", "east") and (track := _track_speed(log, found)) is not None:
        yield from ((name, size_ratio(speed, track)) for name, speed in columns("speed_over_ground", "surge"))


def _track_speed(log: RawLog, found: ColumnFinding) -> ClockSeries | None:
    """The speed of a position in a plane and of the other one of its table, in their unit."""
    other = "east" if found.quantity == "north" else "north"
    pair = next((f for f in log.findings if f.quantity == other and f.table is found.table), None)
    one, two = (log.series(f, raw=True) if f is not None else None for f in (found, pair))
    velocity = track_velocity(one, two) if one is not None and two is not None else None
    return next((speed for _, speed in speeds([("", *velocity)])), None) if velocity is not None else None


def _rudder_scale(log: RawLog, found: ColumnFinding, raw: ClockSeries) -> ColumnFinding:
    """Degrees for one of a rudder in per cent or volts, where another rudder channel tells them."""
    other = "rudder_command" if found.quantity == "rudder" else "rudder"
    for own, series in log.all(other, signed=False):
        size = slope(series, raw)
        if size:
            factor = float(f"{math.degrees(size):.3g}")
            why = f"one is {factor:g} deg: agrees with column {own.column.name}"
            return found.told("other channel", why, unit=UNITS["deg"], factor=factor, foreign="")
    return found


# ------------------------------------------------------------------------------------------------ physics


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
        return _texts(found)
    if found.quantity in WRAPPING and in_tenths(found) and np.abs(np.diff(found.column.finite)).max() > 3000.0:
        why = "whole numbers that jump by 3600 can only be tenths of a degree"
        return found.told("physics", why, unit=UNITS["deg"], factor=0.1 * found.factor)
    unit, why = _possible(log, found)
    return found.told("physics", why, unit=unit) if unit is not None else found


def _texts(found: ColumnFinding) -> ColumnFinding:
    if found.quantity in ("latitude", "longitude") and found.column.first(1):
        return found.told("stated", "degrees and minutes, as the cells show", unit=UNITS["deg min"])
    return found.unused("no numbers in the column")


def _possible(log: RawLog, found: ColumnFinding) -> tuple[LogUnit | None, str]:
    quantity, size = str(found.quantity), size_of(found)
    told = f"values up to {size:.6g} can only be"
    if quantity in ("latitude", "longitude"):
        return _of_position(log, found, size, told)
    if quantity in ("rudder", "rudder_command"):
        angle = _names_angle(found)
        return (UNITS["deg"], f"{told} degrees") if angle and 1.65 < size <= LARGEST_RUDDER_DEG else (None, "")
    if quantity == "roll" and is_full_circle(found) and _jumps(found):
        return UNITS["rad" if np.nanmax(found.column.numbers) < 7.0 else "deg"], f"{told} a full circle round zero"
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


def _jumps(found: ColumnFinding) -> bool:
    """Whether angles lie at both ends of the full circle and not between them."""
    shares = found.column.numbers / (2.0 * math.pi if np.nanmax(found.column.numbers) < 7.0 else 360.0)
    return float(np.nanmean((shares > 0.25) & (shares < 0.75))) < 0.01


def _names_angle(found: ColumnFinding) -> bool:
    """Whether the name says that it is an angle."""
    name = found.column.name.lower()
    return any(word in name for word in ("angle", "winkel", "vinkel", "lage", "角", "ángulo", "angulo", "rsa"))


def _of_position(log: RawLog, found: ColumnFinding, size: float, told: str) -> tuple[LogUnit | None, str]:
    least = 90.0 if found.quantity == "latitude" else 180.0
    numbers = found.column.finite
    if least * 1.0001 < size <= 100.0 * least and np.all(np.abs(numbers) % 100.0 < 60.0):
        return UNITS["deg min"], f"{told} degrees and minutes (ddmm.mmm)"
    if 1e6 < size <= least * 1e7 and np.all(numbers == np.round(numbers)):
        return UNITS["1e-7 deg"], f"{told} 1e-7 degrees"
    if size > least * 1.0001:
        return None, ""
    other = "longitude" if found.quantity == "latitude" else "latitude"
    beside = next((f for f in log.findings if f.quantity == other and f.table is found.table and f.unit), None)
    if beside is not None and beside.unit is not None:
        return beside.unit, f"{beside.unit.name}, as column {beside.column.name} beside it"
    return (
        (UNITS["deg"], f"{told} degrees")
        if size > LARGEST_RAD[str(found.quantity)] * 1.01 and not _minutes(log, found)
        else (None, "")
    )


def _minutes(log: RawLog, found: ColumnFinding) -> bool:
    """Whether the other coordinate can only be degrees and minutes, or has no unit yet and could be."""
    other = "longitude" if found.quantity == "latitude" else "latitude"
    beside = next((f for f in log.findings if f.quantity == other and f.table is found.table), None)
    limit = 180.0 if other == "longitude" else 90.0
    return beside is not None and beside.unit is None and size_of(beside) > limit * 1.0001


def impossible(found: ColumnFinding) -> bool:
    """Whether the numbers cannot be in the unit that is stated."""
    if found.unit is None or found.quantity is None or not np.isfinite(found.column.numbers).any():
        return False
    size = size_of(found) * found.unit.factor
    if found.unit.name == "deg min":
        return False
    if found.dimension == "angle":
        wraps = quantities()[found.quantity].wraps
        if wraps and found.unit.name == "rad" and _begins_far(found.column.finite):
            return True
        return size > 1.02 * (MANY_TURNS if wraps else LARGEST_RAD.get(found.quantity, FULL_TURN))
    most = {"speed": FASTEST_M_S, "angular rate": FASTEST_RAD_S, "rotation": FASTEST_RPS}
    return size > most.get(found.dimension, math.inf)


def _begins_far(known: np.ndarray) -> bool:
    """Whether a direction, as radians, begins some turns away from 0, as one in degrees does, and makes few of them."""
    return bool(abs(known[0]) > 4.0 * math.pi and np.ptp(known) < 8.0 * math.pi + abs(known[0]))


def possible(found: ColumnFinding) -> list[LogUnit] | None:
    """The units in which the numbers can be; None where they can be in none."""
    able = [unit for unit in candidates(found.dimension) if not impossible(replace(found, unit=unit))]
    return able or None


# ------------------------------------------------------------------------------------------------ questions


def ask(found: ColumnFinding) -> ColumnFinding:
    """The finding with the question for its unit."""
    name, size = found.column.name, size_of(found)
    if found.foreign:
        return ask_foreign(found)
    text = f"What is the unit of {name!r} ({str(found.quantity).replace('_', ' ')}, values up to {size:.4g})?"
    text += f" {found.unread!r} is no unit that is known." if found.unread else ""
    if found.quantity in ("rudder", "rudder_command") and size <= 110.0:
        return _ask_rudder(found, text, size)
    whole = not np.any(found.column.finite % 1.0)
    rudder = found.quantity in ("rudder", "rudder_command") and size <= 10.0 * LARGEST_RUDDER_DEG
    if whole and found.dimension == "angle" and (rudder or (found.quantity in WRAPPING and in_tenths(found))):
        text = f"{text} Is one of the file a tenth of a degree, or a degree?"
        return ask_scale(found, text, "degrees of one of the file", "deg", (0.1, 1.0), 1.0)
    return ask_unit(found, text, possible(found))


def _ask_rudder(found: ColumnFinding, text: str, size: float) -> ColumnFinding:
    """Degrees or radians, or a share of the largest angle: per cent, or -1 to 1."""
    full = 1.0 if size <= 1.05 else 100.0
    number = f"degrees at {full:g}, where it is a share of the largest angle"
    scaled = ask_scale(found, text, number, "deg", (35.0,), full)
    *units, unused = ask_unit(found, text, possible(found)).questions[-1].answers
    share = replace(scaled.questions[-1].answers[0], text=f"a share of 35 deg, {full:g} is the whole")
    question = replace(scaled.questions[-1], answers=(*units, share, unused))
    return replace(scaled, questions=(*found.questions, question))
