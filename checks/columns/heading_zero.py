"""Check `heading_zero`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..integrity.readings import better_reading, read_as
from ._base import ColumnCheck, ColumnFault

if TYPE_CHECKING:
    from ...datasets.record import Record


class HeadingZero(ColumnCheck):
    """The heading counts from another direction, or is read astern: recorded = true + a, a beyond what a compass may
    err, as the positions show against heading and velocities."""

    id = "heading_zero"
    rank = 57
    columns = ("heading_rad",)
    separate_by = "the mounting and the zero of the compass, and whether the ship went astern"

    def find(self, records: Sequence[Record], starboard: float) -> tuple[list[ColumnFault], list[Record]]:
        better = better_reading(records)
        if better is None or better.reading.check != self.id:
            return [], list(records)
        said = better.evidence("with the heading turned by 180 deg")
        fault = ColumnFault(self, {}, said, better.statistic, {"heading_bias": float(np.pi)})
        return [fault], read_as(records, better.reading)
