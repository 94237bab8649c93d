"""Check `splice`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...datasets.signals import bridged, integral
from ..base import FileCheck
from ..comparison.whitening import LONGEST_GAP
from ..fault import Fault, exact
from ..integrity.jumps import Jump, jumps

if TYPE_CHECKING:
    from ...datasets.record import Record

JOINED = 0.17
"""Jump of the heading, rad, from which it is no sensor that catches up, but two runs in one; a smaller one is where a
position jumps in the same row."""
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
        moved = {j.k for j in every if j.channel != HEADING}
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
            joined = name == HEADING and (abs(worst.change) > JOINED or not moved.isdisjoint(j.k for j in own))
            said += ": two runs in one? cut the record there" if joined else ""
            reset = tuple((name, j.k, j.error) for j in own if name == HEADING and not joined and _stays(record, j))
            found.append(Fault(said, (name,), size, blanks=blanks, steps=reset, standing=joined))
        return found


def _stays(record: Record, jump: Jump) -> bool:
    """Whether what the rate leaves of the heading keeps a jump, as of a compass that was reset: of one that lags and
    catches up it comes back."""
    time = record.time_s
    left = record.heading_unwrapped() - integral(bridged(record.column("yaw_rate_rad_s"), time), time)
    sides = left[max(jump.k - FAR, 0) : max(jump.k - NEAR, 0)], left[jump.k + NEAR : jump.k + FAR]
    before, after = (side[np.isfinite(side)] for side in sides)
    if not (before.size and after.size):
        return True
    return float(np.median(after) - np.median(before)) / jump.error > STAYS
