"""Readings of a record's columns: how well heading, rates, velocities and positions agree, as they are or exchanged;
and the ratio of what a channel shows to what another one gives, which tells units and signs.

Of long records, ratios and disagreements are those of averages.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from ...datasets.axes import Track, goes_astern, track_of
from ...datasets.columns import HEADING, POSITIONS, TRACK, TURN, VELOCITIES
from ...datasets.geometry import body_velocities, over_ground, position_over_ground, velocity_over_ground
from ...datasets.signals import bridged, integral, lagged
from ...models.instruments import SWAPS
from ...models.linear_algebra import lstsq
from ..base import Fault
from .averages import averages_of, continuous, without_wraps

if TYPE_CHECKING:
    from ...datasets.record import Record

WINDOW_S = 8.0
FEWEST_OF_RATIO = 30
MOVES = 0.2
"""Share of the usual way made in a window from which it has a course."""
USUAL = 0.75
"""Quantile of the ways made in windows that is taken for the usual one: windows over a jump may be the largest."""
WHOLE = 1.5
"""Times its usual duration beyond which a window holds a gap."""
GAP = 5.0
"""Times a long step between samples (nine of ten are shorter) beyond which the step is a gap."""
AGREE, AGREE_AS_RUDDER = 0.95, 0.8
"""Correlations from which a ratio is believed: by itself, and where the rudder says the same."""
NEAR, NEAR_IN_CURRENT = 0.06, 0.1
"""Shares by which a ratio may differ from that of two units; and where it is fitted beside a current."""
ANGLES = {np.pi / 180.0: "radians where degrees are meant", 180.0 / np.pi: "degrees where radians are meant"}
PLACES = {1.0 / 0.3048: "ft", 1e-3: "km", 1.0 / 1852.0: "nautical miles"}
SPEEDS = {
    3600.0 / 1852.0: "knots",
    3.6: "km/h",
    1.0 / 0.3048: "ft/s",
    1852.0 / 3600.0: "metres per second where knots are meant",
    1.0 / 3.6: "metres per second where km/h are meant",
}
BETTER = 0.5
"""Share of the present disagreement below which another reading of the columns is believed."""
FEWEST = 20
"""Samples with all channels below which nothing is compared."""
LARGEST_LAG_S, DELAYS = 15.0, (0.5, 0.7, 0.85, 1.0, 1.2, 1.5)
"""Largest lag of a heading's instrument, and times by which the heading may be late instead, as shares of the lag."""
LEAST = 0.02
"""Disagreement, as a share of the way made, from which another reading is looked for."""
ASKEW = float(np.deg2rad(17.0))
"""Angle, rad, beyond which the heading has another zero."""
MOST = 0.35
"""Disagreement from which no reading is the right one."""
Reread = Callable[["Record"], "Record"]


def exchanged(first: str, second: str) -> Reread:
    """A record with two columns exchanged."""

    def reading(record: Record) -> Record:
        return record.with_channels(**{first: record.column(second), second: record.column(first)})

    return reading


def reversed_sign(name: str) -> Reread:
    """A record with the other sign of a column."""
    return lambda record: record.with_channels(**{name: -record.column(name)})


def to_body(record: Record) -> Record:
    """Velocities along north and east turned into body axes."""
    psi, north, east = record.heading_unwrapped(), record.column("surge_m_s"), record.column("sway_m_s")
    surge, sway = body_velocities(north, east, psi)
    return record.with_channels(surge_m_s=surge, sway_m_s=sway)


def about_track(record: Record) -> Record:
    """The heading turned by the mean angle between the way made and the way that heading and velocities give, where
    that is beyond what a compass may err."""
    by_log, moved = _ways(record)
    angle = _mean_angle(by_log, moved)
    return record if abs(angle) < ASKEW else record.with_channels(heading_rad=record.heading_unwrapped() - angle)


