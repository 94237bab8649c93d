"""What sensor errors leave between heading and yaw rate, and between a track and the velocities that made it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Generic, TypeVar

import numpy as np

from ...datasets.columns import POSITIONS, TRACK
from ...datasets.signals import bridged, integral, sensor_sd

if TYPE_CHECKING:
    from ...datasets.record import Record


M = TypeVar("M", bound="SensedMotion")


@dataclass(frozen=True)
class SensorEffect(Generic[M]):
    """What a sensor error of size one leaves between channels that must agree.

    Of a track (M is `Path`): of the positions, less the way made by velocities and heading.  Of a turn (M is `Turn`):
    of the heading, less the integrated yaw rate.  Of a log (M is `Log`): of the way along the heading, less the
    integrated surge.

    parameter, unit : of its size.  instruments : the numbers that correct it.  column : (2, T) north and east of a
    path, or (1, T) of a turn.  floor : the size from which it matters in a record.  delay : the size cannot be
    negative, and below a share of the sampling step it is not seen.
    """

    parameter: str
    unit: str
    instruments: tuple[str, ...]
    column: Callable[[M], np.ndarray]
    floor: Callable[[M], float]
    delay: bool = False


def late_floor(motion: SensedMotion) -> float:
    """Floor of a delay, s: half a sampling step, or two percent of the time in which the ship changes its turn."""
    return max(0.5 * motion.step_s, 0.02 * motion.turning_time_s)


def none(motion: SensedMotion) -> float:
    """Floor of a size that does not matter by itself."""
    return float("inf")


def half_a_percent(motion: SensedMotion) -> float:
    """Floor of a scale (1)."""
    return 0.005


def half_a_degree(motion: SensedMotion) -> float:
    """Floor of an angle, rad."""
    return float(np.deg2rad(0.5))


@dataclass(frozen=True)
class SensedMotion:
    """Time (T,) from the first sample, and the heading (T,), gaps bridged."""

    time: np.ndarray
    heading: np.ndarray

    @property
    def step_s(self) -> float:
        """Median sampling step, s."""
        return float(np.median(np.diff(self.time)))

    @cached_property
    def turning_time_s(self) -> float:
        """Yaw rate over yaw acceleration (rms of both), s, from means of the heading over a 200th of the record."""
        window = max(self.time.size // 200, 1)
        n = self.time.size // window * window
        time, heading = (a[:n].reshape(-1, window).mean(axis=1) for a in (self.time, self.heading))
        rate = np.gradient(heading, time)
        slope = np.gradient(rate, time)
        return float(np.sqrt(np.mean(rate**2) / max(np.mean(slope**2), 1e-300)))


@dataclass(frozen=True)
class Turn(SensedMotion):
    """Heading and yaw rate (T,) of a record, gaps bridged."""

    rate: np.ndarray

    @cached_property
    def turned(self) -> np.ndarray:
        """(T,) heading that the yaw rate gives."""
        return integral(self.rate, self.time)

    @cached_property
    def late_rate(self) -> np.ndarray:
        """(1, T) heading that a yaw rate a second late leaves out: the rate's change, smoothed, since as a column of a
        regression its noise would draw estimates to zero."""
        quiet = smoothed(self.rate)
        return (quiet - quiet[0])[None]

    @property
    def rate_floor(self) -> float:
        """Floor of a bias, rad/s: half a percent of the motion, or a tenth of the sensor's noise."""
        return max(0.005 * float(np.sqrt(np.mean(self.rate**2))), 0.1 * sensor_sd(self.rate))


def turn_of(record: Record) -> Turn:
    """A record's heading and yaw rate, with gaps bridged."""
    time = record.time_s - record.time_s[0]
    heading = bridged(record.heading_unwrapped(), time)
    return Turn(time, heading, bridged(record.column("yaw_rate_rad_s"), time))


def smoothed(values: np.ndarray) -> np.ndarray:
    """Series (T,) through a Gaussian filter of two samples."""
    from scipy.ndimage import gaussian_filter1d

    return gaussian_filter1d(values, 2.0, mode="nearest")


