"""What other channels say about a column: rates against angles, speeds against tracks, headings against courses."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ..geometry import body_velocities, unwrapped
from ..grammar import DEGREE
from ..signals import integral
from .quantities import LogUnit

FEWEST = 20
"""Samples in common below which nothing is compared."""
AGREEING = 0.9
"""Correlation from which on two channels tell of each other."""
FOLLOWING = 0.8
"""Correlation from which on one channel follows another."""
MOST_LAGS, MOST_SAMPLES = 200, 10_000
"""Lags to either side, and samples, by which two rudders are compared."""
SAME_RUN = 0.9
"""Share of their time in common from which on two logs that count from a start are taken for one run."""
GAP = 3.0
"""How many times longer than usual a part is that holds a gap, over which no rate is integrated."""
SPIKE, MOST_SPIKES = 8.0, 0.15
"""Median distances from which on a sample is a spike, and the share of the samples that may be spikes."""
LEAST_TURN_RAD = 0.3
"""Change of the course from which on the sense of rotation shows."""


MOST = 50_000
"""Samples up to which series are compared as they are, lag by lag."""


@dataclass(frozen=True)
class ClockSeries:
    """Values (N,) over times (N,), s; series of an equal clock, or that are both dated, can be compared."""

    time: np.ndarray
    values: np.ndarray
    clock: str
    dated: bool

    def comparable(self, other: ClockSeries) -> bool:
        """Whether the times are of one clock."""
        return self.clock == other.clock or (self.dated and other.dated)


def known(series: ClockSeries, angle: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """(times, values) that are known, times rising; an angle without its jumps."""
    values = unwrapped(series.values) if angle else series.values
    sound = np.isfinite(series.time) & np.isfinite(values)
    time, values = series.time[sound], values[sound]
    rising = np.concatenate([[True], np.diff(np.maximum.accumulate(time)) > 0.0]) if time.size else sound[:0]
    return time[rising], values[rising]


def together(first: ClockSeries, second: ClockSeries, angle_first=False, angle_second=False):
    """(times, first, second) at the times of the slower of two series; None where they share too few."""
    if not first.comparable(second):
        return None
    (t1, x1), (t2, x2) = known(first, angle_first), known(second, angle_second)
    if t1.size < FEWEST or t2.size < FEWEST:
        return None
    slow = t1 if np.median(np.diff(t1)) >= np.median(np.diff(t2)) else t2
    grid = slow[(slow >= max(t1[0], t2[0])) & (slow <= min(t1[-1], t2[-1]))]
    if grid.size < FEWEST:
        return None
    return grid, np.interp(grid, t1, x1), np.interp(grid, t2, x2)


def rate_ratio(angle: ClockSeries, rate: ClockSeries) -> float | None:
    """Changes of an angle, rad, over those of the integral of a rate; None where they do not correlate."""
    shared = together(angle, rate, angle_first=True)
    if shared is None:
        return None
    time, turned, turning = shared
    turns = integral(turning, time)
    window = max(1, min(time.size // 10, 50))
    span = time[window:] - time[:-window]
    whole = span < GAP * np.median(span)
    change, summed = (turned[window:] - turned[:-window])[whole], (turns[window:] - turns[:-window])[whole]
    if float(np.std(change)) < 0.1 * DEGREE:
        return None
    ratio = _ratio(change, summed)
    if ratio is None:  # spikes, or a bias of the rate
        ratio = _ratio(*_without_spikes(change, summed)) or _ratio(change - change.mean(), summed - summed.mean())
    return ratio


def _without_spikes(wanted: np.ndarray, given: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two series (N,) without the few samples in which one is far from the usual multiple of the other."""
    moving = np.abs(given) > np.median(np.abs(given))
    usual = float(np.median(wanted[moving] / given[moving])) if moving.any() else 0.0
    apart = np.abs(wanted - usual * given)
    near = apart <= SPIKE * float(np.median(apart)) + 1e-12
    return (wanted[near], given[near]) if 1.0 - np.mean(near) < MOST_SPIKES else (wanted, given)


def cosine(a: np.ndarray, b: np.ndarray) -> float:
    """The product of two series (N,) over their sizes; 0 where one is zero throughout."""
    power = math.sqrt(float(a @ a) * float(b @ b))
    return float(a @ b) / power if power > 0.0 else 0.0


