"""Sensor error `position_delay`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...datasets.instruments import later
from ..base import SensorError
from ..comparison.series import LogEffect, TrackEffect, late_floor

if TYPE_CHECKING:
    from ...datasets.record import Record


class PositionDelay(SensorError):
    """Late positions: recorded(t) = true(t - tau), tau in s, against heading and velocities (a satellite receiver that
    filters or sends late)."""

    id = "position_delay"
    unit = "s"
    named = True
    corrects = ("north_m", "east_m")
    separate_by = "time stamps of each instrument, and a run at another speed: a point moves with the ship, not a delay"
    track = (TrackEffect("tau", "s", (), lambda path: -path.late_motion, late_floor, delay=True),)
    log = (LogEffect("tau", "s", (), lambda log: -log.late_speed, late_floor, delay=True),)

    def corrected_for(self, record: Record, values: np.ndarray) -> Record:
        """The record with positions tau earlier; the last are lost."""
        late = float(values[0])
        return record.with_channels(
            **{name: later(record.time_s, record.column(name), late) for name in ("north_m", "east_m")}
        )
