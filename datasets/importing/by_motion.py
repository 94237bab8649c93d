"""What columns without a known name are, by how they move together: a rate and its angle, a track and its course, a
rudder and the turning that answers it.

Every choice of a heading, its rate and a track is completed by the columns that follow from it.  A choice is worth the
sum of what its relations explain, each by the logarithm of the share that it leaves: the choice that explains most
columns is taken as a whole, as no column tells by itself what it is.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np

from ..signals import integral
from ..yaw_response import YawResponse, yaw_response
from . import steering
from .evidence import ClockSeries
from .quantities import UNITS
from .times import TableTime

GRID, COARSE = 1500, 400
"""Samples of the even grid on which columns are compared, and fewer for the courses of all pairs."""
FLOOR = 2e-3
"""Share of a column's variance that no relation explains: sensors' noise and rounding."""
RATE_FIT, SPEED_FIT, TURN_FIT, ANSWER_FIT = 0.9, 0.9, 0.75, 0.35
"""Least share of a column that its relation explains: an angle by its rate, a position or a speed by a velocity, the
course by the heading, the yaw rate by its answer to a rudder beyond that at the same time."""
SCALE, SCALE_WORTH = 0.2, 10.0
"""Largest difference of the logarithms of a measured factor and of a unit's, and what a difference takes off."""
FAINT, AHEAD = 0.1, 3.0
"""Least share of a rudder's answer, and how much more it must explain beyond another column than that beyond it."""
MOST_RIVALS = 3
"""Columns of which each may be the rudder where none is ahead."""
ORDER_SIZE = (0.85, 1.2)
"""Range of an order over that of the rudder that follows it, in one unit."""
SAME_UNIT = 0.5
"""What it is worth that rudder and heading are in one unit."""
LEAST_TURN, MOST_TURN = 0.05, 200.0
"""Range of a heading, rad, that can be told."""
MERIDIAN = 60.0 * 1852.0
"""Metres of a degree of latitude."""
SPEEDS = (0.02, 40.0)
"""Mean speeds, m/s, of a craft that manoeuvres."""
MOST_RUDDER, LEAST_RUDDER = math.radians(75.0), math.radians(1.5)
"""Largest angle of a rudder, and least one that can be told."""
USUAL_TURN, USUAL_RATE = (0.25, 7.0), (0.0, 1.0)
"""Range of a heading, rad, and largest yaw rate, rad/s: outside of these each factor of two makes a meaning less
likely."""
LEAST_RATE = math.radians(0.02)
"""Largest yaw rate, rad/s, of a ship that hardly turns."""
ANY_DIRECTION = math.pi**2 / 3.0
"""Variance, rad^2, of an angle that may be any."""
BIAS = 0.35
"""Mean difference of course and heading, rad, beyond which a track is none along the heading."""

HARDLY = 0.2
"""Difference of the worth of a speed forward and of one over ground that tells nothing."""
LEAST_WORTH, NEAR, NEAR_UNIT = 1.0, 0.5, 3.0
"""Least worth of an assignment, and by how much others are less that are told beside it: those of the other unit of an
angle where nothing tells it."""
MAIN = ("heading", "yaw_rate", "north", "east", "latitude", "longitude", "rudder")
"""Quantities that an assignment stands on."""
ANGLES, RATES, VELOCITIES = ("deg", "rad"), ("deg/s", "rad/s", "deg/min"), ("m/s", "kn", "km/h")


@dataclass(frozen=True)
class Meaning:
    """What a column is: quantity, unit and sign, the relation that tells it, and what that is worth."""

    quantity: str
    unit: str
    sign: int
    why: str
    worth: float = 0.0
    offset: float = 0.0
    """In the unit, added to the number with its sign."""


Track: TypeAlias = tuple[np.ndarray, dict[str, Meaning]]
"""Velocities north + i east (n,), m/s, of two columns, and what these are."""


