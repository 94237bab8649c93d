"""Manoeuvring indices of a record: zigzag overshoots, turning-circle distances.

Definitions of IMO MSC.137(76) and MSC/Circ.1053: an overshoot is the extra heading change after counter rudder;
advance is the distance made good along the approach course from the position at execute to a heading change of
90 degrees, transfer and tactical diameter are the distances off the approach course at 90 and 180 degrees. The
approach course is the line through the first sample along its heading (a drift off it before the execute is
part of the transfer). Values between samples are interpolated linearly; distances count towards the side
of the turn.
"""

from __future__ import annotations

import math

import numpy as np

from ..models.errors import BadInput
from .record import Record

PLATEAU = 0.95
MOVED = 0.05
STEADY_SHARE = 0.05


def executes(record: Record) -> np.ndarray:
    """Sample numbers at which the rudder is ordered over, (k,) int; the first is the first execute.

    Read from the rudder command (a step: the first sample of the new order) or else from the rudder angle
    (the last sample before it leaves its plateau). Empty if the rudder never moves.
    """
    commanded = record.has("rudder_command_rad")
    rudder = record.column("rudder_command_rad") if commanded else record.rudder()
    seen = np.flatnonzero(np.isfinite(rudder))
    values = rudder[seen]
    size = np.max(np.abs(values), initial=0.0)
    if size == 0.0:
        return np.empty(0, dtype=np.intp)
    held = np.flatnonzero(np.abs(values) >= PLATEAU * size)
    turns = np.flatnonzero(np.diff(np.sign(values[held])) != 0)
    moved = np.flatnonzero(np.abs(values - values[0]) > MOVED * size)
    first = max(int(moved[0]) - 1, 0) if moved.size else 0
    marks = [first, *(_summit(np.abs(values), int(i)) for i in held[turns])]
    after = commanded and bool(moved.size)
    return seen[np.minimum(np.array(marks) + after, values.size - 1)].astype(np.intp)


def _summit(values: np.ndarray, at: int) -> int:
    """The sample, at or before ``at``, from which ``values`` only falls."""
    while at > 0 and values[at - 1] > values[at]:
        at -= 1
    return at


def execute_times(record: Record) -> np.ndarray:
    """Times of the executes (k,) in s; see `executes`."""
    return record.time_s[executes(record)]


def overshoots(record: Record) -> list[float]:
    """Overshoot angles of a zigzag in rad: heading beyond that at each counter-rudder order, until it turns.

    An overshoot that the record does not finish is left out. Needs heading and a rudder column.
    Raises BadInput if the record holds no counter rudder.
    """
    heading = record.heading_unwrapped()
    return [abs(float(heading[at] - heading[start])) for start, at in _extremes(record)]


def overshoot_times(record: Record) -> list[float]:
    """Times in s of the heading extremes that belong to `overshoots`."""
    return [float(record.time_s[at]) for _, at in _extremes(record)]


def _extremes(record: Record) -> list[tuple[int, int]]:
    """Samples of each counter-rudder order and of the heading extreme that follows it."""
    marks = executes(record).tolist()
    if len(marks) < 2:
        raise BadInput("no counter rudder: not a zigzag", file=record.name)
    heading = record.heading_unwrapped()
    found = []
    for before, start, end in zip(marks[:-1], marks[1:], [*marks[2:], record.n - 1], strict=True):
        swing = 1.0 if heading[start] >= heading[before] else -1.0
        at = start + int(np.nanargmax(swing * heading[start : end + 1]))
        if at < record.n - 1:
            found.append((start, at))
    return found


def turning_indices(record: Record, execute_s: float | None = None) -> dict[str, float]:
    """Indices of a turning circle, distances in m, times in s after execute; nan where the turn does not reach.

    Keys: advance, transfer, t90, tactical_diameter, t180, max_advance, max_transfer, steady_radius,
    steady_speed (m/s), steady_yaw_rate (rad/s, absolute), drift_angle (rad, positive bow into the turn).
    ``execute_s`` is the time of the execute (default: read from the rudder). Needs north_m, east_m and
    heading_rad. Raises BadInput if the rudder never moves and ``execute_s`` is not given.
    """
    time = record.time_s
    if execute_s is None:
        marks = execute_times(record)
        if marks.size == 0:
            raise BadInput("the rudder never moves: not a turn", file=record.name)
        execute_s = float(marks[0])
    change = record.heading_unwrapped() - record.heading_unwrapped()[0]
    side = 1.0 if change[-1] >= change[np.searchsorted(time, execute_s)] else -1.0
    ahead, across = _track(record, execute_s, side)
    t90, t180 = (_reach(time, side * change, angle) for angle in (0.5 * math.pi, math.pi))
    after = time >= execute_s
    return {
        "advance": _at(time, ahead, t90),
        "transfer": _at(time, across, t90),
        "t90": t90 - execute_s,
        "tactical_diameter": _at(time, across, t180),
        "t180": t180 - execute_s,
        "max_advance": float(np.nanmax(ahead[after])) if math.isfinite(t90) else math.nan,
        "max_transfer": float(np.nanmax(across[after])) if math.isfinite(t180) else math.nan,
        **_steady(record, side),
    }


def _track(record: Record, execute_s: float, side: float) -> tuple[np.ndarray, np.ndarray]:
    """Distances (N,) in m along the approach course from the execute, and off it towards the turn."""
    north, east = record.column("north_m"), record.column("east_m")
    dn, de, course = north - north[0], east - east[0], record.heading_unwrapped()[0]
    ahead = dn * math.cos(course) + de * math.sin(course)
    across = side * (de * math.cos(course) - dn * math.sin(course))
    return ahead - _at(record.time_s, ahead, execute_s), across


def _steady(record: Record, side: float) -> dict[str, float]:
    """Means over the last 5 % of the record."""
    last = slice(max(0, record.n - max(2, math.ceil(STEADY_SHARE * record.n))), None)
    nan = math.nan
    rate = abs(float(np.nanmean(record.column("yaw_rate_rad_s")[last]))) if record.has("yaw_rate_rad_s") else nan
    surge, sway = (record.column(c)[last] if record.has(c) else np.array([nan]) for c in ("surge_m_s", "sway_m_s"))
    speed = float(np.mean(np.hypot(surge, sway)))
    return {
        "steady_radius": speed / rate if rate > 0.0 else nan,
        "steady_speed": speed,
        "steady_yaw_rate": rate,
        "drift_angle": float(np.mean(np.arctan2(-side * sway, surge))),
    }


def _reach(time: np.ndarray, value: np.ndarray, level: float) -> float:
    """First time that ``value`` reaches ``level``, interpolated; nan if never."""
    above = np.flatnonzero(value >= level)
    if above.size == 0 or above[0] == 0:
        return math.nan
    i = int(above[0])
    share = (level - value[i - 1]) / (value[i] - value[i - 1])
    return float(time[i - 1] + share * (time[i] - time[i - 1]))


def _at(time: np.ndarray, value: np.ndarray, when: float) -> float:
    return float(np.interp(when, time, value)) if math.isfinite(when) else math.nan
