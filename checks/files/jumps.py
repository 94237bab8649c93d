"""Check of jumps of heading and position beyond what yaw rate and speed allow: spliced records."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...datasets.columns import HEADING, POSITIONS, TRACK, TURN, VELOCITIES
from ...datasets.geometry import over_ground, position_over_ground, velocity_over_ground
from ...datasets.signals import bridged, integral
from ...datasets.spikes import without_spikes_in_time
from ..base import Fault, FileCheck, exact
from ..comparison.blocks import LONGEST_GAP
from ..integrity.runs import never_changes

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
    out = []
    if record.has(*TURN) and not never_changes(record.column(TURN[1])):
        out += _jumps(record, HEADING, record.column(TURN[1]))
    if record.has("surge_m_s", *POSITIONS) and not never_changes(record.column("surge_m_s")):
        sway = record.column("sway_m_s") if record.has("sway_m_s") else 0.0
        speed = np.nan_to_num(np.hypot(record.column("surge_m_s"), sway))
        headed = record.has(HEADING, "sway_m_s")
        velocity = velocity_over_ground(record) if headed else np.zeros(record.n, complex)
        for name, rate in zip(POSITIONS, (velocity.real, velocity.imag), strict=True):
            out += _jumps(record, name, rate, speed)
    return out


def _jumps(record: Record, name: str, rate: np.ndarray, most: np.ndarray | None = None) -> list[Jump]:
    """Jumps of a column that changes at a rate (N,), by no more than speeds (N,) allow (None: than the rate)."""
    time = record.time_s
    values, rate = (without_spikes_in_time(x, time)[0] for x in (record.continuous(name), rate))
    known = np.flatnonzero(np.isfinite(values) & np.isfinite(rate))
    if known.size < 4 * SIDE:
        return []
    x, r, t = values[known], rate[known], time[known]
    span = np.diff(t)
    by_rate = 0.5 * (r[1:] + r[:-1]) * span
    top = np.abs(r) if most is None else most[known]
    fastest = float(np.percentile(top, 99))
    error = np.diff(x) - by_rate
    usual = 1.4826 * float(np.median(np.abs(error - np.median(error))))
    seen = np.diff(np.cumsum(np.isfinite(values))[known]) > SIDE  # a gap of the rate alone says nothing of the change
    allowed = np.where(seen, np.inf, np.maximum(LIMIT * usual, 2.0 * fastest * span))
    out = []
    for k in np.flatnonzero((np.abs(error) > allowed) & (np.abs(np.diff(x)) > allowed)) + 1:
        if abs(error[k - 1]) < COARSE * _resolution(x, int(k)):
            continue
        a, b = max(k - SIDE, 0), min(k + SIDE, x.size)
        path = np.concatenate([[0.0], np.cumsum(error[a : b - 1])])
        shift = float(np.median(path[k - a :]) - np.median(path[: k - a]))
        if min(k, x.size - k) >= SIDE and abs(shift) > 0.5 * abs(error[k - 1]):
            out.append(Jump(int(known[k]), name, float(x[k] - x[k - 1]), float(allowed[k - 1]), float(error[k - 1])))
    return out


def _resolution(x: np.ndarray, k: int) -> float:
    """Usual step of a coarse channel beside sample k, the larger of both sides; 0 where it changes in most samples."""
    usual = [0.0]
    for side in (np.diff(x[max(k - NEIGHBOURS, 0) : k]), np.diff(x[k : k + NEIGHBOURS])):
        steps = np.abs(side)
        if steps.size and np.mean(steps < TINY) > 0.3 and np.any(steps > TINY):
            usual.append(float(np.median(steps[steps > TINY])))
    return max(usual)


JOINED = 0.17
"""Jump of the heading, rad, from which it is no sensor that catches up, but two runs in one; a smaller one is where a
position jumps far in the same row."""
LATE_S = 5.0
"""Seconds of way from which a position jumps far: compass and position of one receiver that was late catch up together,
by less than 2 s of way (Esso Osaka, 10 Hz); the halves of a measured run lie more than 10 s apart."""
RESET = 0.05
"""Jump of the heading, rad, from which it is taken out where it stays: what rate and heading disagree by around a
smaller one does not tell whether it stays."""
NEAR, FAR = 10, 60
"""Samples before and after a jump between which heading and rate are compared."""
STAYS = 0.5
"""Share of a jump that must be left there of it."""
UNITS = {HEADING: ("rad", "deg", float(np.rad2deg(1.0))), "north_m": ("m", "m", 1.0), "east_m": ("m", "m", 1.0)}
"""Column -> its unit, and the unit in which its jumps are told with its factor."""


class Splice(FileCheck):
    """A jump of heading or position beyond what yaw rate and speed allow: pieces joined, or a sensor that was reset."""

    id, rank, unit = "splice", 60, "m, rad"
    separate_by = "the original files, piece by piece"

    def find(self, record: Record) -> list[Fault]:
        faults, time, every = [], record.time_s, jumps(record)
        moved = [j for j in every if j.channel != HEADING]
        way = LATE_S * _usual_speed(record) if moved else 0.0
        far = {j.k for j in moved if abs(j.error) > way}
        for name in UNITS:
            own = [j for j in every if j.channel == name]
            if not own:
                continue
            worst = max(own, key=lambda j: abs(j.change))
            unit, shown, factor = UNITS[name]
            most, allowed = factor * worst.change, factor * worst.allowed
            times = "" if len(own) == 1 else f"{len(own)} times, most "
            said = (
                f"{name} jumps {times}by {most:.3g} {shown} at {time[worst.k]:.6g} s, where its rates allow "
                f"{allowed:.2g} {shown}"
            )
            size = (exact("largest jump", worst.change, unit),)
            together = any(abs(j.k - k) <= 1 for j in own for k in far)  # where noise hides the first of two rows
            joined = name == HEADING and (abs(worst.change) > JOINED or together)
            said += ": two runs in one? cut the record there" if joined else ""
            faults.append(Fault(said, (name,), size, columns=_mended(record, name, own, joined), standing=joined))
        return faults


def _mended(record: Record, name: str, own: Sequence[Jump], joined: bool) -> dict[str, np.ndarray]:
    """The column without the samples about its jumps, the heading of one run without those that stay, and velocities
    that were made with these turned back."""
    columns = {name: record.column(name).copy()}
    large = [j for j in own if name == HEADING and not joined and abs(j.error) > RESET]
    for jump in (j for j in large if _stays(record, j)):
        columns[name][jump.k :] -= jump.error
        if _carries_velocities(record, jump):
            speeds = {n: columns.get(n, record.column(n)).copy() for n in VELOCITIES}
            turned = over_ground(*(values[jump.k :] for values in speeds.values()), jump.error)
            for values, later in zip(speeds.values(), (turned.real, turned.imag), strict=True):
                values[jump.k :] = later
            columns |= speeds
    half = LONGEST_GAP // 2 + 1
    for jump in own:
        columns[name][max(jump.k - half, 0) : jump.k + half + 1] = np.nan
    return columns


def _usual_speed(record: Record) -> float:
    """Median speed through the water, m/s."""
    sway = record.column("sway_m_s") if record.has("sway_m_s") else 0.0
    return float(np.nanmedian(np.abs(record.column("surge_m_s") + 1j * sway)))


def _stays(record: Record, jump: Jump) -> bool:
    """Whether what the rate leaves of the heading keeps a jump, as of a compass that was reset: of one that lags and
    catches up it comes back."""
    time = record.time_s
    left = record.heading_unwrapped() - integral(bridged(record.column("yaw_rate_rad_s"), time), time)
    before, after = (side[np.isfinite(side)] for side in _sides(left, jump.k))
    if not (before.size and after.size):
        return True
    return float(np.median(after) - np.median(before)) / jump.error > STAYS


def _carries_velocities(record: Record, jump: Jump) -> bool:
    """Whether surge and sway were made with the heading that jumps: with it the way that they give keeps its direction
    along the track, and with a heading without the jump it does not."""
    if not record.has(*TRACK):
        return False
    courses, series = [], (velocity_over_ground(record), position_over_ground(record), record.time_s)
    for velocity, place, time in zip(*(_sides(values, jump.k) for values in series), strict=True):
        known = np.isfinite(velocity) & np.isfinite(place)
        if known.sum() < NEAR:
            return False
        way = integral(velocity[known], time[known])[-1]
        courses.append((place[known][-1] - place[known][0]) * np.conj(way))
    return abs(float(np.angle(courses[1] * np.conj(courses[0])))) < STAYS * abs(jump.error)


def _sides(values: np.ndarray, k: int) -> tuple[np.ndarray, np.ndarray]:
    """The values that lie near before and after sample k."""
    return values[max(k - FAR, 0) : max(k - NEAR, 0)], values[k + NEAR : k + FAR]