def motion_of(time: np.ndarray, columns: Mapping[str, np.ndarray], known: Mapping[str, Meaning]) -> ColumnMotion | None:
    """Columns (N,) over rising times (N,), s, on an even grid; those that never change are left out."""
    fresh = np.isfinite(time)
    fresh[fresh] = np.concatenate([[True], np.diff(np.maximum.accumulate(time[fresh])) > 0.0])
    if fresh.sum() < 30:
        return None
    at = time[fresh]
    count = min(GRID, fresh.sum())
    grid = np.linspace(at[0], at[-1], count)
    width = max(1, round(fresh.sum() / count))
    values, turns = {}, {}
    for name, column in columns.items():
        sound = np.isfinite(column[fresh])
        own = column[fresh][sound]
        if sound.sum() < 0.5 * sound.size or np.ptp(own) <= 1e-9 * max(1.0, float(np.abs(own).max())):
            continue
        steps, span = np.abs(np.diff(own)), float(np.ptp(own))
        for period in (360.0, 2.0 * math.pi):  # jumps of a full turn
            jumps = np.any(steps > 0.9 * period) and np.median(steps) < 0.1 * period
            if 0.9 * period < span <= 1.01 * period and jumps:
                own, turns[name] = np.unwrap(own, period=period), period
                break
        values[name] = np.interp(grid, at[sound], smooth(own, width))
    return ColumnMotion(grid - grid[0], values, turns, {n: m for n, m in known.items() if n in values})


def smooth(values: np.ndarray, width: int) -> np.ndarray:
    """Moving average (n,) over an odd number of samples."""
    width = max(1, int(width)) | 1
    if width < 3 or values.size < width:
        return values
    from scipy.ndimage import uniform_filter1d

    return uniform_filter1d(values, width, mode="nearest")


def worth(explained: float) -> float:
    """Half the logarithm of what a relation leaves of a column's variance, turned round: the gain in log likelihood a
    sample."""
    return 0.5 * math.log(1.0 / (max(1.0 - explained, 0.0) + FLOOR))