def correlation(a: np.ndarray, b: np.ndarray) -> float:
    """Correlation of two series (N,); 0 where one is constant."""
    return cosine(a - a.mean(), b - b.mean())


def mean_direction(angle: np.ndarray) -> tuple[float, float]:
    """(length of the mean direction between 0 and 1, mean angle) of angles (N,)."""
    mean = np.exp(1j * angle).mean()
    return float(abs(mean)), float(np.angle(mean))


def _ratio(wanted: np.ndarray, given: np.ndarray) -> float | None:
    """wanted over given, by their powers; None where they do not correlate."""
    power, other = float(given @ given), float(wanted @ wanted)
    if not (power > 0.0 and other > 0.0 and math.isfinite(power) and math.isfinite(other)):
        return None
    alike = cosine(wanted, given)
    return math.copysign(math.sqrt(other / power), alike) if abs(alike) > AGREEING else None


def slope(first: ClockSeries, second: ClockSeries) -> float | None:
    """Changes of the first series over those of the second about their means; None where they do not correlate."""
    shared = together(first, second)
    if shared is None:
        return None
    _, a, b = shared
    return _ratio(a - a.mean(), b - b.mean())


def follows(first: ClockSeries, second: ClockSeries, longest_s: float = 20.0) -> int | None:
    """1 where the first series follows the second some seconds later, -1 where it follows its opposite; else None.

    Of a long series averages are compared, over no more than a twentieth of the longest time: lags of parts of that
    make no difference to whether it follows.
    """
    shared = together(first, second)
    if shared is None:
        return None
    time, a, b = liveliest(*shared, longest_s)
    step = float(np.median(np.diff(time)))
    count = min(a.size // MOST, int(longest_s / 20.0 / step))
    if count > 1:
        step *= count
        a, b = (x[: x.size // count * count].reshape(-1, count).mean(axis=1) for x in (a, b))
    _, best = best_lag(a, b, range(0, -int(min(a.size // 2, longest_s / step)) - 1, -1))
    return (1 if best > 0.0 else -1) if abs(best) > FOLLOWING else None


def best_lag(a: np.ndarray, b: np.ndarray, lags: range) -> tuple[int, float]:
    """(lag of the second of two series (N,), in samples, at which they correlate best; the correlation)."""
    n = a.size
    found = {lag: correlation(a[max(-lag, 0) : n - max(lag, 0)], b[max(lag, 0) : n - max(-lag, 0)]) for lag in lags}
    lag = max(found, key=lambda k: abs(found[k]))
    return lag, found[lag]


def liveliest(
    time: np.ndarray, a: np.ndarray, b: np.ndarray, longest_s: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The samples about where two series (N,) move most, thinned so that few lags of up to `longest_s` are tried."""
    every = max(1, int(longest_s / float(np.median(np.diff(time))) / MOST_LAGS))
    time, a, b = time[::every], a[::every], b[::every]
    if time.size <= MOST_SAMPLES:
        return time, a, b
    moved = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(b)))])
    first = int(np.argmax(moved[MOST_SAMPLES:] - moved[:-MOST_SAMPLES]))
    part = slice(first, first + MOST_SAMPLES)
    return time[part], a[part], b[part]


def as_of_one_clock(series: ClockSeries, other: ClockSeries) -> ClockSeries:
    """A series on the clock of another, where both count seconds from a start and last as long: for a comparison that
    allows for lags."""
    if series.dated or other.dated or not (series.time.size and other.time.size):
        return series
    (a, b), (c, d) = ((np.nanmin(s.time), np.nanmax(s.time)) for s in (series, other))
    shared = min(b, d) - max(a, c)
    return replace(series, clock=other.clock) if shared > SAME_RUN * (max(b, d) - min(a, c)) else series


def size_ratio(first: ClockSeries, second: ClockSeries) -> float | None:
    """The size of the first over that of the second, both positive in the main; None where the ratio varies widely."""
    shared = together(first, second)
    if shared is None:
        return None
    _, a, b = shared
    moving = (np.abs(b) > 0.2 * np.quantile(np.abs(b), 0.9)) & (np.abs(a) > 0.0)
    if moving.sum() < FEWEST:
        return None
    ratios = a[moving] / b[moving]
    middle = float(np.median(ratios))
    spread = float(np.subtract(*np.quantile(ratios, [0.75, 0.25])))
    return middle if middle != 0.0 and spread < 0.35 * abs(middle) else None


def nearest(size: float, units: tuple[LogUnit, ...], within: float) -> LogUnit | None:
    """The unit whose factor is the nearest to a size, if it is within a share of it."""
    best = min(units, key=lambda unit: abs(math.log(abs(size) / unit.factor)))
    return best if abs(abs(size) / best.factor - 1.0) < within else None


def track_velocity(north: ClockSeries, east: ClockSeries) -> tuple[ClockSeries, ClockSeries] | None:
    """Velocities to north and east, m/s, of a track in metres, over windows of some seconds."""
    shared = together(north, east)
    if shared is None:
        return None
    time, n, e = shared
    moved = (np.diff(n) != 0.0) | (np.diff(e) != 0.0)
    fresh = np.concatenate([[True], moved])
    time, n, e = time[fresh], n[fresh], e[fresh]
    if time.size < FEWEST:
        return None
    step = float(np.median(np.diff(time)))
    width = int(max(1, min(time.size // 10, math.ceil(3.0 / step))))
    span = time[2 * width :] - time[: -2 * width]
    middle = time[width:-width]
    north_speed, east_speed = (n[2 * width :] - n[: -2 * width]) / span, (e[2 * width :] - e[: -2 * width]) / span
    return replace(north, time=middle, values=north_speed), replace(north, time=middle, values=east_speed)


def sense(heading: ClockSeries, north: ClockSeries, east: ClockSeries) -> tuple[str, float] | None:
    """How a heading, rad, turns with the course of velocities to north and east: ('with', mean of course - heading) or
    ('against', mean of course + heading); None where the course hardly changes or nothing agrees."""
    shared = _course_beside(heading, north, east)
    if shared is None:
        return None
    course, psi = shared
    if course.size < FEWEST or np.ptp(np.unwrap(course)) < LEAST_TURN_RAD or np.ptp(psi) < LEAST_TURN_RAD / 3.0:
        return None
    with_, offset = mean_direction(course - psi)
    against, total = mean_direction(course + psi)
    if max(with_, against) < AGREEING or abs(with_ - against) < 0.03:
        return None
    return ("with", offset) if with_ > against else ("against", total)


def sum_with_course(heading: ClockSeries, north: ClockSeries, east: ClockSeries) -> float | None:
    """Mean of course + heading, rad, of a heading that turns against the course: from where it counts; None where the
    ship hardly moves, or they do not go together."""
    shared = _course_beside(heading, north, east)
    if shared is None:
        return None
    course, psi = shared
    length, total = mean_direction(course + psi)
    return total if length > AGREEING else None


def _course_beside(heading: ClockSeries, north: ClockSeries, east: ClockSeries) -> tuple[np.ndarray, np.ndarray] | None:
    """Course of velocities to north and east, and heading, rad, (M,) while the ship moves; None where these are too
    few."""
    shared = _beside_heading(heading, north, east)
    if shared is None:
        return None
    _, psi, vn, ve = shared
    speed = np.hypot(vn, ve)
    moving = speed > 0.3 * np.quantile(speed, 0.8)
    return np.arctan2(ve, vn)[moving], psi[moving]


def _beside_heading(heading: ClockSeries, north: ClockSeries, east: ClockSeries) -> tuple[np.ndarray, ...] | None:
    """(times, heading, velocities to north and east) at the times that all have; None where these are too few."""
    first, second = (together(heading, velocity, angle_first=True) for velocity in (north, east))
    if first is None or second is None or first[1].size != second[1].size:
        return None
    return *first, second[2]


def body(heading: ClockSeries, north: ClockSeries, east: ClockSeries) -> tuple[ClockSeries, ClockSeries] | None:
    """Velocities forward and to starboard of velocities over ground and a heading, rad."""
    shared = _beside_heading(heading, north, east)
    if shared is None:
        return None
    time, psi, *over_ground = shared
    forward, starboard = body_velocities(*over_ground, psi)
    return replace(heading, time=time, values=forward), replace(heading, time=time, values=starboard)
