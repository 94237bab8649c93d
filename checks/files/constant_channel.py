"""Check `constant_channel`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...datasets.columns import CANONICAL
from ..base import FileCheck
from ..fault import SENSED, Fault
from ..integrity.readings import TRACK, track_error
from ..integrity.runs import never_changes

if TYPE_CHECKING:
    from ...datasets.record import Record

SPEEDS = ("surge_m_s", "sway_m_s")
TURN = 0.5
"""Range of headings, rad, over which every ship loses speed and drifts: a speed that stays the same is none."""
CONFIRMED = 0.01
"""Disagreement of the track, as a share of the way made, below which positions confirm a speed that stays the same."""


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
            elif known.size > 1 and never_changes(known):
                found.append(_constant(record, name, float(np.median(known))))
        return found


def _constant(record: Record, name: str, value: float) -> Fault:
    """A channel that is the same value in every row; a speed that positions confirm is a remark."""
    said = f"{name} is {value:.6g} {CANONICAL[name]} in every row"
    if name in SPEEDS and record.has(*TRACK) and track_error(record) < CONFIRMED:
        return Fault(f"{said}, and heading and positions show the same velocity", (name,), material=False)
    dead = name in SPEEDS and _turns(record)
    said += " while the ship turns: no measured speed, leave the column out" if dead else ""
    blanks = ((name, 0, record.n),) if dead else ()
    return Fault(said, (name,), material=name in SENSED, blanks=blanks, biases=dead)


def _turns(record: Record) -> bool:
    heading = record.heading_unwrapped() if record.has("heading_rad") else np.zeros(1)
    return bool(np.isfinite(heading).any()) and float(np.nanmax(heading) - np.nanmin(heading)) > TURN
