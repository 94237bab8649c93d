"""Check `splice`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..base import FileCheck
from ..comparison.whitening import LONGEST_GAP
from ..fault import Fault, exact
from ..integrity.jumps import jumps

if TYPE_CHECKING:
    from ...datasets.record import Record

JOINED = 0.17
"""Jump of the heading, rad, from which it is no sensor that catches up, but two runs in one; a smaller one is where a
position jumps in the same row."""
HEADING = "heading_rad"
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
            found.append(Fault(said, (name,), size, blanks=blanks, standing=joined))
        return found
