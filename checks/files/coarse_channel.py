"""Check `coarse_channel`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...datasets.columns import CANONICAL
from ..base import FileCheck
from ..fault import SENSED, Fault, exact
from ..integrity.runs import resolution

if TYPE_CHECKING:
    from ...datasets.record import Record

SEEN, MATTERS = 0.002, 0.02
"""Shares of a channel's spread from which its steps are told, and from which they matter."""


class CoarseChannel(FileCheck):
    """A channel that is stored in coarse steps: rounded, or of a sensor with few digits."""

    id = "coarse_channel"
    rank = 30
    separate_by = "the sensor's data sheet, or an export with more digits"

    def find(self, record: Record) -> list[Fault]:
        found = []
        for name in (n for n in SENSED if record.has(n)):
            values = record.continuous(name)
            step, spread = resolution(values), float(np.nanstd(values)) if np.isfinite(values).any() else 0.0
            if step > SEEN * spread:
                said = f"{name} takes steps of {step:.3g}, {100.0 * step / spread:.1f} % of its standard deviation"
                found.append(Fault(said, (name,), (exact("step", step, CANONICAL[name]),), step > MATTERS * spread))
        return found
