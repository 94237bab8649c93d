"""Two ways in which a record shows one motion, and what sensor errors leave between them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...datasets.columns import POSITIONS
from ...datasets.signals import bridged, integral, sensor_sd

if TYPE_CHECKING:
    from ...datasets.record import Record


@dataclass(frozen=True)
class Motion:
    """What a record shows of a motion and of its rate, gaps bridged, which must agree:

        position(t) - position(0) = integral of speed(t) direction(t)

    Of a turn: heading and yaw rate, direction 1.  Of a path: position north + i east and velocity surge + i sway, in
    the direction exp(i heading).  Of a log that measures no sway: way of the positions along the heading and surge,
    direction 1.

    time (T,) from the first sample, heading (T,) rad, position (or angle), speed, direction (T,).
    drift (d, T) : what a steady drift of 1 m/s to north and to east adds to the position.
    white, walk : standard deviations of its white noise, and of the random walk after a second that the noise of the
    rate makes.
    """

    time: np.ndarray
    heading: np.ndarray
    position: np.ndarray
    speed: np.ndarray
    direction: np.ndarray
    drift: np.ndarray
    white: float
    walk: float

    @property
    def step_s(self) -> float:
        """Median sampling step, s."""
        return _step_s(self.time)

    @cached_property
    def turning_time_s(self) -> float:
        """Yaw rate over yaw acceleration (rms of both), s, from means of the heading over a 200th of the record."""
        window = max(self.time.size // 200, 1)
        n = self.time.size // window * window
        time, heading = (a[:n].reshape(-1, window).mean(axis=1) for a in (self.time, self.heading))
        rate = np.gradient(heading, time)
        slope = np.gradient(rate, time)
        return float(np.sqrt(np.mean(rate**2) / max(np.mean(slope**2), 1e-300)))

    @cached_property
    def turning(self) -> np.ndarray:
        """(T,) yaw rate that the heading shows, rad/s."""
        return np.gradient(smoothed(self.heading), self.time)

    @property
    def rate(self) -> np.ndarray:
        """(T,) rate of the position."""
        return self.speed * self.direction

    @cached_property
    def run(self) -> np.ndarray:
        """(T,) what the rate gives."""
        return integral(self.rate, self.time)

    def along(self, speed: np.ndarray | complex) -> np.ndarray:
        """(T,) what a speed, (T,) or steady, gives."""
        return integral(speed * self.direction, self.time)

    # ---- what a delay of a second leaves out
    @property
    def late(self) -> np.ndarray:
        """(T,) of a rate along one axis: its change, smoothed, since as a column of a regression its noise would draw
        estimates to zero."""
        quiet = smoothed(self.speed)
        return quiet - quiet[0]

    @property
    def late_motion(self) -> np.ndarray:
        """(T,) of velocities and heading: their change."""
        return self.rate - self.rate[0]

    @property
    def late_speeds(self) -> np.ndarray:
        """(T,) of velocities alone: sums of their changes, each in its direction."""
        middle = np.exp(0.5j * (self.heading[1:] + self.heading[:-1]))
        return np.concatenate([[0.0], np.cumsum(np.diff(self.speed) * middle)])

    @property
    def late_heading(self) -> np.ndarray:
        """(T,) of the heading alone: its yaw rate turns the velocities."""
        return integral(1j * self.rate * self.turning, self.time)


def turn_of(record: Record) -> Motion:
    """A record's heading and yaw rate."""
    time, heading = _headings(record)
    rate = bridged(record.column("yaw_rate_rad_s"), time)
    walk = sensor_sd(rate) * np.sqrt(_step_s(time))
    one, no_drift = np.ones(time.size), np.zeros((0, time.size))
    return Motion(time, heading, heading, rate, one, no_drift, sensor_sd(heading), walk)


def path_of(record: Record) -> Motion:
    """A record's track and velocities, a steady drift estimated along."""
    time, heading = _headings(record)
    surge, sway, north, east = (bridged(record.column(n), time) for n in ("surge_m_s", "sway_m_s", *POSITIONS))
    speed = float(np.mean(np.hypot(surge, sway)))
    walk = np.hypot(max(sensor_sd(surge), sensor_sd(sway)), speed * sensor_sd(heading)) * np.sqrt(_step_s(time))
    white = max(sensor_sd(north), sensor_sd(east))
    drift = np.stack([time, 1j * time])
    return Motion(time, heading, north + 1j * east, surge + 1j * sway, np.exp(1j * heading), drift, white, float(walk))


