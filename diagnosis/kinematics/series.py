"""What sensor errors leave between a track and the velocities and headings that made it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ...estimation.series import bridged, sensor_sd

if TYPE_CHECKING:
    from ...datasets.record import Record

NEEDED = ("heading_rad", "surge_m_s", "sway_m_s", "north_m", "east_m")


@dataclass(frozen=True)
class TrackEffect:
    """What a sensor error of size one leaves of the positions, less the way made by velocities and heading.

    parameter, unit : of its size.  instruments : the numbers that correct it.  column : a path -> (2, T) north and
    east.  delay : the size cannot be negative, and below a share of the sampling step it is not seen.
    """

    parameter: str
    unit: str
    instruments: tuple[str, ...]
    column: Callable[[Path], np.ndarray]
    delay: bool = False


@dataclass(frozen=True)
class Path:
    """Time (T,), heading, surge, sway, north and east (T,) of a record, gaps bridged."""

    time: np.ndarray
    heading: np.ndarray
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
    def late_motion(self) -> np.ndarray:
        """(2, T) the same where the heading is late as well."""
        return self.rates - self.rates[:, :1]


def path_of(record: Record) -> Path:
    """A record's path, with gaps bridged."""
    time = record.time_s - record.time_s[0]
    heading = bridged(record.heading_unwrapped(), time)
    return Path(time, heading, *(bridged(record.column(name), time) for name in NEEDED[1:]))


def whitened(record: Record, effects: list[TrackEffect]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of one record: departure (2T,), columns (2T, k) of the effects and (2T, 2) of a steady drift, whitened.

    The log's noise is a random walk of the way made and the positions' noise white.
    """
    path = path_of(record)
    zero = np.zeros_like(path.time)
    drift = [np.stack([path.time, zero]), np.stack([zero, path.time])]
    series = [np.stack([path.north, path.east]) - path.way, *(effect.column(path) for effect in effects), *drift]
    place = max(sensor_sd(path.north), sensor_sd(path.east), 1e-6)
    speed = float(np.mean(np.hypot(path.surge, path.sway)))
    walk = np.hypot(max(sensor_sd(path.surge), sensor_sd(path.sway)), speed * sensor_sd(path.heading))
    known = np.isfinite(record.column("north_m")) & np.isfinite(record.column("east_m"))
    rows = local_level(np.stack(series), known, place, float(walk * np.median(np.diff(path.time))))
    return rows[0], rows[1 : 1 + len(effects)].T, rows[1 + len(effects) :].T


def integral(rates: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Integrals (..., T) of rates (..., T), 0 at the start."""
    from scipy.integrate import cumulative_trapezoid

    return cumulative_trapezoid(rates, time, initial=0.0)


def local_level(series: np.ndarray, known: np.ndarray, place: float, walk: float) -> np.ndarray:
    """Whitened innovations (m, 2 T) of series (m, 2, T) under white noise on a random walk from an unknown start."""
    level = series[:, :, 0].copy()
    variance = place**2
    out = np.zeros_like(series)
    for k in range(1, series.shape[2]):
        variance += walk**2
        if not known[k]:
            continue
        total = variance + place**2
        error = series[:, :, k] - level
        out[:, :, k] = error / np.sqrt(total)
        level += variance / total * error
        variance *= place**2 / total
    return out.reshape(len(series), -1)
