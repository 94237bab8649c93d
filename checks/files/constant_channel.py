"""Check `constant_channel`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...datasets.columns import CANONICAL
from ..base import FileCheck
from ..fault import SENSED, Fault

if TYPE_CHECKING:
    from ...datasets.record import Record

SPEEDS = ("surge_m_s", "sway_m_s")
TURN = 0.5
"""Range of headings, rad, over which every ship loses speed and drifts: a speed that stays the same is none."""


class ConstantChannel(FileCheck):
    """A channel that never changes, or never has a value: a dead sensor, or one that was not connected."""

    id = "constant_channel"
    rank = 0
    separate_by = "a record in which the quantity surely changes"

    def find(self, record: Record) -> list[Fault]:
        found = []
        for name, values in record.channels.items():
            known = values[np.isfinite(values)]
            if not known.size:
                found.append(Fault(f"{name} has no value at all", (name,)))
            elif known.size > 1 and np.ptp(known) == 0.0:
                said = f"{name} is {known[0]:.6g} {CANONICAL[name]} in every row"
                dead = name in SPEEDS and _turns(record)
                said += " while the ship turns: no measured speed, leave the column out" if dead else ""
                blanks = ((name, 0, record.n),) if dead else ()
                found.append(Fault(said, (name,), material=name in SENSED, blanks=blanks, biases=dead))
        return found


def _turns(record: Record) -> bool:
    heading = record.heading_unwrapped() if record.has("heading_rad") else np.zeros(1)
    return bool(np.isfinite(heading).any()) and float(np.nanmax(heading) - np.nanmin(heading)) > TURN
