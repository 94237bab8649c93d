"""What a name that may mean several things means, and which of two columns of one quantity is used."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np

from ..geometry import on_plane
from ..signals import integral
from . import other_channels
from .by_motion import smooth, straight
from .draft import NOT_USED, Answer, Question, Sure
from .evidence import (
    LEAST_TURN_RAD,
    ClockSeries,
    body,
    correlation,
    cosine,
    sense,
    size_ratio,
    slope,
    together,
    track_velocity,
)
from .finding import WITH_SIDE, ColumnFinding, ask_quantity, identifier, line_of
from .log import RawLog, speeds
from .quantities import UNITS, is_unsigned, quantities
from .reading import frame_stated

ALIKE = {"angle": math.radians(2.0), "angular rate": math.radians(0.3), "speed": 0.25, "length": 5.0, "rotation": 0.1}
"""How far two columns of a quantity may be from each other (root mean square) to be the same."""
TRACKED = 0.15
"""How near the velocity of a track, which is a mean over some seconds, must be to a component of it, as a share."""
STILL = 0.03
"""How far one of two columns moves, as a share of the other, up to which it does not."""
OF_SHIP = "along the ship's axes: the direction goes with the yaw rate, not with the heading"
"""Why a velocity is one along an axis of the ship."""
AHEAD, DRIFT = 0.7, 0.5
"""Least mean cosine of the drift angle of velocities along the ship's axes, and most of its variance that the yaw rate
leaves."""
TURNED, WITHOUT_DRIFT = 0.9, 0.999
"""Shares of an angle that the integral of a yaw rate explains: of a heading, and of one that cannot be a course."""
MOSTLY, NEARER = 0.8, 0.1
"""Of a course over ground: least share that the integral of a yaw rate explains, and variance about a track, as a share
of that which the yaw rate leaves."""
LED, LEAST_LEAD_RAD, LEAST_LEAD_S = 0.6, 0.015, 3.0
"""Share of the angle between a heading and the course that its rate explains, the least size of that angle, rad, and of
that over the rate, s: a course of positions that are late by less is none."""
ON_EARTH = "it stays within a metre, if its numbers are metres: degrees"
STANDS, STANDS_S, FAR_OFF = 1.0, 60.0, 100.0
"""Range of numbers of two positions from which on they can be metres, in so many seconds; how far from 0 they are then,
as a multiple of it."""
SAME_EVER, OVER_S = 0.025, 10.0
"""How near it must be at all times (root mean square, as a share), over so many seconds."""
LEAST_ARM_M, NEARER_RATE = 1.0, 0.5
"""Distance of two places of a ship from which on their speeds sideways are not one; variance of their difference that
the yaw rate leaves, as a share of that which either speed leaves."""
SAME = 0.04
"""How near a speed must be to that of the track to be over ground."""


def settle(log: RawLog, found: ColumnFinding) -> ColumnFinding:
    """The finding with the quantity that other columns tell; unchanged where they do not."""
    if len(found.may_be) < 2 or found.questions:
        return found
    if set(found.may_be) == {"north", "east"}:
        return _axis(log, found)
    if {*found.may_be} & {"velocity_north", "velocity_east"}:
        # a velocity that is that of a track to north or to east, and not both; or one along the ship's own axes
        series = None if found.unit is None else log.series(found)
        if series is None:
            return found
        for name, north, east in log.tracks():
            ratios = {"velocity_north": slope(north, series), "velocity_east": slope(east, series)}
            heading = next((s for f, s in log.all("heading") if f.table is found.table), None)
            parts = body(heading, north, east) if heading is not None else None
            if parts is not None:
                side = slope(parts[1], series)
                ratios |= {"surge": slope(parts[0], series), "sway": side and abs(side)}
            alike = [quantity for quantity, x in ratios.items() if x is not None and abs(x - 1.0) < TRACKED]
            if len(alike) == 1 and alike[0] in found.may_be:
                return _decided(found, alike[0], f"agrees with the velocity of {name}")
        return _of_ship(log, found)
    if "speed_over_ground" in found.may_be:
        return _speed(log, found)
    if set(found.may_be) == {"heading", "course_over_ground"}:
        return _course(log, found)
    if set(found.may_be) == {"heading", "yaw_rate"}:
        if _turned_by(log, found) > TURNED:
            return _decided(found, "heading", "it is the integral of the yaw rate")
        numbers = found.column.finite
        if numbers.size and numbers.min() >= 0.0 and numbers.max() > 100.0:
            why = f"values from {numbers.min():.4g} to {numbers.max():.4g}: a heading"
            return _decided(found, "heading", why, "physics")
    return found


def _decided(found: ColumnFinding, quantity: str, why: str, sure: Sure = "other channel") -> ColumnFinding:
    return found.told(sure, why, may_be=(quantity,), signed=is_unsigned(quantity))


def _speed(log: RawLog, found: ColumnFinding) -> ColumnFinding:
    raw = log.series(found, raw=True)
    taken = next(
        (f for f in log.findings if f.quantity == "speed_over_ground" and f.table.clock == found.table.clock), None
    )
    if raw is None or taken is not None:
        return found
    tracks = [*log.tracks(), *log.axes()]
    for name, speed in speeds(tracks):
        size = size_ratio(speed, raw)
        units = [found.unit] if found.unit is not None else [UNITS[name] for name in ("kn", "m/s", "km/h")]
        parts = (1.0, 0.1) if found.unit is None and not np.any(np.nan_to_num(found.column.numbers) % 1.0) else (1.0,)
        for unit, part in itertools.product(units, parts):
            factor = part * found.factor
            alike = size and abs(size / (unit.factor * factor) - 1.0) < SAME
            if alike and _goes_with(speed, raw, unit.factor * factor):
                decided = _decided(found, "speed_over_ground", f"speed over ground: agrees with the speed of {name}")
                said = unit.name if part == 1.0 else f"{part:g} {unit.name}"
                own = {"unit": unit, "factor": factor}
                return decided if found.unit is not None else decided.told("other channel", said, **own)
    return found


def _goes_with(speed: ClockSeries, raw: ClockSeries, size: float) -> bool:
    """Whether a speed is that of a track at all times, as one through the water is not where there is a current."""
    shared = together(speed, raw)
    if shared is None:
        return False
    wide = max(1, int(OVER_S / float(np.median(np.diff(shared[0])))))
    track, own = (smooth(values, wide) for values in (shared[1], size * shared[2]))
    return float(np.sqrt(np.mean((own - track) ** 2))) < SAME_EVER * float(np.mean(track))


def _of_ship(log: RawLog, found: ColumnFinding) -> ColumnFinding:
    """A velocity along an axis of the ship, where it and that along the other axis point ahead, but for a drift that
    goes with the yaw rate; of velocities over ground the difference from the heading, either way, goes with it."""
    own = next((quantity for quantity in ("surge", "sway") if quantity in found.may_be), "")
    wanted = {"surge": "sway", "sway": "surge"}.get(own, "")
    others = [f for f in log.findings if f.table is found.table and f is not found]
    vague = (f for f in others if wanted in f.may_be and (len(f.may_be) > 1 or OF_SHIP in f.why) and f.unit)
    other = next(vague, None)
    heading = next((s for f, s in log.all("heading", signed=False) if f.table is found.table), None)
    if not own or other is None or heading is None or any(f.quantity == own for f in others):
        return found
    pair = [log.series(f) for f in ((found, other) if own == "surge" else (other, found))]
    ahead, aside = (together(heading, s, angle_first=True) if s is not None else None for s in pair)
    if ahead is None or aside is None or ahead[1].size != aside[1].size or np.ptp(ahead[1]) < LEAST_TURN_RAD:
        return found
    course = np.unwrap(np.arctan2(aside[2], ahead[2]))
    psi = smooth(ahead[1], ahead[1].size // 60)
    rate = np.gradient(psi, ahead[0])
    along, *over_ground = (1.0 - correlation(drift, rate) ** 2 for drift in (course, course - psi, course + psi))
    if float(np.mean(np.cos(course))) > AHEAD and along < DRIFT and along < min(over_ground) / 2.0:
        return found.told("other channel", OF_SHIP, may_be=(own,), signed=own == "surge")
    return found


def _course(log: RawLog, found: ColumnFinding) -> ColumnFinding:
    """A course is a heading where the course over ground is another column, or the other way round; or where the
    integral of the yaw rate is all of it, without the drift.

    A course over ground goes much nearer along a track than along that integral.  A heading leads the course of a track
    by the drift angle, which points out of the turn and goes with its own rate; a course that is shown late lags.
    """
    turned = _turned_by(log, found)
    if turned > WITHOUT_DRIFT:
        return _decided(found, "heading", "the integral of the yaw rate is all of it")
    series = log.series(found) if found.unit is not None else None
    beside = [(name, together(series, c, angle_first=True)) for name, c in log.turns()] if series is not None else []
    known = [(name, *shared) for name, shared in beside if shared is not None and np.isfinite(shared[2]).all()]
    apart = [(name, time, own, np.angle(np.exp(1j * (own - along)))) for name, time, own, along in known]
    for name, _, own, lead in apart if turned > MOSTLY else ():
        if float(np.var(lead)) < NEARER * (1.0 - turned) * float(np.var(own)):
            return _decided(found, "course_over_ground", f"goes along {name}, the integral of the yaw rate less")
    for name, time, own, lead in apart:
        rate = np.gradient(smooth(own, max(1, own.size // 60)), time)
        with_rate = correlation(lead, rate)
        late = float(np.std(lead)) / max(float(np.std(rate)), 1e-12)
        if with_rate > 0.0 and with_rate**2 > LED and float(np.std(lead)) > LEAST_LEAD_RAD and late > LEAST_LEAD_S:
            return _decided(found, "heading", f"it leads the course of {name} as the ship turns: the drift")
    others = [f.quantity for f in log.findings if f is not found and f.table.clock == found.table.clock]
    for quantity, other in (("heading", "course_over_ground"), ("course_over_ground", "heading")):
        if other in others and quantity not in others:
            return _decided(found, quantity, f"the {other.replace('_', ' ')} is another column")
    return found


def _turned_by(log: RawLog, found: ColumnFinding) -> float:
    """Share of a direction, beyond its straight line, that the integral of a yaw rate of the same table explains; 0
    where there is none."""
    in_radians = (found.unit is not None and found.unit.name == "rad") or other_channels.size_of(found) < 7.0
    angle = log.series(found, raw=True)
    for rate in (f for f in log.findings if f.quantity == "yaw_rate" and f.table is found.table):
        series = log.series(rate, raw=True)
        if angle is None or series is None:
            continue
        turn = 2.0 * math.pi if in_radians else 360.0
        shared = together(replace(angle, values=angle.values * 2.0 * math.pi / turn), series, angle_first=True)
        if shared is not None:
            time, turned, turning = shared
            return cosine(straight(time, turned), straight(time, integral(turning, time))) ** 2
    return 0.0


def _axis(log: RawLog, found: ColumnFinding) -> ColumnFinding:
    """Which of two axes points north, by latitudes, or by a heading whose sense is known."""
    able = [f for f in log.findings if {*f.may_be} == {*found.may_be} or ON_EARTH in f.why]
    able = [f for f in able if f.table is found.table]
    if len(able) == 2 and all(_stands(log, f) for f in able):
        quantity = "longitude" if found.may_be[0] == "north" else "latitude"  # x, and y
        return found.told("physics", ON_EARTH, may_be=(quantity,), signed=True)
    other = _other_axis(log, found)
    if other is None:
        return found
    if frame := frame_stated(found.table.notes):
        quantity = found.may_be[1 if frame == "enu" else 0]
        decided = _decided(found, quantity, f"the file states axes {frame.upper()}", "stated")
        return replace(decided, sign=-1) if (frame, quantity) == ("nwu", "east") else decided
    if other.quantity is not None:
        quantity = "east" if other.quantity == "north" else "north"
        return _decided(found, quantity, f"column {other.column.name} is the other one")
    x, y = log.series(found, raw=True), log.series(other, raw=True)
    if found.may_be[0] == "east" or x is None or y is None:
        return found
    for (_, lat), (_, lon) in log.beside("latitude", "longitude"):
        shared = together(lat, lon)
        if shared is None or np.abs(shared[1]).max() > 1.58:
            continue
        north, east, _ = on_plane(shared[1], shared[2])
        for quantity, values in (("north", north), ("east", east)):
            ratio = slope(ClockSeries(shared[0], values, lat.clock, lat.dated), x)
            if ratio is not None and ratio > 0.0:
                return _decided(found, quantity, f"{quantity}: agrees with latitude and longitude")
    velocity, pair = track_velocity(x, y), log.first("heading")
    ways = (("north", velocity), ("east", velocity[::-1])) if velocity is not None and pair is not None else ()
    for quantity, parts in ways:
        told = sense(pair[1], *parts) if pair is not None else None
        if told is not None and told[0] == "with" and abs(told[1]) < other_channels.NEAR:
            name = pair[0].column.name if pair is not None else ""
            return _decided(found, quantity, f"{quantity}: the track agrees with column {name}")
    return found


def _stands(log: RawLog, found: ColumnFinding) -> bool:
    """Whether a position without a unit stays, far from 0, within a metre for minutes, if its numbers are metres."""
    series, known = log.series(found, raw=True), found.column.finite
    lasts = float(np.ptp(series.time[np.isfinite(series.time)])) if series is not None and known.size else 0.0
    near = known.size > 0 and _span(found) < STANDS and FAR_OFF * _span(found) < abs(float(np.median(known))) <= 180.0
    return near and lasts > STANDS_S and (found.unit is None or ON_EARTH in found.why)


def _other_axis(log: RawLog, found: ColumnFinding) -> ColumnFinding | None:
    """The other axis of the same table: x beside y."""
    pairs = [f for f in log.findings if f.table is found.table and f is not found]
    turned = [f for f in pairs if f.may_be == tuple(reversed(found.may_be))]
    settled = [f for f in pairs if f.quantity in ("north", "east")]
    return next(iter([*turned, *settled]), None)


def ask(log: RawLog, found: ColumnFinding) -> ColumnFinding:
    """The finding with the question for its quantity, as one that waits for the answer to another one, or as the answer
    to that tells it."""
    told = settle(log, found)
    if len(told.may_be) == 1 or told.questions:
        return told
    open_ones = (f for f in log.findings if f.table is found.table and f.quantity is None)
    axis = next((f for f in open_ones if {*f.may_be} == {"north", "east"}), None)
    if axis is not None and {*found.may_be} & {"velocity_north", "velocity_east"}:
        return found.unused(f"waits for what {axis.column.name} is", True)
    if set(found.may_be) == {"north", "east"} and found.may_be[0] == "east" and (other := _other_axis(log, found)):
        return found.unused(f"waits for what {other.column.name} is", True)
    shown = " or ".join(name.replace("_", " ") for name in found.may_be)
    return ask_quantity(found, f"What is {found.column.name!r}: {shown}? No other channel tells it.", found.may_be)


def without_twins(log: RawLog) -> None:
    """Of columns of one file for the same quantity one is used: the others agree with it, or it is asked."""
    groups: dict[tuple[str, str], list[ColumnFinding]] = {}
    for found in log.findings:
        if found.quantity in quantities():
            groups.setdefault((found.table.clock, found.may_be[0]), []).append(found)
    for own in groups.values():
        # surely of the quantity first: chosen by the user, without questions, with the most numbers
        first, *others = sorted(
            own, key=lambda f: ("quantity" not in f.bounded, len(f.questions), -f.column.finite.size)
        )
        for found in others:
            first = _one_of(log, first, found)


def _one_of(log: RawLog, used: ColumnFinding, found: ColumnFinding) -> ColumnFinding:
    """The column of two of one quantity that is used; what becomes of the other one is put into the log."""
    told = difference(log, used, found)
    share = STILL if used.unit and found.unit else 0.0
    one, two = (_span(f) * (f.unit.factor * f.factor if f.unit and share else 1.0) for f in (used, found))
    still = max(one, two) > 0.0 and min(one, two) <= share * max(one, two)
    stuck = still and used.quantity not in ("latitude", "longitude")
    along = [_goes_along(log, f) for f in (used, found)]
    chosen, why = used, ""
    bounded = [f for f in (used, found) if "quantity" in f.bounded]
    if not bounded and (arm := _arm(log, used, found)):
        why = f"{used.column.name} and {found.column.name} differ by {arm:.3g} m times the yaw rate: speeds of two"
        why += " places of the ship, none of them that of the reference point"
        log.change(found, found.unused(why))
        log.change(used, opened := used.unused(why))
        return opened
    if bounded == [used]:
        why = f"{used.column.name} is used, as {used.why[-1]}"
    elif told is not None and told[0]:
        why = f"{told[1]}; that one is used"
    elif stuck:  # not whole degrees beside minutes
        chosen, why = (found if one < two else used), "it stays as it is, another one moves"
    elif {*along} == {True, False}:
        chosen, why = (used if along[0] else found), "the track goes along another column"
    elif told is None and found.column.known and used.column.known:
        why = f"{used.table.label} states the same, too short to be compared; it is used"
    elif found.questions and not used.questions:
        why = f"{used.may_be[0].replace('_', ' ')} is column {used.column.name}"
    else:
        name, quantity = found.column.name, found.may_be[0]
        text = f"{used.column.name!r} and {name!r} are both a {quantity.replace('_', ' ')}: which one is used?"
        text += f" The second {told[1]}." if told and told[1] else ""
        one = Answer(NOT_USED, used.column.name, line_of(found, to=NOT_USED))
        mapped = "quantity" in used.bounded  # both by the map; else both are open in it, and one line answers it
        also = f"\n{line_of(used, to=NOT_USED)}" if mapped else ""
        other = Answer(quantity, name, line_of(found) + also)
        asked = Question(identifier(found, "quantity"), "quantity", found.table.label, name, text, (one, other))
        settled = log.answered(replace(found, questions=(asked,), sure="guess"))
        log.change(found, settled)
        if settled.questions and not mapped:
            log.change(used, opened := replace(used, waits=True))
            return opened
        if not settled.may_be or settled.questions:
            return used
        chosen, found, why = settled, settled, f"{settled.column.name} is used, as answered"
    other = used if chosen is found else found
    log.change(other, other.unused(why))
    return chosen


def _goes_along(log: RawLog, found: ColumnFinding) -> bool | None:
    """Whether a track goes along a heading; None where there is no track, or the ship does not turn."""
    series = log.series(found) if found.quantity == "heading" and found.unit and found.signed else None
    tracks = log.tracks() if series is not None else ()
    way = next((way for _, *track in tracks if series and (way := sense(series, *track)) is not None), None)
    return None if way is None else way[0] == "with" and abs(way[1]) < other_channels.NEAR


def _arm(log: RawLog, one: ColumnFinding, other: ColumnFinding) -> float | None:
    """Metres between the places of two speeds sideways whose difference goes with the yaw rate, and not as well with
    either of them; None where it does not."""
    first, second = (log.series(f) if f.quantity == "sway" and f.unit else None for f in (one, other))
    rate = next((s for f, s in log.all("yaw_rate", signed=False) if f.table is one.table is other.table), None)
    if first is None or second is None or rate is None:
        return None
    apart = replace(first, values=first.values - second.values)
    length, shares = slope(apart, rate), []
    for series in (rate, first, second):
        shared = together(apart, series)
        shares.append(1.0 - correlation(shared[1], shared[2]) ** 2 if shared is not None else 0.0)
    clear = shares[0] < NEARER_RATE * min(shares[1:])
    return abs(length) if length is not None and clear and abs(length) > LEAST_ARM_M else None


def _span(found: ColumnFinding) -> float:
    """How far the numbers of a column move; nan where there are none."""
    return float(np.ptp(found.column.finite)) if found.column.finite.size else np.nan


def difference(log: RawLog, one: ColumnFinding, other: ColumnFinding) -> tuple[bool, str] | None:
    """(whether two columns agree, a sentence); None where they cannot be compared."""
    unit = one.unit or other.unit
    first, second = (log.series(f, f.unit or unit) if f.unit or unit else None for f in (one, other))
    if first is None or second is None:
        return None
    angle = one.dimension == "angle"
    shared = together(first, second, angle_first=angle, angle_second=angle)
    if shared is None:
        return None
    apart = shared[2] - shared[1]
    apart = (apart + math.pi) % (2.0 * math.pi) - math.pi if angle else apart
    size = float(np.sqrt(np.mean(apart**2)))
    mirrored = float(np.sqrt(np.mean((shared[1] + shared[2]) ** 2)))
    stated = one.column.known or other.column.known or (one.side and other.side)
    if one.quantity in WITH_SIDE and not stated and mirrored < 0.01 * float(np.sqrt(np.mean(shared[1] ** 2))):
        return True, f"is {one.column.name} with the opposite sign"
    shown = math.degrees(size) if one.dimension in ("angle", "angular rate") else size
    unit_text = {"angle": "deg", "angular rate": "deg/s", "speed": "m/s", "length": "m"}.get(one.dimension, "")
    near = size <= ALIKE.get(one.dimension, 0.0)
    named = one.column.name + (f" [{one.table.sheet}]" if one.table.sheet != other.table.sheet else "")
    return near, f"is {shown:.3g} {unit_text} from {named} (root mean square)".replace("  ", " ")