def log_of(record: Record) -> Motion:
    """A record's surge and the way of its positions along its heading, a steady drift estimated along."""
    time, heading = _headings(record)
    surge, north, east = (bridged(record.column(n), time) for n in ("surge_m_s", *POSITIONS))
    middle = 0.5 * (heading[1:] + heading[:-1])
    steps = np.diff(north) * np.cos(middle) + np.diff(east) * np.sin(middle)
    ahead = np.concatenate([[0.0], np.cumsum(steps)])
    drift = integral(np.stack([np.cos(heading), np.sin(heading)]), time)
    walk, white = sensor_sd(surge) * np.sqrt(_step_s(time)), max(sensor_sd(north), sensor_sd(east))
    return Motion(time, heading, ahead, surge, np.ones(time.size), drift, white, walk)


def _headings(record: Record) -> tuple[np.ndarray, np.ndarray]:
    """Times (T,) from the first sample and headings (T,)."""
    time = record.time_s - record.time_s[0]
    return time, bridged(record.heading_unwrapped(), time)


def _step_s(time: np.ndarray) -> float:
    return float(np.median(np.diff(time)))


def smoothed(values: np.ndarray) -> np.ndarray:
    """Series (T,) through a Gaussian filter of two samples."""
    from scipy.ndimage import gaussian_filter1d

    return gaussian_filter1d(values, 2.0, mode="nearest")


# ---- effects of sensor errors
class Effect(NamedTuple):
    """What a sensor error of size one adds to the position, less what the rate gives.

    parameter, unit : of its size.  instruments : the numbers that correct it.  column : (T,) of a motion.  floor : the
    size from which it matters in a record.  delay : the size cannot be negative, and below a share of the sampling step
    it is not seen.  sizes : the least and the largest one, without sign, that the error is believed of.
    """

    parameter: str
    unit: str
    instruments: tuple[str, ...]
    column: Callable[[Motion], np.ndarray]
    floor: Callable[[Motion], float]
    delay: bool = False
    sizes: tuple[float, float] = (0.0, np.inf)


def scale(
    column: Callable[[Motion], np.ndarray],
    *instruments: str,
    parameter: str = "s",
    sizes: tuple[float, float] = (0.0, np.inf),
) -> Effect:
    """The effect of a scale error, which matters from half a percent; sizes : as of `Effect`."""
    return Effect(parameter, "1", instruments, column, lambda motion: 0.005, sizes=sizes)


def angle(column: Callable[[Motion], np.ndarray], *instruments: str, parameter: str = "b") -> Effect:
    """The effect of an error of a heading, which matters from half a degree."""
    return Effect(parameter, "rad", instruments, column, lambda motion: float(np.deg2rad(0.5)))


def late(column: Callable[[Motion], np.ndarray], *instruments: str) -> Effect:
    """The effect of a delay, which matters from half a sampling step, or two percent of the time in which the ship
    changes its turn."""
    return Effect(
        "tau", "s", instruments, column, lambda motion: max(0.5 * motion.step_s, 0.02 * motion.turning_time_s), True
    )


def zero_floor(motion: Motion) -> float:
    """Floor of the zero error of a rate, or of the sway: half a percent of the motion, or a tenth of the sensor's
    noise."""
    own = motion.speed.imag if np.iscomplexobj(motion.speed) else motion.speed
    return max(0.005 * _rms(motion.speed), 0.1 * sensor_sd(own))


def lever_floor(motion: Motion) -> float:
    """Floor of a distance ahead, m: a tenth of the positions' noise, or what turns into a twentieth of the sway."""
    return max(0.1 * motion.white, 0.05 * _rms(motion.speed.imag) / max(_rms(motion.turning), 1e-12))


def curve_floor(motion: Motion) -> float:
    """Floor of the growth of a scale with the speed, s/m: one percent over the range of speeds."""
    slow, fast = np.quantile(np.abs(motion.speed.real), [0.02, 0.98])
    return 0.01 / max(float(fast - slow), 1e-12)


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.abs(values) ** 2)))