def _mean_angle(by_log: np.ndarray, moved: np.ndarray) -> float:
    """Mean angle, rad, from ways (M,) that were made to those that heading and velocities give; 0 of none."""
    return float(np.angle(np.sum(by_log * np.conj(moved)))) if by_log.size else 0.0


def in_degrees(record: Record) -> Record:
    """The heading, without its wraps, as the degrees that its radians were taken for.

    The other way round, a heading that hardly turns any more, would read velocities along north and east as right.
    """
    heading = record.column("heading_rad")
    few = np.isfinite(heading).sum() < 2
    return record if few else record.with_channels(heading_rad=np.rad2deg(continuous(heading)))


def less_drift(record: Record) -> Record:
    """The heading of a column that holds the course over ground, where the yaw rate goes better with it than with the
    column, or with the column as a late heading, which looks alike; an antenna at the point about which the ship turns
    shows such a course, too, beside a right heading."""
    if not record.has(TURN[1]):
        return record
    heading = record.heading_unwrapped()
    read = record.with_channels(heading_rad=heading - np.arctan2(record.column("sway_m_s"), record.column("surge_m_s")))
    error = rate_error(read, TURN[1])
    if not error < BETTER * rate_error(record, TURN[1]):
        return record
    return read if error < rate_error(_with_lag(record, heading_lag(record)), TURN[1]) else record


def heading_lag(record: Record) -> float:
    """Lag, s, behind which the yaw rate goes best with the heading."""
    from scipy.optimize import minimize_scalar

    least, most = (float(np.log(x)) for x in (record.dt, max(LARGEST_LAG_S, 2.0 * record.dt)))
    best = minimize_scalar(
        lambda x: rate_error(_with_lag(record, float(np.exp(x))), TURN[1]),
        bounds=(least, most),
        method="bounded",
        options={"xatol": 0.02},
    )
    return float(np.exp(best.x))


def early_heading(record: Record, lag_s: float) -> np.ndarray:
    """The heading (N,), rad, of an instrument without its lag."""
    return record.heading_unwrapped() + lag_s * _with_lag(record, lag_s).column(TURN[1])


def has_lag(record: Record, lag_s: float) -> bool:
    """Whether the heading goes far better with a yaw rate behind a lag than with the yaw rate, and better than with one
    that is late by a time."""
    now, with_lag = (rate_error(one, TURN[1]) for one in (record, _with_lag(record, lag_s)))
    with_delay = min(rate_error(_with_delay(record, share * lag_s), TURN[1]) for share in DELAYS)
    return lag_s < 0.9 * LARGEST_LAG_S and now > 2.0 * LEAST and with_lag < min(BETTER * now, with_delay)


def _with_lag(record: Record, lag_s: float) -> Record:
    """The record with a yaw rate behind a lag."""
    time = record.time_s
    even = np.arange(time[0], time[-1] + 0.5 * record.dt, record.dt)
    rate = np.interp(even, time, bridged(record.column(TURN[1]), time))
    return record.with_channels(yaw_rate_rad_s=np.interp(time, even, lagged(rate, lag_s, record.dt)))


def _with_delay(record: Record, late_s: float) -> Record:
    """The record with a yaw rate that is late by a time."""
    time = record.time_s
    rate = np.interp(time - late_s, time, bridged(record.column(TURN[1]), time))
    return record.with_channels(yaw_rate_rad_s=rate)


class Reading(NamedTuple):
    """Another reading of heading, velocities and positions: the check (id) that names it, its columns, the record read
    so, how in words (with the turn of the heading), and the instruments of a model that shows them as they are."""

    check: str
    columns: tuple[str, ...]
    read: Reread
    how: str
    instruments: Mapping[str, float] = {}


def swap_of(columns: tuple[str, ...]) -> str:
    """The instrument of a model under which two columns are exchanged."""
    return next(name for name, swap in SWAPS.items() if {*swap} == {*columns})


