"""Jumps of heading and position beyond what yaw rate and speed allow: spliced records."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...datasets.geometry import velocity_over_ground
from ...datasets.spikes import without_spikes_in_time
from .runs import never_changes

if TYPE_CHECKING:
    from ...datasets.record import Record

LIMIT = 10.0
"""Robust standard deviations of the usual disagreement from which a step is a jump."""
COARSE = 3.0
"""Steps of a coarse channel that a jump must exceed."""
NEIGHBOURS = 60
TINY = 1e-9
SIDE = 5
"""Samples that are needed to each side, whose medians must differ, too: an outlier returns, a splice does not."""


class Jump(NamedTuple):
    """Step k - 1 -> k of a channel: its change, the change that rates allow, and what the change departs from them by
    (SI)."""

    k: int
    channel: str
    change: float
    allowed: float
    error: float


def jumps(record: Record) -> list[Jump]:
    """Jumps of heading (by the yaw rate) and positions (by heading and velocities), where these are known."""
    found = []
    if record.has("heading_rad", "yaw_rate_rad_s") and not never_changes(record.column("yaw_rate_rad_s")):
        found += _jumps(record, "heading_rad", record.heading_unwrapped(), record.column("yaw_rate_rad_s"))
    if record.has("surge_m_s", "north_m", "east_m") and not never_changes(record.column("surge_m_s")):
        speed = np.abs(record.column("surge_m_s"))
        if record.has("sway_m_s"):
            speed = np.hypot(speed, record.column("sway_m_s"))
        for name in ("north_m", "east_m"):
            rate = _toward(record, name)
            found += _jumps(record, name, record.column(name), rate, np.nan_to_num(speed))
    return found


def _toward(record: Record, name: str) -> np.ndarray:
    """Velocity (N,) along north or east as heading and log give it; nan without them."""
    if not record.has("heading_rad", "sway_m_s"):
        return np.zeros(record.n)
    velocity = velocity_over_ground(record)
    return velocity.real if name == "north_m" else velocity.imag


def _jumps(
    record: Record, name: str, values: np.ndarray, rate: np.ndarray, most: np.ndarray | None = None
) -> list[Jump]:
    time = record.time_s
    values, rate = (without_spikes_in_time(x, time)[0] for x in (values, rate))
    known = np.flatnonzero(np.isfinite(values) & np.isfinite(rate))
    if known.size < 4 * SIDE:
        return []
    x, r, t = values[known], rate[known], time[known]
    span = np.diff(t)
    given = 0.5 * (r[1:] + r[:-1]) * span
    top = np.abs(r) if most is None else most[known]
    fastest = float(np.percentile(top, 99))
    error = np.diff(x) - given
    usual = 1.4826 * float(np.median(np.abs(error - np.median(error))))
    seen = np.diff(np.cumsum(np.isfinite(values))[known]) > SIDE  # a gap of the rate alone says nothing of the change
    allowed = np.where(seen, np.inf, np.maximum(LIMIT * usual, 2.0 * fastest * span))
    found = []
    for k in np.flatnonzero((np.abs(error) > allowed) & (np.abs(np.diff(x)) > allowed)) + 1:
        if abs(error[k - 1]) < COARSE * _resolution(x, int(k)):
            continue
        a, b = max(k - SIDE, 0), min(k + SIDE, x.size)
        path = np.concatenate([[0.0], np.cumsum(error[a : b - 1])])
        shift = float(np.median(path[k - a :]) - np.median(path[: k - a]))
        if min(k, x.size - k) >= SIDE and abs(shift) > 0.5 * abs(error[k - 1]):
            found.append(Jump(int(known[k]), name, float(x[k] - x[k - 1]), float(allowed[k - 1]), float(error[k - 1])))
    return found


def _resolution(x: np.ndarray, k: int) -> float:
    """Usual step of a coarse channel beside sample k, the larger of both sides; 0 where it changes in most samples."""
    usual = [0.0]
    for side in (np.diff(x[max(k - NEIGHBOURS, 0) : k]), np.diff(x[k : k + NEIGHBOURS])):
        steps = np.abs(side)
        if steps.size and np.mean(steps < TINY) > 0.3 and np.any(steps > TINY):
            usual.append(float(np.median(steps[steps > TINY])))
    return max(usual)
