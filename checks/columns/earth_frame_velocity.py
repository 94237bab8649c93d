"""Check `earth_frame_velocity`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..integrity.readings import better_reading, read_as
from ._base import ColumnCheck, ColumnFault

if TYPE_CHECKING:
    from ...datasets.record import Record


class EarthFrameVelocity(ColumnCheck):
    """The surge and sway columns hold velocities along north and east."""

    id = "earth_frame_velocity"
    rank = 56
    columns = ("surge_m_s", "sway_m_s")
    separate_by = "the logger's list of channels"

    def find(self, records: Sequence[Record], starboard: float) -> tuple[list[ColumnFault], list[Record]]:
        better = better_reading(records)
        if better is None or better.reading.check != self.id:
            return [], list(records)
        said = better.evidence("when they are read as north and east")
        fault = ColumnFault(self, {}, said, better.statistic, {"earth_frame_velocity": 1.0})
        return [fault], read_as(records, better.reading)