@dataclass(frozen=True)
class Path(SensedMotion):
    """Surge, sway, north and east (T,) of a record beside its heading, gaps bridged."""

    surge: np.ndarray
    sway: np.ndarray
    north: np.ndarray
    east: np.ndarray

    @cached_property
    def rates(self) -> np.ndarray:
        """(2, T) velocities north and east."""
        c, s = np.cos(self.heading), np.sin(self.heading)
        return np.stack([self.surge * c - self.sway * s, self.surge * s + self.sway * c])

    @cached_property
    def way(self) -> np.ndarray:
        """(2, T) way made by the velocities."""
        return integral(self.rates, self.time)

    def along(self, surge: np.ndarray) -> np.ndarray:
        """(2, T) way that a surge (T,) makes."""
        return integral(surge * np.stack([np.cos(self.heading), np.sin(self.heading)]), self.time)

    @property
    def turned_way(self) -> np.ndarray:
        """(2, T) change of the way by a heading that is too large."""
        return np.stack([self.way[1], -self.way[0]])

    @property
    def of_sway(self) -> np.ndarray:
        """(2, T) way that a sway that is too large adds, negative."""
        return integral(np.stack([np.sin(self.heading), -np.cos(self.heading)]), self.time)

    @property
    def late_speeds(self) -> np.ndarray:
        """(2, T) sums of the speeds' changes, turned north and east: the way that speeds a second late leave out."""
        middle = 0.5 * (self.heading[1:] + self.heading[:-1])
        cosine, sine, along, across = np.cos(middle), np.sin(middle), np.diff(self.surge), np.diff(self.sway)
        steps = np.stack([along * cosine - across * sine, along * sine + across * cosine])
        return np.concatenate([np.zeros((2, 1)), np.cumsum(steps, axis=1)], axis=1)

    @property
    def late_heading(self) -> np.ndarray:
        """(2, T) way that a heading a second late leaves out: its yaw rate turns the velocities."""
        rate = np.gradient(smoothed(self.heading), self.time)
        return integral(np.stack([-self.rates[1], self.rates[0]]) * rate, self.time)

    @property
    def ahead(self) -> np.ndarray:
        """(2, T) way that a point 1 m forward makes beyond that of its ship."""
        c, s = np.cos(self.heading), np.sin(self.heading)
        return np.stack([c - c[0], s - s[0]])

    @property
    def lever_floor(self) -> float:
        """Floor of a distance ahead, m: a tenth of the positions' noise, or what turns into a twentieth of the sway."""
        sway, turn = (
            float(np.sqrt(np.mean(x**2))) for x in (self.sway, np.gradient(smoothed(self.heading), self.time))
        )
        return max(0.1 * sensor_sd(self.north), 0.1 * sensor_sd(self.east), 0.05 * sway / max(turn, 1e-12))

    @property
    def sway_floor(self) -> float:
        """Floor of a sway offset, m/s: half a percent of the speed, or a tenth of the sensor's noise."""
        speed = float(np.sqrt(np.mean(self.surge**2 + self.sway**2)))
        return max(0.005 * speed, 0.1 * sensor_sd(self.sway))

    @property
    def late_motion(self) -> np.ndarray:
        """(2, T) the same where the heading is late as well."""
        return self.rates - self.rates[:, :1]


def path_of(record: Record) -> Path:
    """A record's path, with gaps bridged."""
    time = record.time_s - record.time_s[0]
    heading = bridged(record.heading_unwrapped(), time)
    return Path(time, heading, *(bridged(record.column(name), time) for name in TRACK[1:]))


@dataclass(frozen=True)
class Log(SensedMotion):
    """Way (T,) that the positions make along the heading, m, and surge (T,) of a log that measures no sway; gaps are
    bridged."""

    ahead: np.ndarray
    surge: np.ndarray
    place_sd: float

    @cached_property
    def run(self) -> np.ndarray:
        """(T,) way that the surge gives, m."""
        return integral(self.surge, self.time)

    def along(self, surge: np.ndarray) -> np.ndarray:
        """(1, T) way that a surge (T,) makes."""
        return integral(surge, self.time)[None]

    @property
    def late_speed(self) -> np.ndarray:
        """(1, T) change of the surge, smoothed: the way that a surge a second late leaves out."""
        quiet = smoothed(self.surge)
        return (quiet - quiet[0])[None]


def log_of(record: Record) -> Log:
    """A record's surge, and the way of its positions along its heading, with gaps bridged."""
    time = record.time_s - record.time_s[0]
    heading, surge = bridged(record.heading_unwrapped(), time), bridged(record.column("surge_m_s"), time)
    north, east = (bridged(record.column(name), time) for name in POSITIONS)
    middle = 0.5 * (heading[1:] + heading[:-1])
    steps = np.diff(north) * np.cos(middle) + np.diff(east) * np.sin(middle)
    ahead = np.concatenate([[0.0], np.cumsum(steps)])
    return Log(time, heading, ahead, surge, max(sensor_sd(north), sensor_sd(east)))


def curve_floor(motion: Path | Log) -> float:
    """Floor of the growth of a scale with the speed, s/m: one percent over the range of speeds."""
    slow, fast = np.quantile(np.abs(motion.surge), [0.02, 0.98])
    return 0.01 / max(float(fast - slow), 1e-12)


TurnEffect = SensorEffect[Turn]
TrackEffect = SensorEffect[Path]
LogEffect = SensorEffect[Log]
SurgeEffect = SensorEffect[Path | Log]