READINGS = (
    Reading(
        "earth_frame_velocity",
        VELOCITIES,
        to_body,
        "when they are read as north and east",
        {"earth_frame_velocity": 1.0},
    ),
    Reading("heading_zero", (HEADING,), about_track, "with the heading turned by {turn:.4g} deg"),
    Reading("wrong_unit", TURN, in_degrees, "with heading_rad in another unit: radians were taken for degrees"),
    Reading("channel_swap", (HEADING,), less_drift, "with heading_rad as the course over ground, less the drift angle"),
    *(
        Reading("channel_swap", pair, exchanged(*pair), "with the columns exchanged", {swap_of(pair): 1.0})
        for pair in (VELOCITIES, POSITIONS)
    ),
    *(Reading("channel_sign", (name,), reversed_sign(name), f"with {name} reversed") for name in TRACK[1:]),
)


class Better(NamedTuple):
    """A reading that agrees far better, with the present and its own disagreement (shares of the way made), and by how
    much it turns the heading, rad."""

    reading: Reading
    present: float
    own: float
    turn: float = 0.0

    @property
    def evidence(self) -> str:
        """What agrees better, in words."""
        return (
            f"the track disagrees with the velocities by {self.present:.3f} of the way made, by {self.own:.3f} "
            f"{self.reading.how.format(turn=np.rad2deg(self.turn))}"
        )


_KNOWN_READINGS: WeakKeyDictionary[Record, Better | None] = WeakKeyDictionary()


def better_reading(record: Record) -> Better | None:
    """The reading of velocities and positions that agrees far better than the present one; None without any.

    Several checks ask for that of one record.
    """
    if record not in _KNOWN_READINGS:
        _KNOWN_READINGS[record] = _better_reading(averages_of(record)) if record.has(*TRACK) else None
    return _KNOWN_READINGS[record]


def _better_reading(record: Record) -> Better | None:
    by_log, moved = _ways(record)
    present, errors = _disagreement(by_log, moved), [track_error(reading.read(record)) for reading in READINGS]
    best = int(np.argmin(errors))
    if not (errors[best] < min(BETTER * present, MOST) and present > LEAST):
        return None
    askew = _disagreement(by_log * np.exp(-1j * _mean_angle(by_log, moved)), moved)  # what a compass may err, alone
    if askew < BETTER * errors[best]:
        return None
    turn = READINGS[best].read(record).heading_unwrapped() - record.heading_unwrapped()
    return Better(READINGS[best], present, errors[best], float(np.nanmedian(turn)))


def reread(record: Record, check: str) -> list[Fault]:
    """The fault of columns that agree far better when they are read as a check (id) says."""
    better = better_reading(record)
    if better is None or better.reading.check != check:
        return []
    fixed, (_, columns, _, _, instruments) = better.reading.read(record), better.reading
    if better.reading.read is about_track:
        instruments = {"heading_bias": float(np.angle(np.exp(-1j * better.turn)))}
    values, clear = {name: fixed.column(name) for name in columns}, (better.present / max(better.own, 1e-6)) ** 2
    return [Fault(better.evidence, columns, columns=values, statistic=clear, instruments=instruments)]


def course_askew(record: Record) -> Track | None:
    """The track of a record without velocities that stands at an angle to its heading which no drift or current
    explains; None for any other, and for a craft whose log says that it goes astern."""
    track = None if record.has(*TRACK) or goes_astern(record) else track_of(averages_of(record))
    return track if track is not None and track.askew else None


def known_together(record: Record, *series: np.ndarray) -> tuple[np.ndarray, ...]:
    """Times and series (N,) of a record where all are known, (M,)."""
    known = np.all([np.isfinite(values) for values in series], axis=0)
    return tuple(values[known] for values in (record.time_s, *series))


