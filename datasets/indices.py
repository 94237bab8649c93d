"""Manoeuvring indices of a record: zigzag overshoots, turning-circle distances.

Definitions of IMO MSC.137(76) and MSC/Circ.1053: an overshoot is the extra heading change after counter rudder;
advance is the distance made good along the approach course from the position at execute to a heading change of
90 degrees, transfer and tactical diameter are the distances off the approach course at 90 and 180 degrees. The
approach course is the line through the first sample along its heading (a drift off it before the execute is
part of the transfer). Values between samples are interpolated linearly; distances count towards the side
of the turn.  Initial turning ability is the distance travelled from the execute to a heading change of 10 degrees
under 10 degrees of rudder.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..models.errors import BadInput
from .record import Record
from .signals import integral

OVERSHOOTS = ("first_overshoot", "second_overshoot")
TURNING = ("advance", "transfer", "tactical_diameter")
"""Names of the indices of zigzags, rad, and of turning circles, m."""
PLATEAU = 0.9
MOVED = 0.05
STEADY_SHARE = 0.05
HELD, HELD_SHARE = 0.8, 0.5
"""In zigzags and turns the rudder is beyond the first share of its largest angle for the second share of the time."""
UNEVEN_RAD, UNEVEN = math.radians(5.0), 0.5
"""Largest difference between the heading changes of a zigzag: an angle, or a share of their mean if that is more."""
LEAST_TURN = math.radians(90.0)
"""Heading change from which on a run with the rudder held over is a turn."""
INITIAL_TURN = math.radians(10.0)
PIECES = 4
"""Chords by which the way is measured along which the heading changes that much."""


@dataclass(frozen=True)
class RecordedManoeuvre:
    """The manoeuvre that a record holds: `kind` is 'zigzag', 'turn', or '' with the reason why it is neither.

    rudder_rad : mean size of the held rudder angles;  heading_rad : mean heading change, from the first execute, at
    the counter-rudder orders of a zigzag;  executes : sample numbers of the rudder orders.
    """

    kind: str
    reason: str = ""
    rudder_rad: float = math.nan
    heading_rad: float = math.nan
    executes: tuple[int, ...] = ()

    @property
    def title(self) -> str:
        """`zigzag 20/10`, `turn 35`."""
        angles = [self.rudder_rad, *([self.heading_rad] if self.kind == "zigzag" else [])]
        return f"{self.kind} {'/'.join(f'{math.degrees(angle):.0f}' for angle in angles)}"


def performed(record: Record) -> RecordedManoeuvre:
    """Whether a record holds a zigzag or a turning circle, read from its rudder and heading."""
    if not record.has("heading_rad") or not np.isfinite(record.column("heading_rad")).any():
        return RecordedManoeuvre("", "the record has no heading")
    marks = executes(record).tolist()
    if not marks:
        return RecordedManoeuvre("", "the rudder never moves")
    rudder = _commanded(record)[marks[0] + 1 :]
    sizes = np.abs(rudder[np.isfinite(rudder)])
    held = sizes >= HELD * sizes.max(initial=0.0)
    size = float(sizes[held].mean()) if held.any() else 0.0
    if not held.any() or held.mean() < HELD_SHARE:
        return RecordedManoeuvre("", "the rudder is not held over: neither a zigzag nor a turning circle")
    heading = without_gaps(record.heading_unwrapped())
    if len(marks) == 1:
        change = heading - heading[0]
        if max(change.max(), -change.min()) < LEAST_TURN:
            return RecordedManoeuvre("", "the rudder goes over once and the heading changes by less than 90 deg")
        return RecordedManoeuvre("turn", "", size, executes=tuple(marks))
    change = heading[marks[1:]] - heading[marks[0]]
    swings = np.sign(change)
    even = np.ptp(np.abs(change)) <= max(UNEVEN_RAD, UNEVEN * np.abs(change).mean())
    if not even or (swings[1:] != -swings[:-1]).any() or not swings.all():
        return RecordedManoeuvre("", "the rudder is not put over at equal heading changes to both sides: not a zigzag")
    return RecordedManoeuvre("zigzag", "", size, float(np.abs(change).mean()), tuple(marks))


def without_gaps(values: np.ndarray) -> np.ndarray:
    """Samples (N,) with gaps filled linearly."""
    known = np.flatnonzero(np.isfinite(values))
    return np.interp(np.arange(values.size), known, values[known])


def executes(record: Record) -> np.ndarray:
    """Sample numbers at which the rudder is ordered over, (k,) int; the first is the first execute.

    Read from the rudder command (a step: the first sample of the new order) or else from the rudder angle
    (the last sample before it leaves its plateau). Empty if the rudder never moves.
    """
    commanded, rudder = record.has("rudder_command_rad"), _commanded(record)
    seen = np.flatnonzero(np.isfinite(rudder))
    values = rudder[seen]
    size = np.max(np.abs(values), initial=0.0)
    if size == 0.0:
        return np.empty(0, dtype=np.intp)
    sides = [max(float(np.max(side * values)), HELD * size) for side in (1.0, -1.0)]
    held = np.flatnonzero(np.abs(values) >= PLATEAU * np.where(values > 0.0, *sides))
    turns = np.flatnonzero(np.diff(np.sign(values[held])) != 0)
    still = np.flatnonzero(np.abs(values[: held[0]] - values[0]) <= MOVED * size)
    first = int(still[-1]) if still.size else 0
    moved = bool((np.abs(values - values[0]) > MOVED * size).any())
    marks = [first, *(_summit(np.abs(values), int(i)) for i in held[turns])]
    after = commanded and moved
    return seen[np.minimum(np.array(marks) + after, values.size - 1)].astype(np.intp)


def _commanded(record: Record) -> np.ndarray:
    """Rudder order (N,), rad, or else the angle."""
    return record.column("rudder_command_rad") if record.has("rudder_command_rad") else record.rudder()


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
    return heading_extremes(record.heading_unwrapped(), marks)


def heading_extremes(heading: np.ndarray, marks: Sequence[int]) -> list[tuple[int, int]]:
    """Samples of each counter-rudder order, the second of `marks` and on, and of the extreme of the heading (N,) that
    follows it; an extreme that is not passed is left out."""
    last, found = heading.size - 1, []
    for before, start, end in zip(marks[:-1], marks[1:], [*marks[2:], last], strict=True):
        swing = 1.0 if heading[start] >= heading[before] else -1.0
        at = start + int(np.nanargmax(swing * heading[start : end + 1]))
        if at < last:
            found.append((start, at))
    return found


def initial_turning(record: Record, execute_s: float) -> float:
    """Distance travelled, m, from the execute until the heading has changed by 10 degrees; nan if it does not.

    The track comes from the positions, or else from the speed.  Needs heading_rad, and north_m and east_m or surge_m_s
    and sway_m_s.
    """
    time, change = record.time_s, record.heading_unwrapped() - record.heading_unwrapped()[0]
    after = time >= execute_s
    reached = min(
        (_reach(time[after], side * change[after], INITIAL_TURN) for side in (1.0, -1.0)),
        key=lambda when: when if math.isfinite(when) else math.inf,
    )
    if record.has("north_m", "east_m"):  # in chords: a way from sample to sample grows with the noise of every sample
        times = np.linspace(execute_s, reached, PIECES + 1)
        north, east = ([_at(time, record.column(name), when) for when in times] for name in ("north_m", "east_m"))
        return float(np.sum(np.hypot(np.diff(north), np.diff(east))))
    way = integral(np.hypot(record.column("surge_m_s"), record.column("sway_m_s")), time)
    return _at(time, way, reached) - _at(time, way, execute_s)


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
    north, east, course = record.column("north_m"), record.column("east_m"), record.heading_unwrapped()[0]
    dn, de = north - north[0], east - east[0]
    ahead = dn * math.cos(course) + de * math.sin(course)  # along the approach course, from the execute
    ahead = ahead - _at(time, ahead, execute_s)
    across = side * (de * math.cos(course) - dn * math.sin(course))  # off it towards the turn
    t90, t180 = (_reach(time, side * change, angle) for angle in (0.5 * math.pi, math.pi))
    after = time >= execute_s
    # means over the last 5 % of the record
    last = slice(max(0, record.n - max(2, math.ceil(STEADY_SHARE * record.n))), None)
    nan = math.nan
    rate = abs(float(np.nanmean(record.column("yaw_rate_rad_s")[last]))) if record.has("yaw_rate_rad_s") else nan
    surge, sway = (record.column(c)[last] if record.has(c) else np.array([nan]) for c in ("surge_m_s", "sway_m_s"))
    speed = float(np.mean(np.hypot(surge, sway)))
    return {
        "advance": _at(time, ahead, t90),
        "transfer": _at(time, across, t90),
        "t90": t90 - execute_s,
        "tactical_diameter": _at(time, across, t180),
        "t180": t180 - execute_s,
        "max_advance": float(np.nanmax(ahead[after])) if math.isfinite(t90) else math.nan,
        "max_transfer": float(np.nanmax(across[after])) if math.isfinite(t180) else math.nan,
        **{
            "steady_radius": speed / rate if rate > 0.0 else nan,
            "steady_speed": speed,
            "steady_yaw_rate": rate,
            "drift_angle": float(np.mean(np.arctan2(-side * sway, surge))),
        },
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


# ---- The same of many simulated runs at once.

INITIAL = "initial_turning"
STEADY = {"steady_radius": "m", "steady_speed": "m/s", "steady_yaw_rate": "rad/s"}
INDICES: dict[str, str] = {**dict.fromkeys(OVERSHOOTS, "rad"), **dict.fromkeys((*TURNING, INITIAL), "m"), **STEADY}
"""Name -> unit."""


def indices(names: Sequence[str], time_s: np.ndarray, channels: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Index name -> (W,) of noise-free runs with channels (W, N+1) at times (N+1,); nan where not reached."""
    found: dict[str, np.ndarray] = {}
    if set(names) & set(OVERSHOOTS):
        angles = overshoots_of_many(channels["rudder_command_rad"], channels["heading_rad"], len(OVERSHOOTS))
        found = dict(zip(OVERSHOOTS, angles, strict=True))
    others = [name for name in names if name not in OVERSHOOTS]
    found |= {name: np.full(len(channels["rudder_rad"]), np.nan) for name in others}
    moved = np.flatnonzero(np.abs(channels["rudder_rad"]).max(axis=1) > 0.0).tolist() if others else []
    for i in moved:  # found run by run, of turning circles and initial turning
        run = {name: values[i] for name, values in channels.items()}
        if np.isfinite(run["heading_rad"]).all():
            record = Record(time_s, run)
            own = turning_indices(record) if set(others) - {INITIAL} else {}
            if INITIAL in others:
                own[INITIAL] = initial_turning(record, float(execute_times(record)[0]))
            for name in others:
                found[name][i] = own[name]
    return {name: found[name] for name in names}


def overshoots_of_many(order: np.ndarray, heading: np.ndarray, count: int) -> np.ndarray:
    """The first overshoot angles (count, W) of zigzags whose orders and headings are (W, N+1), rad.

    nan where the record ends before the heading turns.
    """
    side = np.sign(order)
    reversals = np.cumsum(side[:, 1:] * side[:, :-1] < 0.0, axis=1)
    out, rows, last = np.full((count, len(order)), np.nan), np.arange(len(order)), order.shape[1] - 1
    for number in range(1, count + 1):
        reversed_at = (reversals == number).argmax(axis=1) + 1
        within = np.zeros(order.shape, dtype=bool)
        within[:, 1:] = reversals == number
        base = heading[rows, reversed_at]
        swing = np.where(base >= heading[:, 0], 1.0, -1.0)
        beyond = np.where(within, swing[:, None] * (heading - base[:, None]), -np.inf)
        at = beyond.argmax(axis=1)
        passed = (reversals[:, -1] >= number) & (at < last)
        out[number - 1] = np.where(passed, beyond[rows, at], np.nan)
    return out
