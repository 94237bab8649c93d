"""Check `splice`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...datasets.geometry import position_over_ground, velocity_over_ground
from ...datasets.signals import bridged, integral
from ..base import FileCheck
from ..comparison.whitening import LONGEST_GAP
from ..fault import Fault, exact
from ..integrity.jumps import Jump, jumps

if TYPE_CHECKING:
    from ...datasets.record import Record

JOINED = 0.17
"""Jump of the heading, rad, from which it is no sensor that catches up, but two runs in one; a smaller one is where a
position jumps far in the same row."""
LATE_S = 5.0
"""Seconds of way from which a position jumps far: compass and position of one receiver that was late catch up together,
by less than 2 s of way (Esso Osaka, 10 Hz); the halves of a measured run lie more than 10 s apart."""
RESET = 0.05
"""Jump of the heading, rad, from which it is taken out where it stays: what rate and heading disagree by around a
smaller one does not tell whether it stays."""
HEADING = "heading_rad"
NEAR, FAR = 10, 60
"""Samples before and after a jump between which heading and rate are compared."""
STAYS = 0.5
"""Share of a jump that must be left there of it."""
UNITS = {HEADING: "rad", "north_m": "m", "east_m": "m"}


class Splice(FileCheck):
    """A jump of heading or position beyond what yaw rate and speed allow: pieces joined, or a sensor that was reset."""

    id = "splice"
    rank = 60
    unit = "m, rad"
    separate_by = "the original files, piece by piece"

    def find(self, record: Record) -> list[Fault]:
        found, time, every = [], record.time_s, jumps(record)
        moved = [j for j in every if j.channel != HEADING]
        way = LATE_S * _usual_speed(record) if moved else 0.0
        far = {j.k for j in moved if abs(j.error) > way}
        for name in UNITS:
            own = [j for j in every if j.channel == name]
            if not own:
                continue
            worst = max(own, key=lambda j: abs(j.change))
            unit = UNITS[name]
            said = (
                f"{name} jumps {len(own)} times, most by {worst.change:.4g} {unit} at {time[worst.k]:.6g} s, where its "
                f"rates allow {worst.allowed:.2g} {unit}"
            )
            half = LONGEST_GAP // 2 + 1
            blanks = tuple((name, j.k - half, j.k + half + 1) for j in own)
            size = (exact("largest jump", worst.change, unit),)
            joined = name == HEADING and (abs(worst.change) > JOINED or not far.isdisjoint(j.k for j in own))
            said += ": two runs in one? cut the record there" if joined else ""
            large = [j for j in own if name == HEADING and not joined and abs(j.error) > RESET]
            reset = [j for j in large if _stays(record, j)]
            steps = tuple((name, j.k, j.error) for j in reset)
            turns = tuple((j.k, j.error) for j in reset if _carries_velocities(record, j))
            found.append(Fault(said, (name,), size, blanks=blanks, steps=steps, turns=turns, standing=joined))
        return found


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
    if not record.has(HEADING, "surge_m_s", "sway_m_s", "north_m", "east_m"):
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
