"""Units and signs: the ratio of what a channel shows to what another one gives; of long records, of averages."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...datasets.columns import TURN
from ...datasets.geometry import over_ground, position_over_ground
from ...datasets.signals import integral
from .averages import averages_of
from .wraps import without_wraps

if TYPE_CHECKING:
    from ...datasets.record import Record

WINDOW_S = 8.0
FEWEST = 30
MOVES = 0.2
"""Share of the usual way made in a window from which it has a course."""
USUAL = 0.75
"""Quantile of the ways made in windows that is taken for the usual one: windows over a jump may be the largest."""
WHOLE = 1.5
"""Times its usual duration beyond which a window holds a gap."""
AGREE = 0.95
"""Correlation from which a ratio is believed."""
NEAR = 0.06
"""Share by which a ratio may differ from that of two units."""
ANGLES = {np.pi / 180.0: "radians where degrees are meant", 180.0 / np.pi: "degrees where radians are meant"}
PLACES = {1.0 / 0.3048: "ft", 1e-3: "km", 1.0 / 1852.0: "nautical miles"}
SPEEDS = {3600.0 / 1852.0: "knots", 3.6: "km/h", 1.0 / 0.3048: "ft/s"}


class Ratio(NamedTuple):
    """Slope of a channel's changes over those that another one gives, and their correlation."""

    slope: float
    correlation: float


def heading_ratio(record: Record) -> Ratio | None:
    """Heading's changes over those that the yaw rate gives; None where they cannot be compared.

    A heading that wraps at 360 is unwrapped there.
    """
    record = averages_of(record)
    if not record.has(*TURN):
        return None
    heading = record.column("heading_rad")
    known = np.isfinite(heading) & np.isfinite(record.column("yaw_rate_rad_s"))
    if known.sum() < FEWEST:
        return None
    rate = record.column("yaw_rate_rad_s")[known]
    return _ratio(*over_windows(record.time_s[known], without_wraps(heading[known]), rate), FEWEST // 2)


def course_ratio(record: Record) -> Ratio | None:
    """Changes of the track's course over those of the heading, over windows; None where they cannot be compared."""
    record = averages_of(record)
    if not record.has("heading_rad", "north_m", "east_m"):
        return None
    place = position_over_ground(record)
    known = np.isfinite(place) & np.isfinite(record.column("heading_rad"))
    if known.sum() < FEWEST:
        return None
    place, heading = place[known], without_wraps(record.column("heading_rad")[known])
    w = max(_window(record.time_s[known]), 2)
    way = place[w:] - place[:-w]
    course, turned = np.angle(way[w:] * np.conj(way[:-w])), heading[w + w // 2 :] - heading[w // 2 : -w]
    turned = turned[: course.size]
    whole = whole_windows(record.time_s[known], w)
    fast = np.minimum(np.abs(way[w:]), np.abs(way[:-w])) > MOVES * np.median(np.abs(way))
    fast &= whole[w:] & whole[:-w]
    return _ratio(course[fast], turned[fast], FEWEST + 1)


def speed_ratio(record: Record) -> float | None:
    """Way that the velocities give over the way that positions show, median over windows; None where they cannot be
    compared.

    Without a heading it is the length of the path: a craft that turns in a window comes to less.
    """
    record = averages_of(record)
    if not record.has("surge_m_s", "north_m", "east_m"):
        return None
    surge, sway = (
        record.column("surge_m_s"),
        record.column("sway_m_s") if record.has("sway_m_s") else np.zeros(record.n),
    )
    headed = record.has("heading_rad")
    velocity = over_ground(surge, sway, record.column("heading_rad")) if headed else np.hypot(surge, sway)
    place = position_over_ground(record)
    known = np.isfinite(velocity) & np.isfinite(place)
    if known.sum() < FEWEST:
        return None
    time, place = record.time_s[known], place[known]
    w, way = _window(time), integral(velocity[known], time)
    moved, given = np.abs(place[w:] - place[:-w]), np.abs(way[w:] - way[:-w])
    fast = (moved > 0.5 * np.quantile(moved, USUAL)) & (given > 0.0) & whole_windows(time, w)
    return float(np.median(given[fast] / moved[fast])) if fast.any() else None


def over_windows(time: np.ndarray, values: np.ndarray, rate: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Changes (M,) of values (N,) and of the integral of their rate (N,) over windows without a gap."""
    w = _window(time)
    whole, given = whole_windows(time, w), integral(rate, time)
    return (values[w:] - values[:-w])[whole], (given[w:] - given[:-w])[whole]


def _ratio(change: np.ndarray, given: np.ndarray, fewest: int) -> Ratio | None:
    """Changes (M,) over those that are given (M,); None of too few, or where nothing changes."""
    spread = float(np.sqrt(np.mean(given**2) * np.mean(change**2))) if change.size >= fewest else 0.0
    if not spread > 0.0:
        return None
    both = float(np.mean(given * change))
    return Ratio(both / float(np.mean(given**2)), both / spread)


def _window(time: np.ndarray) -> int:
    """Samples of a window, at most a quarter of the record."""
    return int(np.clip(round(WINDOW_S / np.median(np.diff(time))), 2, max(time.size // 4, 2)))


def whole_windows(time: np.ndarray, w: int) -> np.ndarray:
    """(M,) windows of w samples without a gap inside."""
    span = time[w:] - time[:-w]
    return span < WHOLE * np.median(span)


def turns_back(ratio: float) -> bool:
    """Whether a ratio is that of a turned sign, beside the error of a scale: not of another unit or quantity."""
    return 0.5 < -ratio < 2.0


def unit_of(ratio: float, units: dict[float, str]) -> str | None:
    """Name of the unit whose ratio to SI this is, sign left aside; None for none."""
    near = [name for value, name in units.items() if abs(abs(ratio) / value - 1.0) < NEAR]
    return near[0] if near else None