def straight(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values (n,) less their straight line."""
    t = time - time.mean()
    centred = values - values.mean()
    return centred - t * float(t @ centred) / float(t @ t)


def agreement(wanted: np.ndarray, values: np.ndarray) -> float:
    """Share of the square of a wanted series that values have, mean and all."""
    power = float(wanted @ wanted)
    left = wanted - values
    return 1.0 - float(left @ left) / power if power > 0.0 else 0.0


def likeness(wanted: np.ndarray, values: np.ndarray) -> float:
    """Share of the variance of a wanted series that values have, and no more than of its square."""
    spread = float(np.var(wanted))
    own = 1.0 - float(np.var(wanted - values)) / spread if spread > 0.0 else 0.0
    return min(own, agreement(wanted, values))


class ColumnMotion:
    """Columns of one table on an even grid, and the relations between them.

    time : (n,) s.  values : name -> (n,), angles without their jumps.  turns : name -> period of a column that jumps by
    a full turn.  known : name -> what a column is for certain.
    """

    def __init__(
        self,
        time: np.ndarray,
        values: Mapping[str, np.ndarray],
        turns: Mapping[str, float],
        known: Mapping[str, Meaning],
    ) -> None:
        self.time, self.values, self.turns, self.known = time, values, turns, known
        self.step = float(time[1] - time[0])
        self.width, self.coarse = max(3, time.size // 60), slice(None, None, max(1, time.size // COARSE))
        self.smoothed = {name: smooth(x, self.width) for name, x in values.items()}
        self.speeds = {name: np.gradient(x, self.step) for name, x in self.smoothed.items()}
        self.responses = dict[tuple[str, str], YawResponse | None]()
        self.rates = dict[tuple[str, str], tuple[float, float]]()
        """(angle, rate) -> (share of a column beyond a straight line that k times the integral of another explains, k),
        where that is `RATE_FIT` or more."""
        wholes = {name: straight(time, x) for name, x in values.items()}
        summed = {name: straight(time, integral(x, time)) for name, x in values.items()}
        for whole, rate in itertools.permutations(values, 2):
            y, z = wholes[whole], summed[rate]
            power, other = float(z @ z), float(y @ y)
            if power > 0.0 and other > 0.0:
                k = float(y @ z) / power
                left = y - k * z
                share = 1.0 - float(left @ left) / other
                self.rates |= {(whole, rate): (share, k)} if share > RATE_FIT else {}

    def open(self) -> list[str]:
        """Columns of which nothing is known."""
        return [name for name in self.values if name not in self.known]

    def of(self, quantity: str) -> list[tuple[str, Meaning]]:
        """Columns that are known to be of a quantity."""
        return [(name, meaning) for name, meaning in self.known.items() if meaning.quantity == quantity]

    def si(self, name: str, meaning: Meaning) -> np.ndarray:
        """The values of a column in SI units and radians, with the record's sign."""
        return meaning.sign * UNITS[meaning.unit].factor * self.values[name]

    def series(self, name: str) -> ClockSeries:
        """A column over time."""
        return ClockSeries(self.time, self.values[name], "", False)

    # ---- heading and yaw rate

    def headings(self) -> Iterator[tuple[str, Meaning]]:
        """Columns that may be the heading, in degrees or radians."""
        known = self.of("heading")
        yield from known
        for name in self.open() if not known else ():
            for unit in self._angle_units(name):
                turn = float(np.ptp(self.values[name])) * UNITS[unit].factor
                if LEAST_TURN < turn < MOST_TURN:
                    yield name, Meaning("heading", unit, 1, "", -_beyond(turn, USUAL_TURN))

    def _angle_units(self, name: str) -> Sequence[str]:
        period = self.turns.get(name)
        return ANGLES if not period else ("deg",) if period > 100.0 else ("rad",)

    def yaw_rates(self, heading: str, of: Meaning) -> Iterator[tuple[str, Meaning]]:
        """Columns whose integral is a heading."""
        known = dict(self.of("yaw_rate"))
        for (whole, rate), (share, k) in self.rates.items():
            if whole != heading or (known and rate not in known):
                continue
            if rate in known:
                yield rate, replace(known[rate], worth=worth(share))
            elif rate not in self.known:
                scale = k * UNITS[of.unit].factor * of.sign
                apart, unit = min((abs(math.log(abs(scale) / UNITS[unit].factor)), unit) for unit in RATES)
                if apart < SCALE:
                    why = f"its integral explains {share:.1%} of {heading}"
                    largest = float(np.abs(self.smoothed[rate]).max()) * UNITS[unit].factor
                    value = worth(share) - _beyond(largest, USUAL_RATE) - SCALE_WORTH * max(apart - 0.02, 0.0)
                    yield rate, Meaning("yaw_rate", unit, int(np.sign(scale)), why, value)

    # ---- tracks

    def tracks(self, heading: str, of: Meaning) -> Iterator[Track]:
        """Pairs of positions whose course goes with a heading, the second with the sign with which it does."""
        psi = smooth(self.si(heading, of), self.width)[self.coarse]
        for meanings in self._pairs(heading):
            (first, one), (second, other) = meanings.items()
            velocity = self._over_ground(meanings)
            if not SPEEDS[0] < float(np.abs(velocity).mean()) < SPEEDS[1]:
                continue
            signs = (1,) if second in self.known or one.quantity == "latitude" else (1, -1)
            tried = {sign: velocity if sign > 0 else velocity.conj() for sign in signs}
            fits = {sign: _course_fit(own[self.coarse], psi) for sign, own in tried.items()}
            sign, (share, offset) = max(fits.items(), key=lambda entry: entry[1][0] - entry[1][1])
            if share >= TURN_FIT and offset <= BIAS:
                why = f"the course of {first} and {second} explains {share:.1%} of the heading"
                said = {"why": why, "worth": (worth(share) - offset / BIAS) / 2.0}
                yield tried[sign], {
                    first: replace(one, **said), second: replace(other, sign=other.sign * sign, **said)
                }  # fmt: skip

    def _pairs(self, heading: str) -> Iterator[dict[str, Meaning]]:
        norths, easts = self.of("north"), self.of("east")
        if norths and easts:
            yield {norths[0][0]: norths[0][1], easts[0][0]: easts[0][1]}
            return
        able = [name for name in self.open() if name != heading and self._is_steady(name)]
        for first, second in itertools.permutations(able, 2):
            if self._in_degrees(first, 90.0) and self._in_degrees(second, 180.0):
                yield {first: Meaning("latitude", "deg", 1, ""), second: Meaning("longitude", "deg", 1, "")}
            else:
                yield {first: Meaning("north", "m", 1, ""), second: Meaning("east", "m", 1, "")}

    def _in_degrees(self, name: str, most: float) -> bool:
        """Whether a column may be a latitude or longitude: it hardly changes, far from zero for that."""
        values = self.values[name]
        return 1e-5 < float(np.ptp(values)) < 1.0 and float(np.ptp(values)) < 0.2 * abs(float(values.mean())) <= most

    def _is_steady(self, name: str) -> bool:
        """Whether a column changes steadily, as a position does."""
        rough = float(np.std(np.diff(self.values[name], 2)))
        steady = float(np.std(np.diff(self.values[name])) + abs(np.diff(self.values[name]).mean()))
        return rough < 1.5 * steady

    def _over_ground(self, meanings: Mapping[str, Meaning]) -> np.ndarray:
        """Velocities north + i east (n,), m/s, of two columns of positions."""
        (first, one), (second, other) = meanings.items()
        north, east = one.sign * self.speeds[first], other.sign * self.speeds[second]
        if one.quantity != "latitude":
            return north + 1j * east
        parallel = math.cos(math.radians(float(self.values[first].mean())))
        return MERIDIAN * north + 1j * MERIDIAN * parallel * east

    # ---- what follows from heading and track

    def velocities(self, track: Track, psi: np.ndarray, taken: set[str]) -> Iterator[tuple[str, Meaning]]:
        """Columns that are a velocity over ground, forward or to starboard, the speed or the course of a track."""
        velocity, meanings = track
        body = velocity * np.exp(-1j * smooth(psi, self.width))
        wanted = {
            "velocity_north": velocity.real, "velocity_east": velocity.imag, "surge": body.real, "sway": body.imag,
            "speed_over_ground": np.abs(velocity),
        }  # fmt: skip
        course = np.unwrap(np.angle(velocity))
        free = [name for name in self.open() if name not in taken]
        able = {name: list(self._over_track(name, wanted, course)) for name in free}
        kinds = {m.quantity for own in [*able.values(), meanings.values()] for m in own}
        of_receiver = bool(kinds & {"course_over_ground", "latitude"})
        for name, own in able.items():
            if own:
                best = max(own, key=lambda meaning: meaning.worth)
                yield name, _over_ground(own, best) if of_receiver else best

    def _over_track(self, name: str, wanted: Mapping[str, np.ndarray], course: np.ndarray) -> Iterator[Meaning]:
        """What a column may be of a track, by its velocities and its course, rad."""
        values = self.smoothed[name]
        for (quantity, series), unit, sign in itertools.product(wanted.items(), VELOCITIES, (1, -1)):
            if sign < 0 and quantity != "sway":
                continue
            own = sign * UNITS[unit].factor * values
            alike, size = likeness(series, own), agreement(series, own)
            if alike > SPEED_FIT or (alike > 0.0 and size > 0.99) or (quantity == "sway" and alike > TURN_FIT):
                yield Meaning(quantity, unit, sign, f"agrees with the track to {alike:.1%}", worth(alike))
        for unit in self._angle_units(name):
            own = UNITS[unit].factor * values
            turn = 2.0 * math.pi * np.round(np.mean(course - own) / (2.0 * math.pi))
            share = likeness(course - course.mean(), own + turn - course.mean())
            if share > 0.98:
                why = f"agrees with the course of the track to {share:.1%}"
                yield Meaning("course_over_ground", unit, 1, why, worth(share))

    # ---- rudder

    def rudders(self, turning: str, rate: np.ndarray, taken: set[str], unit: str) -> list[tuple[str, Meaning]]:
        """Columns that the yaw rate, of a column, answers: the one that is ahead of the others, or none."""
        sizes = {name: float(np.abs(self.values[name]).max()) for name in self.open() if name not in taken}
        units = {n: [u for u in ("rad", "deg") if LEAST_RUDDER < size * UNITS[u].factor < MOST_RUDDER]
                 for n, size in sizes.items()}  # fmt: skip
        tried = [(self._response(turning, rate, name), name) for name in units if units[name]]
        answers = sorted(((r, name) for r, name in tried if r is not None), key=lambda entry: -entry[0].beyond)
        if not answers:
            return []
        best = answers[0][0]
        rivals = [entry for entry in answers[1:] if not _is_ahead(best, entry[0])]
        faint = best.beyond < (FAINT if all(best.beyond > AHEAD * r.beyond for r, _ in answers[1:]) else ANSWER_FIT)
        if faint and len(answers) == 1:
            return []
        rivals = answers[1:] if faint else rivals
        least = FAINT / AHEAD if best.beyond > FAINT else 1.0
        told = [(r.beyond, name) for r, name in (answers[0], *rivals) if r.beyond > least][:MOST_RIVALS]
        helms = []
        for share, name in told:
            own = units[name][0]
            value = (worth(share) + (SAME_UNIT if own == unit else 0.0)) / len(told)
            why = f"the yaw rate follows it: {share:.1%} beyond what it is at the same time"
            helms.append((name, Meaning("rudder", own, 1, why, value)))
        return helms

    def _response(self, turning: str, rate: np.ndarray, name: str) -> YawResponse | None:
        """The response of a yaw rate, of a column or the rate of one, in any unit of it."""
        if (turning, name) not in self.responses:
            self.responses[turning, name] = yaw_response(self.time, rate, self.values[name])
        return self.responses[turning, name]


def _over_ground(able: Sequence[Meaning], best: Meaning) -> Meaning:
    """The best meaning of a column beside what receivers give: not a speed forward where that over ground is hardly
    another number."""
    speeds = (m for m in able if m.quantity == "speed_over_ground" and m.unit == best.unit)
    return next((m for m in speeds if best.quantity == "surge" and best.worth - m.worth < HARDLY), best)


def _unit(values: np.ndarray) -> np.ndarray:
    """Values (n,) over their norm."""
    size = float(np.linalg.norm(values))
    return values / size if size > 0.0 else values


def _is_ahead(one: YawResponse, other: YawResponse) -> bool:
    """Whether a column explains much more beyond another one than that beyond it."""
    wanted, first, second = (_unit(values - values.mean()) for values in (one.rate, one.answer, other.answer))
    beside = _unit(second - first * float(first @ second))
    alone = float(wanted @ first) ** 2
    both = alone + float(wanted @ beside) ** 2
    return both - float(wanted @ second) ** 2 >= AHEAD * (both - alone)


def _course_fit(velocity: np.ndarray, psi: np.ndarray) -> tuple[float, float]:
    """(share of a heading (n,), rad, that the course of velocities (n,) explains, their mean difference, rad).

    What of the drift goes with the yaw rate is left out: that of a ship does.
    """
    speed = np.abs(velocity)
    moving = speed > 0.25 * np.quantile(speed, 0.9)
    rate = np.gradient(psi)[moving]
    apart = np.exp(1j * (np.angle(velocity) - psi))[moving]
    mean = complex(apart.mean())
    drift = np.angle(apart * np.conj(mean))
    if float(np.mean(drift**2)) < ANY_DIRECTION / 4.0:
        turning, drift = _unit(rate - rate.mean()), drift - drift.mean()
        drift = drift - turning * float(turning @ drift)
    motion = min(max(float(np.var(psi[moving])), 1e-9), ANY_DIRECTION)
    return 1.0 - float(np.mean(drift**2)) / motion, abs(float(np.angle(mean)))


def _beyond(size: float, usual: tuple[float, float]) -> float:
    """By how many factors of two a size is outside what is usual."""
    least, most = usual
    above = math.log2(size / most) if size > most else 0.0
    below = math.log2(least / size) if 0.0 < size < least else 0.0
    return max(above, below)


@dataclass(frozen=True)
class Assignment:
    """What open columns are, what that is worth in all, and the time of the table under which it is so."""

    meanings: Mapping[str, Meaning]
    worth: float
    time: TableTime = field(default_factory=TableTime)

    @property
    def main(self) -> frozenset[tuple[str, str, str]]:
        """Column, quantity and unit of what the assignment stands on."""
        return frozenset((n, m.quantity, m.unit) for n, m in self.meanings.items() if m.quantity in MAIN)

    @property
    def mirrored(self) -> list[Assignment]:
        """The same in a frame whose axes are exchanged and whose angles turn the other way, which no motion tells from
        it, with a heading from east, or without positions also from north; none where a track on the globe tells."""
        told = {m.quantity for m in self.meanings.values()}
        if not told & {"heading", "yaw_rate"} or told & {"latitude", "longitude", "course_over_ground"}:
            return []
        out = []
        for from_east in (True,) if "north" in told or "heading" not in told else (True, False):
            turned = {}
            for name, meaning in self.meanings.items():
                own = replace(meaning, quantity=EXCHANGED.get(meaning.quantity, meaning.quantity))
                if meaning.quantity in ("heading", "yaw_rate", "sway"):
                    quarter = math.pi / 2.0 / UNITS[meaning.unit].factor
                    offset = round(quarter, 9) if meaning.quantity == "heading" and from_east else 0.0
                    own = replace(meaning, sign=-meaning.sign, offset=offset)
                turned[name] = own
            out.append(replace(self, meanings=turned))
        return out


EXCHANGED = {
    "north": "east", "east": "north", "velocity_north": "velocity_east", "velocity_east": "velocity_north",
}  # fmt: skip
"""Quantities that change places in a frame whose axes are exchanged."""


def assignments(motion: ColumnMotion) -> list[Assignment]:
    """What the open columns may be: the choice of heading, yaw rate, track and rudder that explains most, and those
    near it that contradict it; without any where nothing tells."""
    best = dict[frozenset, Assignment]()
    for heading in motion.headings():
        rates, tracks = motion.yaw_rates(*heading), motion.tracks(*heading)
        for rate, track in itertools.product([*rates, None], [*tracks, None]):
            alone = not (rate or track)
            for told in _completed(motion, heading, rate, track):
                if alone and not any(m.quantity == "rudder" and m.worth > LEAST_WORTH for m in told.values()):
                    continue
                made = Assignment(told, sum(meaning.worth for meaning in told.values()))
                if made.main not in best or made.worth > best[made.main].worth:
                    best[made.main] = made
    if not best and not motion.known:
        return _without_heading(motion)
    ranked = sorted(best.values(), key=lambda made: -made.worth)
    if not ranked or ranked[0].worth < LEAST_WORTH:
        return []
    first = ranked[0]
    columns, told = {n for n, _, _ in first.main}, {q for _, q, _ in first.main}
    # also that in the other unit, where no track tells it
    least = first.worth - (NEAR if told & {"north", "latitude"} or motion.turns else NEAR_UNIT)
    near = [
        made
        for made in ranked[1:]
        if made.worth > least and any(e not in first.main and (e[0] in columns or e[1] in told) for e in made.main)
    ]
    return [replace(m, meanings={n: x for n, x in m.meanings.items() if n not in motion.known}) for m in (first, *near)]


def _without_heading(motion: ColumnMotion) -> list[Assignment]:
    """Of columns without a heading those that are a yaw rate, in each unit of a usual size, and the rudder that it
    answers, in one that is not answered itself."""
    found = list[Assignment]()
    for name in motion.open():
        for helm in motion.rudders(name, motion.values[name], {name}, ""):
            largest = float(np.abs(motion.smoothed[name]).max())
            units = ("deg/s", "deg/min") if helm[1].unit == "deg" else ("rad/s",)
            able = [unit for unit in units if USUAL_RATE[1] > largest * UNITS[unit].factor > LEAST_RATE]
            for unit in able if helm[1].worth > LEAST_WORTH else ():
                rate = Meaning("yaw_rate", unit, 1, f"it follows {helm[0]}")
                found.append(Assignment({name: rate, **_with_order(motion, *helm, {name})}, helm[1].worth))
    return sorted(found, key=lambda made: -made.worth)


def _completed(
    motion: ColumnMotion, heading: tuple[str, Meaning], rate: tuple[str, Meaning] | None, track: Track | None
) -> Iterator[dict[str, Meaning]]:
    """All columns that follow from a choice of heading, yaw rate and track: for each that may be the rudder."""
    name, of = heading
    if track is not None and rate is not None and rate[0] in track[1]:
        return
    told = dict([heading, *([rate] if rate else [])])
    reason = f"the integral of {rate[0]}" if rate else "the course of the track goes with it"
    told[name] = replace(of, why=of.why or reason)
    psi = motion.si(name, of)
    if track is not None:
        told |= track[1]
        told |= _body(motion.velocities(track, psi, set(told)))
    turning = motion.si(*rate) if rate is not None else np.gradient(smooth(psi, motion.width), motion.step)
    column = rate[0] if rate is not None else f"the rate of {name}"
    taken = set(told) | set(motion.known)
    helms = motion.rudders(column, turning, taken, of.unit) if not motion.of("rudder") else []
    for helm in helms or [None]:
        yield told | (_with_order(motion, *helm, taken) if helm else {})


def _with_order(motion: ColumnMotion, name: str, helm: Meaning, taken: set[str]) -> dict[str, Meaning]:
    """What steers, and its order or its answer, where another column moves alike and one is earlier."""
    own = motion.series(name)
    size = float(np.ptp(own.values))
    for other in motion.open():
        alike = ORDER_SIZE[0] < float(np.ptp(motion.values[other])) / size < ORDER_SIZE[1]
        lead = steering.lead(motion.series(other), own) if alike and other != name and other not in taken else 0
        if lead:
            order, rudder = (other, name) if lead > 0 else (name, other)
            sign = 1 if float(np.corrcoef(motion.values[order], motion.values[rudder])[0, 1]) > 0.0 else -1
            why = f"{rudder} follows it"
            return {order: Meaning("rudder_command", helm.unit, sign, why), rudder: helm}
    return {name: helm}


def _body(meanings: Iterator[tuple[str, Meaning]]) -> dict[str, Meaning]:
    """Velocities, of columns of one quantity the one that is worth most; one to starboard stands beside one forward in
    its unit, or is none."""
    best: dict[str, tuple[str, Meaning]] = {}
    for name, meaning in meanings:
        if meaning.quantity not in best or meaning.worth > best[meaning.quantity][1].worth:
            best[meaning.quantity] = (name, meaning)
    told = dict(best.values())
    if "sway" not in best:
        return told
    side, sway = best["sway"]
    forward = [n for n, m in told.items() if m.quantity in ("surge", "speed_over_ground") and m.unit == sway.unit]
    if not forward:
        return {name: meaning for name, meaning in told.items() if name != side}
    return told | {forward[0]: replace(told[forward[0]], quantity="surge")}