def rate_error(record: Record, name: str) -> float:
    """Share of the heading's changes over windows that a rate column does not give; nan for too few samples."""
    time, psi, rate = known_together(record, record.heading_unwrapped(), record.column(name))
    if time.size < FEWEST:
        return float("nan")
    step = min(max(2, round(WINDOW_S / 8.0 / np.median(np.diff(time)))), time.size // 2)
    turned = psi[step:] - psi[:-step]
    by_rate = integral(rate, time)
    error = turned - (by_rate[step:] - by_rate[:-step])
    return float(np.sqrt(np.mean(error**2) / max(np.mean(turned**2), 1e-300)))


def track_error(record: Record) -> float:
    """Error of the displacement over windows that heading and velocities give, as a share of the way made; nan for too
    few samples."""
    return _disagreement(*_ways(record))


def _disagreement(by_log: np.ndarray, moved: np.ndarray) -> float:
    """The same of ways (M,)."""
    if not by_log.size:
        return float("nan")
    return float(np.sqrt(np.mean(np.abs(moved - by_log) ** 2) / max(np.mean(np.abs(moved) ** 2), 1e-300)))


def _ways(record: Record) -> tuple[np.ndarray, np.ndarray]:
    """Ways (M,) north + i east over windows, as heading and velocities give them and as positions show them; empty for
    too few samples."""
    time, velocity, place = known_together(record, velocity_over_ground(record), position_over_ground(record))
    if time.size < FEWEST:
        return np.zeros(0, complex), np.zeros(0, complex)
    step = int(np.clip(round(WINDOW_S / np.median(np.diff(time))), 2, time.size // 2))
    way = integral(velocity, time)
    whole = whole_windows(time, step)
    return (way[step:] - way[:-step])[whole], (place[step:] - place[:-step])[whole]


# ---- ratios
class Ratio(NamedTuple):
    """Slope of a channel's changes over those that another one gives, and their correlation."""

    slope: float
    correlation: float


def heading_ratio(record: Record, steady: bool = True) -> Ratio | None:
    """Heading's changes over those that the yaw rate gives; None where they cannot be compared.

    A heading that wraps at 360 is unwrapped there.  steady : False: by how much the changes differ from window to
    window, to which a zero error or a drift of the yaw rate hardly adds.
    """
    record = averages_of(record)
    if not record.has(*TURN):
        return None
    time, heading, rate = known_together(record, *map(record.column, TURN))
    if time.size < FEWEST_OF_RATIO:
        return None
    changes = over_windows(time, without_wraps(heading), rate)
    if not steady:
        lag = min(_window(time), changes[0].size // 2)
        changes = tuple(x[lag:] - x[: x.size - lag] for x in changes)
    return _ratio(*changes, FEWEST_OF_RATIO // 2)


def course_ratio(record: Record) -> Ratio | None:
    """Changes of the track's course over those of the heading, over windows; None where they cannot be compared."""
    record = averages_of(record)
    if not record.has("heading_rad", "north_m", "east_m"):
        return None
    time, place, heading = known_together(record, position_over_ground(record), record.column("heading_rad"))
    if time.size < FEWEST_OF_RATIO:
        return None
    w, heading = _window(time), without_wraps(heading)
    way = place[w:] - place[:-w]
    course, turned = np.angle(way[w:] * np.conj(way[:-w])), heading[w + w // 2 :] - heading[w // 2 : -w]
    turned = turned[: course.size]
    whole = whole_windows(time, w)
    fast = np.minimum(np.abs(way[w:]), np.abs(way[:-w])) > MOVES * np.median(np.abs(way))
    fast &= whole[w:] & whole[:-w]
    return _ratio(course[fast], turned[fast], FEWEST_OF_RATIO + 1)


def speed_ratio(record: Record) -> float | None:
    """Way that the velocities give over the way that positions show, median over windows; None where they cannot be
    compared.

    Without a heading it is the length of the path: a craft that turns in a window comes to less.
    """
    ways = _way_made(record)
    if ways is None:
        return None
    moved, by_log = np.abs(ways.moved), np.abs(ways.by_log)
    fast = (moved > 0.5 * np.quantile(moved, USUAL)) & (by_log > 0.0)
    return float(np.median(by_log[fast] / moved[fast])) if fast.any() else None


def speed_ratio_in_current(record: Record) -> float | None:
    """The same beside a steady current; None where a current alone explains the way over ground nearly as well."""
    ways = _way_made(record) if record.has("heading_rad") else None
    if ways is None or ways.moved.size < FEWEST_OF_RATIO:
        return None
    by_log, moved, north, east = map(_by_axis, (ways.by_log, ways.moved, ways.duration, 1j * ways.duration))
    steady = np.column_stack([north, east])
    whole = np.column_stack([by_log, steady])
    scale, *_ = of_both = lstsq(whole, moved)
    left, of_current = moved - whole @ of_both, moved - by_log
    of_current -= steady @ lstsq(steady, of_current)
    is_better = float(np.mean(left**2)) < BETTER**2 * float(np.mean(of_current**2))
    return 1.0 / float(scale) if is_better and scale > 0.0 else None


class _Ways(NamedTuple):
    """Windows without a gap: duration (M,), s, way by the velocities and way that positions show (M,), m, the last two
    north + i east, or, without a heading, ahead + i athwart and by length only."""

    duration: np.ndarray
    by_log: np.ndarray
    moved: np.ndarray


def _way_made(record: Record) -> _Ways | None:
    record = averages_of(record)
    if not record.has("surge_m_s", "north_m", "east_m"):
        return None
    surge = record.column("surge_m_s")
    sway = record.column("sway_m_s") if record.has("sway_m_s") else np.zeros(record.n)
    headed = record.has("heading_rad")
    velocity = over_ground(surge, sway, record.column("heading_rad")) if headed else np.hypot(surge, sway)
    time, velocity, place = known_together(record, velocity, position_over_ground(record))
    if time.size < FEWEST_OF_RATIO:
        return None
    w, way = _window(time), integral(velocity, time)
    whole = whole_windows(time, w)
    return _Ways((time[w:] - time[:-w])[whole], (way[w:] - way[:-w])[whole], (place[w:] - place[:-w])[whole])


def _by_axis(way: np.ndarray) -> np.ndarray:
    """North and east (2M,) of ways (M,), north + i east."""
    return np.concatenate([way.real, way.imag])


def over_windows(time: np.ndarray, values: np.ndarray, rate: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Changes (M,) of values (N,) and of the integral of their rate (N,) over windows without a gap."""
    w = _window(time)
    whole, by_rate = whole_windows(time, w), integral(rate, time)
    return (values[w:] - values[:-w])[whole], (by_rate[w:] - by_rate[:-w])[whole]


def _ratio(change: np.ndarray, other: np.ndarray, fewest: int) -> Ratio | None:
    """Changes (M,) over those that are given (M,); None of too few, or where nothing changes."""
    spread = float(np.sqrt(np.mean(other**2) * np.mean(change**2))) if change.size >= fewest else 0.0
    if not spread > 0.0:
        return None
    both = float(np.mean(other * change))
    return Ratio(both / float(np.mean(other**2)), both / spread)


def _window(time: np.ndarray) -> int:
    """Samples of a window, at most a quarter of the record."""
    return int(np.clip(round(WINDOW_S / np.median(np.diff(time))), 2, max(time.size // 4, 2)))


def whole_windows(time: np.ndarray, w: int) -> np.ndarray:
    """(M,) windows of w samples without a gap inside."""
    steps = np.diff(time)
    usual = float(np.mean(steps[steps <= GAP * np.quantile(steps, 0.9)]))
    return time[w:] - time[:-w] < WHOLE * w * usual


def turns_back(ratio: float) -> bool:
    """Whether a ratio is that of a turned sign, beside the error of a scale: not of another unit or quantity."""
    return 0.5 < -ratio < 2.0


def unit_of(ratio: float, units: dict[float, str], near: float = NEAR) -> str | None:
    """Name of the unit whose ratio to SI this is, sign left aside; None for none."""
    alike = (name for value, name in units.items() if abs(abs(ratio) / value - 1.0) < near)
    return next(alike, None)
