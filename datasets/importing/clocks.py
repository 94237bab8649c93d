"""Clocks of several loggers set to one: by what the files state, by channels in common, or by the ship's motion."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from ...models.linear_algebra import lstsq
from ..geometry import on_plane, unwrapped
from ..signals import integral, lagged
from ..yaw_response import yaw_response
from .convert import Stream
from .draft import Answer, Question
from .evidence import correlation
from .moments import EPOCH_S, WEEK_S, leap_seconds
from .result import FileFault
from .times import clock_question

ZONE_STEP_S, LONGEST_ZONE_S = 900.0, 14.0 * 3600.0
"""Steps of the zones of the world, and the largest of them."""
MISSED_S, SURE_S = 5.0, 20.0
"""Seconds by which the motion may miss a zone, and within which an offset that is none must be known."""
SAME_STEPS = 2.0
"""Steps within which two tables begin and end together that one program wrote."""
STARTS_S = 60.0
"""Seconds below which a first time says that the clock was started with the log."""


@dataclass(frozen=True)
class Setting:
    """Seconds to add to a clock, what to say of it, and whether it is in doubt; `rate`, `middle`: as of an `Offset`."""

    seconds: float
    told: str = ""
    doubt: bool = False
    rate: float = 0.0
    middle: float = 0.0

    def of(self, stream: Stream, dated: bool) -> Stream:
        """A stream on the clock that was set."""
        set_ = replace(stream, shift_s=self.seconds, rate=self.rate, middle_s=self.middle, dated=dated)
        return replace(set_, time=set_.on_clock(stream.time))


def on_dates(streams: Sequence[Stream]) -> list[Stream]:
    """The streams; those that count from a midnight or a GPS week put on the day or week in which they have most in
    common with one with a date, in UTC where they state GPS time."""
    other = min((s for s in streams if s.dated), key=lambda stream: not stream.zoned, default=None)
    out = []
    for stream in streams:
        if other is not None and stream.period_s and not stream.dated:
            ahead = float(leap_seconds(other.time[0])) if stream.gps else 0.0
            origin = (EPOCH_S if stream.period_s == WEEK_S else 0.0) - ahead
            middle = (other.time[0] + other.time[-1]) / 2.0 - (stream.time[0] + stream.time[-1]) / 2.0
            time = stream.time + origin + round((middle - origin) / stream.period_s) * stream.period_s
            what = "week" if stream.period_s == WEEK_S else "day"
            gps = f", {ahead:g} s of GPS time taken off" if ahead else ""
            done = (*stream.done, f"{stream.label}: put on the {what} of {other.label}{gps}")
            stream = replace(stream, time=time, dated=True, zoned=stream.zoned or stream.gps, done=done)
        out.append(stream)
    return out


def align(streams: Sequence[Stream]) -> tuple[list[Stream], list[str], list[FileFault], list[Question]]:
    """The streams on one clock, that which states UTC or else of the rudder; what was done, doubts, and questions for
    clocks that nothing tells."""
    clocks: dict[str, list[Stream]] = {}
    for stream in streams:
        clocks.setdefault(stream.clock, []).append(stream)

    def rank(name: str) -> tuple[bool, ...]:
        own = clocks[name]
        of_rudder = any("rudder" in stream.quantities for stream in own)
        return any(stream.zoned for stream in own), any(stream.dated for stream in own), of_rudder

    base = max(clocks, key=rank)
    out, done, faults = list(clocks[base]), [], []
    waiting = [own for name, own in clocks.items() if name != base]
    while waiting:
        tried = [(own, setting) for own in waiting if (setting := _setting(out, own)) is not None]
        if not tried:
            break
        own, setting = min(tried, key=lambda entry: entry[1].doubt)
        out += [setting.of(stream, out[0].dated) for stream in own]
        waiting.remove(own)
        if setting.doubt:
            hint = "give clock_offset_s of this table in the map if it is wrong"
            faults.append(FileFault(own[0].label, setting.told, hint))
        elif setting.told:
            done.append(f"{own[0].label}: {setting.told}")
    return out, done, faults, [_question(out, own) for own in waiting]


def _setting(base: Sequence[Stream], own: Sequence[Stream]) -> Setting | None:
    """What sets the clock of `own` to that of `base`; None where nothing tells it."""
    given = [stream.offset_s for stream in own if stream.offset_s is not None]
    # what the map adds to the clock of the base is taken off the others, where it says nothing of them
    given += [-stream.offset_s for stream in base if stream.offset_s is not None]
    if given:
        return Setting(given[0], f"clock set {given[0]:+g} s as the mapping says")
    shared = estimate_offset(base, own)
    if shared is not None:
        told = f"{shared.seconds:+.3f} s (standard error {shared.stderr:.2g} s, correlation {shared.correlation:.4f})"
        said = f"clock set {told} to that of {base[0].label}, told by {shared.quantity}"
        if not shared.rate:
            return Setting(shared.seconds, said)
        ends = shared.seconds + shared.rate * (own[0].time[[0, -1]] - shared.middle)
        said += f"; it goes {'slow' if shared.rate > 0.0 else 'fast'} by {abs(100.0 * shared.rate):.2g} %: "
        said += f"{ends[0]:+.2f} s at its start, {ends[1]:+.2f} s at its end"
        return Setting(shared.seconds, said, False, shared.rate, shared.middle)
    if all(stream.dated for stream in (*base, *own)):
        return _dated(base, own)
    # without a date: by the motion, or as it is where both count from one moment
    label, lag = base[0].label, offset_by_motion(base, own, None)
    if lag is not None and lag.sharp:
        return _by_motion(label, lag)
    alike = not any(stream.dated for stream in (*base, *own)) and base[0].period_s == own[0].period_s
    starts = min(base[0].time[0], own[0].time[0])
    late = starts > STARTS_S and _overlap(base, own)
    # two tables that begin and end together, and not at zero, where every clock may begin
    step = max(s.step if s.time.size > 1 else 0.0 for s in (base[0], own[0]))
    apart = np.abs(base[0].time[[0, -1]] - own[0].time[[0, -1]])
    together = bool(np.all(apart <= SAME_STEPS * step)) and starts > SAME_STEPS * step
    if alike and (late or together):
        said = f"clock taken as that of {label}, whose times have the same size: nothing else tells it"
        return Setting(0.0, said, True)
    return None


def _dated(base: Sequence[Stream], own: Sequence[Stream]) -> Setting | None:
    """The setting of a clock with a date: as it is where both state UTC, or by the zone that the motion tells."""
    label, stated = base[0].label, [all(stream.zoned for stream in streams) for streams in (base, own)]
    lag = None
    for zone in _common_zones(base, own):  # the motion tells it near to the zones with enough in common
        found = offset_by_motion(base, [replace(stream, time=stream.time + zone) for stream in own], NEAR_S)
        if found is not None:
            lag = replace(found, seconds=found.seconds + zone, low=found.low + zone, high=found.high + zone)
            break
    if all(stated):  # no setting, but for GPS time that may be named so
        ahead, vague = float(leap_seconds(base[0].time[0])), any(stream.vague for stream in (*base, *own))
        told = lag if lag is not None and lag.sharp and abs(lag.seconds) > MISSED_S and not lag.holds(0.0) else None
        leap = [seconds for seconds in (-ahead, ahead) if told and told.holds(seconds)]
        if vague and leap and told:
            said = f"its clock or that of {label} is named GPS time and shows UTC: {told.told} so"
            return Setting(leap[0], f"clock set {leap[0]:+g} s: {said}", True)
        if told:
            said = f"{told.told} best with its clock {told.seconds:+.1f} s, but both tables state their offset from UTC"
            return Setting(0.0, f"{said}: left as it is", True)
        if vague and lag is None:
            said = f"GPS time is taken as such, {ahead:g} s ahead of UTC: nothing tells whether it is UTC"
            return Setting(0.0, said, True)
        return Setting(0.0, f"clock taken as that of {label}, both state their offset from UTC")
    zones = _zones(base, own)
    able = [] if lag is None else [zone for zone in zones if lag.holds(zone)]
    if lag is not None and len(able) == 1 and abs(able[0] - lag.seconds) <= MISSED_S:
        told = f"clock {f'set {able[0]:+g} s to' if able[0] else 'taken as'} that of {label}: {lag.told} so"
        return Setting(able[0], told, able[0] != 0.0)
    if lag is not None and lag.sharp and not any(abs(zone - lag.seconds) <= MISSED_S for zone in zones):
        return _by_motion(label, lag) if lag.high - lag.low <= SURE_S else None
    if not any(stated) and (lag is None or lag.holds(0.0)):
        return Setting(0.0, f"clock taken as that of {label} (no channel that both hold tells more)")
    return None


def _by_motion(label: str, lag: Lag) -> Setting:
    sure = max(lag.high - lag.seconds, lag.seconds - lag.low)
    told = f"clock set {lag.seconds:+.1f} s, to some {max(1.0, math.ceil(sure)):g} s, to that of {label}: {lag.told} so"
    return Setting(lag.seconds, told, True)


def _overlap(base: Sequence[Stream], own: Sequence[Stream]) -> bool:
    """Whether two clocks show times of which enough are the same."""
    ends = [(min(s.time[0] for s in streams), max(s.time[-1] for s in streams)) for streams in (base, own)]
    (first, last), (start, stop) = ends
    return min(last, stop) - max(first, start) > OVERLAP * min(last - first, stop - start)


def _common_zones(base: Sequence[Stream], own: Sequence[Stream]) -> list[float]:
    """Seconds of the zones with which two clocks with a date have enough in common: 0, or else those with the most."""
    if _overlap(base, own):
        return [0.0]
    middle = np.mean([base[0].time[0], base[0].time[-1]]) - np.mean([own[0].time[0], own[0].time[-1]])
    near = ZONE_STEP_S * round(float(middle) / ZONE_STEP_S)
    zones = [near + k * ZONE_STEP_S for k in (0, -1, 1, -2, 2)]
    moved = {zone: [replace(stream, time=stream.time + zone) for stream in own] for zone in zones}
    return [zone for zone in zones if 0.0 < abs(zone) <= LONGEST_ZONE_S and _overlap(base, moved[zone])]


def _zones(base: Sequence[Stream], own: Sequence[Stream]) -> list[float]:
    """Seconds by which a clock with a date may be off: zones, and GPS time where it or the other states none."""
    ahead = float(leap_seconds(base[0].time[0]))
    zones = _common_zones(base, own)
    return [zone + more for more in (0.0, -ahead, ahead) for zone in zones]


def _meaning(seconds: float, base: Sequence[Stream]) -> str:
    """What it means that seconds are to be added to a clock with a date."""
    ahead = float(leap_seconds(base[0].time[0]))
    zone = ZONE_STEP_S * round(seconds / ZONE_STEP_S)
    rest = {0.0: "", -ahead: f"{ahead:g} s ahead, as GPS time is of UTC",
            ahead: f"{ahead:g} s behind, as UTC is of GPS time"}[seconds - zone]  # fmt: skip
    hours = f"its zone is {abs(zone) / 3600.0:g} h {'behind' if zone > 0.0 else 'ahead'}" if zone else ""
    return ", ".join(part for part in (hours, rest) if part) or "none: both show the same time"


def _question(base: Sequence[Stream], own: Sequence[Stream]) -> Question:
    """The question for the offset of a clock that nothing tells."""
    label, reference = own[0].label, base[0].label
    dated = all(stream.dated for stream in (*base, *own))
    if dated:
        texts = {zone: _meaning(zone, base) for zone in _zones(base, own) or [0.0]}
    else:
        texts = {float(f"{base[0].time[0] - own[0].time[0]:.12g}"): "that by which both tables begin together"}
        if base[0].dated == own[0].dated:
            texts |= {0.0: "none: both count from the same moment"}
    why = "One of them states no offset from UTC" if dated else "No date"
    said = f"{why}, no channel is in common, and the motion does not tell it."
    text = f"By how much is the clock of {label} off that of {reference}? {said}"
    made = tuple(Answer(f"{seconds:.12g}", said, f"clock_offset_s: {seconds:.12g}") for seconds, said in texts.items())
    number = "seconds to add to its times: clock_offset_s: NUMBER"
    table = own[0].table
    return Question(clock_question(table), "time", table, own[0].time_column, text, made, number)


# ---- Offsets between the clocks of loggers: by channels that both have, or by what the ship's motion makes of a
# channel.
# A ship drifts outward in a turn, later than it turns: course(t) = heading(t) - a q(t) - b q_T(t) + const., a, b >= 0,
# with q the yaw rate over the speed, and q_T the same through a first-order lag T; that is sway over yaw of the linear
# equations of manoeuvring (Nomoto et al. 1957, Int. Shipb. Progr. 4), whose sway velocity is drift angle times speed.
# The yaw rate answers the rudder (`yaw_response`).  The offset is the one that leaves the least of course and yaw rate.

Curve: TypeAlias = tuple[np.ndarray, np.ndarray]
"""Times (N,), s, and values (N,)."""
NEAR_S = 120.0
"""Offset that is searched between clocks that both show the date."""
AGREEING = 0.9
"""Correlation from which on two clocks are compared."""
LIKELY, ALIKE, PEAKS = 0.5, 0.05, 20
"""Correlation of the changes from which a lag is tried, difference to the largest one up to which it is, and lags that
are tried at most."""
MOST_RATE, SURE_RATE = 0.05, 6.0
"""Largest rate of a clock, and standard errors from which on it is one."""
MOST_LAGS, FEWEST, OVERLAP = 1500, 30, 0.4
"""Lags that are tried, samples in common, and the share of the shorter log that must overlap."""


@dataclass(frozen=True)
class Offset:
    """Seconds to add to the times of the second clock, standard error, correlation, and the quantity compared.

    rate : by how much a second of the second clock is shorter than one of the first, where its offset changes: seconds
    are added at `middle`, s, of the second clock, and rate (t - middle) more at its time t.
    """

    seconds: float
    stderr: float
    correlation: float
    quantity: str
    rate: float = 0.0
    middle: float = 0.0


def estimate_offset(first: Sequence[Stream], second: Sequence[Stream]) -> Offset | None:
    """The offset between two clocks with streams that share a quantity; None where nothing is shared or it disagrees.

    The second series is moved against the first: from the lags of the largest correlations of the changes by least
    squares of first(t) = second(t - offset) + a + b t, of which the best fit counts.
    """
    own, other = _series(first), _series(second)
    shared = [name for name in ("turn", "speed", "north", "east", "rudder", "roll") if name in own and name in other]
    dated = all(stream.dated for stream in (*first, *second))
    found = [_between(own[name], other[name], dated, name) for name in shared]
    sure = [offset for offset in found if offset is not None and offset.correlation >= AGREEING]
    return min(sure, key=lambda offset: offset.stderr) if sure else None


def _series(streams: Sequence[Stream]) -> dict[str, Curve]:
    """What can be compared, by name; turning is compared as heading."""
    out: dict[str, Curve] = {}
    for stream in streams:
        q = stream.quantities
        if (turn := turning(stream)) is not None:
            out.setdefault("turn", turn)
        for name in ("north", "east", "roll", "rudder"):
            if name in q:
                out.setdefault(name, known(stream.time, q[name]))
        if "speed_over_ground" in q:
            out.setdefault("speed", known(stream.time, q["speed_over_ground"]))
        elif "surge" in q and "sway" in q:
            out.setdefault("speed", known(stream.time, np.hypot(q["surge"], q["sway"])))
    return {name: pair for name, pair in out.items() if pair[0].size >= FEWEST}


def turning(stream: Stream) -> Curve | None:
    """The heading of a stream without jumps, by its sensor or the integral of the yaw rate; None without any."""
    q = stream.quantities
    heading = q.get("heading", q.get("heading_magnetic"))
    if heading is not None:
        return known(stream.time, unwrapped(heading))
    if "yaw_rate" not in q:
        return None
    time, rate = known(stream.time, q["yaw_rate"])
    return time, integral(rate, time)


def known(time: np.ndarray, values: np.ndarray) -> Curve:
    """The times and values (K,) of those (N,) that are known."""
    sound = np.isfinite(values) & np.isfinite(time)
    return time[sound], values[sound]


def _between(first: Curve, second: Curve, dated: bool, name: str) -> Offset | None:
    (t1, x1), (t2, x2) = first, second
    step = max(float(np.median(np.diff(t1))), float(np.median(np.diff(t2))))
    shortest = min(t1[-1] - t1[0], t2[-1] - t2[0])
    overlap = min(t1[-1], t2[-1]) - max(t1[0], t2[0])
    if dated and overlap > OVERLAP * shortest:
        low, high = -NEAR_S, NEAR_S
    else:
        keep = OVERLAP * shortest
        low, high = t1[0] + keep - t2[-1], t1[-1] - keep - t2[0]
    count = int(min(MOST_LAGS, max(3, math.ceil((high - low) / step))))
    lags = np.linspace(low, high, count)
    grid_step = max(step, shortest / 2000.0)
    scores = np.array([_correlation(t1, x1, t2 + lag, x2, grid_step, OVERLAP * shortest) for lag in lags])
    # local maxima nearly as large as the largest: with a clock that goes slow one manoeuvre is like those before it
    around = np.concatenate([[-np.inf], scores, [-np.inf]])
    tops = np.flatnonzero((scores >= around[:-2]) & (scores > around[2:]) & (scores > scores.max() - ALIKE))
    highest = sorted(tops.tolist(), key=lambda i: -scores[i])[:PEAKS]
    peaks = [float(lags[i]) for i in highest if scores[i] >= LIKELY]
    refined = (_refined(t1, x1, t2, x2, lag, grid_step, name) for lag in peaks)
    return max((offset for offset in refined if offset is not None), key=lambda o: o.correlation, default=None)


def _common(t1: np.ndarray, t2: np.ndarray, step: float) -> np.ndarray:
    return np.arange(max(t1[0], t2[0]), min(t1[-1], t2[-1]), step)


def _correlation(t1: np.ndarray, x1: np.ndarray, t2: np.ndarray, x2: np.ndarray, step: float, least: float) -> float:
    """Correlation of the changes of two series where they overlap; -1 where they overlap too little."""
    grid = _common(t1, t2, step)
    if grid.size < FEWEST or grid[-1] - grid[0] < least:
        return -1.0
    width = max(1, grid.size // 100)
    a, b = np.interp(grid, t1, x1), np.interp(grid, t2, x2)
    return correlation(a[width:] - a[:-width], b[width:] - b[:-width])


def _refined(t1, x1, t2, x2, lag: float, step: float, name: str) -> Offset | None:
    """The offset by least squares from a first lag, with a rate where the offset surely changes."""
    still = _fitted(t1, x1, t2, x2, Offset(lag, math.inf, 0.0, name, 0.0, (t2[0] + t2[-1]) / 2.0), step, 1)
    if still is None:
        return None
    moving = _fitted(t1, x1, t2, x2, still[0], step, 2)
    if moving is None:
        return still[0]
    rate, error = moving[0].rate, moving[1]
    changes = abs(rate) * (t2[-1] - t2[0]) > 2.0 * step
    return moving[0] if changes and SURE_RATE * error < abs(rate) < MOST_RATE else still[0]


def _fitted(t1, x1, t2, x2, start: Offset, step: float, count: int) -> tuple[Offset, float] | None:
    """(offset, standard error of its rate) by Gauss-Newton steps on the offset (count 1) and the rate (2), with a
    constant and a trend beside them; None where too little is in common."""
    at, error = start, math.inf
    for _ in range(12):
        moved = t2 + at.seconds + at.rate * (t2 - at.middle)
        grid = _common(t1, moved, step)
        if grid.size < FEWEST:
            return None
        a, b = np.interp(grid, t1, x1), np.interp(grid, moved, x2)
        slope = np.gradient(b, grid)
        own = np.column_stack([slope, slope * (grid - at.seconds - at.middle)])[:, :count]
        columns = np.column_stack([-own, np.ones(grid.size), grid - grid[0]])
        solution = lstsq(columns, a - b)
        rest = a - b - columns @ solution
        line = columns[:, count:] @ lstsq(columns[:, count:], a)
        fit = math.sqrt(max(0.0, 1.0 - float(rest @ rest) / max(float(np.sum((a - line) ** 2)), 1e-300)))
        more = float(np.clip(solution[0], -5.0 * step, 5.0 * step))
        faster = float(np.clip(solution[1], -0.01, 0.01)) if count > 1 else 0.0
        error = _stderr(rest, own[:, 1]) if count > 1 else math.inf
        at = Offset(at.seconds + more, _stderr(rest, slope), fit, at.quantity, at.rate + faster, at.middle)
        if abs(more) < 1e-4 * step and abs(faster) * (t2[-1] - t2[0]) < 1e-4 * step:
            break
    return at, error


def _stderr(rest: np.ndarray, slope: np.ndarray) -> float:
    """Standard error of the offset, residuals being correlated from sample to sample."""
    power = float(np.sum((slope - slope.mean()) ** 2))
    variance = float(np.mean(rest**2))
    r = float(np.sum(rest[1:] * rest[:-1]) / max(float(np.sum(rest**2)), 1e-300))
    inflation = (1.0 + r) / max(1.0 - r, 1e-3)
    return math.sqrt(variance * max(inflation, 1.0) / power) if power > 0.0 else math.inf


# ---- By the motion.

Left: TypeAlias = Callable[[Curve, Curve, float], float]
"""Share of a series that another one leaves whose clock has an offset; nan where they have too little in common."""
POINTS, FINE = 300, 0.25
"""Times at which series are compared, and steps of the last search in those of the slower one."""
FEW, MANY, LEAST_SAMPLES = 121, 401, 40
"""Offsets that are tried near 0 and anywhere, and fewest samples."""
COURSE_LEFT, YAW_LEFT, AS_GOOD = 0.02, 0.12, 2.0
"""Shares of course and yaw rate that may be left, and times the least that is as good as it."""
MOST_BY_RUDDER_S = 30.0
"""Largest offset that the rudder tells: zigzags repeat themselves."""
LAGS_S = (0.0, 0.7, 1.0, 1.5, 2.2, 3.3, 5.0, 7.5, 11.0, 17.0, 25.0, 38.0, 57.0)
"""Time constants that are tried for the drift."""
LEAST_TURN_RAD = 0.2
LEAST_SPEED = 0.2
"""Share of the usual speed below which a ship has no course that tells anything."""
NEARLY_S = 1.0
"""Seconds by which an offset may miss the range of those that explain nearly as much."""
SMOOTHED_S = 4.0
"""Seconds over which the course of positions is taken."""


@dataclass(frozen=True)
class Lag:
    """Seconds to add to the second clock, the range of those that explain nearly as much, what tells it, and whether it
    is known to a second or so: what the rudder tells is not."""

    seconds: float
    low: float
    high: float
    told: str
    sharp: bool

    def holds(self, seconds: float) -> bool:
        """Whether another offset explains nearly as much."""
        return self.low - NEARLY_S <= seconds <= self.high + NEARLY_S


def offset_by_motion(first: Sequence[Stream], second: Sequence[Stream], near_s: float | None) -> Lag | None:
    """The offset of the second clock from the first; None where nothing tells it, or no offset stands out.

    near_s : largest offset that is looked for; None: any that leaves enough in common.
    """
    (course, drifts, heading, rudder), (other_course, other_drifts, other_heading, other_rudder) = (
        _angles(streams) for streams in (first, second)
    )
    by_course, by_rudder = "the course over ground drifts as the heading turns", "the yaw follows the rudder"
    near_rudder = min(near_s or 0.0, MOST_BY_RUDDER_S)
    tried = (
        (course, other_heading, 1.0, drifts, COURSE_LEFT, near_s, by_course),
        (other_course, heading, -1.0, other_drifts, COURSE_LEFT, near_s, by_course),
        (heading or course, other_rudder, 1.0, _by_rudder, YAW_LEFT, near_rudder, by_rudder),
        (other_heading or other_course, rudder, -1.0, _by_rudder, YAW_LEFT, near_rudder, by_rudder),
    )
    for led, leader, sign, left, most, near, told in tried:
        if led is None or leader is None or not np.ptp(led[1]) > LEAST_TURN_RAD:
            continue
        found = _searched(led, leader, left, most, near)
        if found is not None:
            low, high = sorted((sign * found[1], sign * found[2]))
            return Lag(sign * found[0], low, high, told, told == by_course)
    return None


def _angles(streams: Sequence[Stream]) -> tuple[Curve | None, Left, Curve | None, Curve | None]:
    """(course, what heading and drift leave of it, heading, rudder), rad, of a logger, as far as it has them."""
    course, speed, window_s = next((made for s in streams if (made := _course(s))[0] is not None), (None, None, 0.0))
    heading, rudder = (
        next((c for s in streams if (c := made(s)) is not None and c[0].size >= LEAST_SAMPLES), None)
        for made in (turning, _rudder)
    )
    return course, _by_course(window_s, speed), heading, rudder


def _known(time: np.ndarray, values: np.ndarray) -> Curve | None:
    curve = known(time, values)
    return curve if curve[0].size >= LEAST_SAMPLES else None


def _rudder(stream: Stream) -> Curve | None:
    values = stream.quantities.get("rudder", stream.quantities.get("rudder_command"))
    return None if values is None else known(stream.time, values)


def _course(stream: Stream) -> tuple[Curve | None, Curve | None, float]:
    """(the course over ground without jumps, the speed where it is known, the time, s, over which both are means): of
    positions, of velocities, or logged."""
    q = stream.quantities
    if "course_over_ground" in q:
        speed = _known(stream.time, q["speed_over_ground"]) if "speed_over_ground" in q else None
        return _known(stream.time, unwrapped(q["course_over_ground"])), speed, 0.0
    if "velocity_north" in q and "velocity_east" in q:
        return *_of_velocity(stream.time, q["velocity_north"], q["velocity_east"]), 0.0
    if "latitude" in q and "longitude" in q and np.isfinite(q["latitude"] + q["longitude"]).sum() >= LEAST_SAMPLES:
        north, east, _ = on_plane(q["latitude"], q["longitude"])
    elif "north" in q and "east" in q:
        north, east = q["north"], q["east"]
    else:
        return None, None, 0.0
    known = np.isfinite(north) & np.isfinite(east)
    time, north, east = stream.time[known], north[known], east[known]
    if time.size < LEAST_SAMPLES:
        return None, None, 0.0
    step = float(np.median(np.diff(time)))
    width = max(1, round(SMOOTHED_S / step))
    middle = (time[width:] + time[:-width]) / 2.0
    return *_of_velocity(middle, north[width:] - north[:-width], east[width:] - east[:-width]), width * step


def _of_velocity(time: np.ndarray, north: np.ndarray, east: np.ndarray) -> tuple[Curve | None, Curve | None]:
    """(course, speed) where the ship moves."""
    speed = np.hypot(north, east)
    with np.errstate(invalid="ignore"):
        moving = speed > LEAST_SPEED * np.nanquantile(speed, 0.9) if np.isfinite(speed).any() else speed > 0.0
    course = np.where(moving, np.arctan2(east, north), np.nan)
    return _known(time, unwrapped(course)), _known(time, np.where(moving, speed, np.nan))


def _searched(
    led: Curve, leader: Curve, left: Left, most: float, near_s: float | None
) -> tuple[float, float, float] | None:
    """(offset of the leader's clock, low, high) that leaves the least of the series that is led, not over `most`."""
    # offsets that are looked for: those with enough in common, and not larger than `near_s`
    keep = OVERLAP * min(np.ptp(led[0]), np.ptp(leader[0]))
    low, high = led[0][0] + keep - leader[0][-1], led[0][-1] - keep - leader[0][0]
    low, high = (low, high) if near_s is None else (max(low, -near_s), min(high, near_s))
    if not high > low:
        return None
    step = max(float(np.median(np.diff(led[0]))), float(np.median(np.diff(leader[0]))))
    count = FEW if near_s is not None else MANY
    offsets = np.linspace(low, high, count)
    rest = np.array([left(led, leader, offset) for offset in offsets])
    if not np.isfinite(rest).any():
        return None
    best, width = float(offsets[np.nanargmin(rest)]), offsets[1] - offsets[0]
    close = np.linspace(best - width, best + width, int(min(count, 3 + math.ceil(2.0 * width / (FINE * step)))))
    nearby = np.array([left(led, leader, offset) for offset in close])
    if not np.nanmin(nearby) <= most:
        return None
    alike = np.concatenate([close, offsets])[np.concatenate([nearby, rest]) <= AS_GOOD * np.nanmin(nearby)]
    if alike.min() <= low or alike.max() >= high:
        return None
    return float(close[np.nanargmin(nearby)]), float(alike.min()), float(alike.max())


def _shared(led: Curve, leader: Curve, offset: float) -> tuple[np.ndarray, np.ndarray] | None:
    """(times of the first clock that both cover, the led series there)."""
    start, stop = max(led[0][0], leader[0][0] + offset), min(led[0][-1], leader[0][-1] + offset)
    if not stop > start:
        return None
    time = np.linspace(start, stop, POINTS)
    return time, np.interp(time, *led)


def _by_course(window_s: float, speed: Curve | None) -> Left:
    """A function for the share of a course, a mean over a time, that heading and drift leave."""

    def left(course: Curve, heading: Curve, offset: float) -> float:
        from scipy.ndimage import uniform_filter1d
        from scipy.optimize import nnls

        shared = _shared(course, heading, offset)
        if shared is None:
            return math.nan
        time, led = shared
        power = float(np.sum((led - led.mean()) ** 2))
        if not power > 0.0:
            return math.nan
        step = float(time[1] - time[0])
        psi = uniform_filter1d(np.interp(time - offset, *heading), max(1, round(window_s / step)), mode="nearest")
        rate, drift, one = np.gradient(psi, time), led - psi, np.ones(time.size)
        if speed is not None and (own := np.interp(time, *speed)).mean() > 0.0:
            rate = rate * own.mean() / np.maximum(own, LEAST_SPEED * own.mean())
        columns = (np.column_stack([-rate, -lagged(rate, lag, step), one, -one]) for lag in LAGS_S)
        return min(nnls(each, drift)[1] for each in columns) ** 2 / power

    return left


def _by_rudder(turn: Curve, rudder: Curve, offset: float) -> float:
    """The share of the yaw rate that its response to the rudder leaves, without a lag of its own."""
    shared = _shared(turn, rudder, offset)
    if shared is None:
        return math.nan
    time, psi = shared
    told = yaw_response(time, np.gradient(psi, time), np.interp(time - offset, *rudder), lags=(0,))
    return 1.0 - told.share if told is not None else math.nan
