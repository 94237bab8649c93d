"""Sensor error `reference_point`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..base import SensorError
from ..comparison.series import TrackEffect

if TYPE_CHECKING:
    from ...datasets.record import Record


class ReferencePoint(SensorError):
    """Positions of another point than velocities: recorded position = true + x (cos psi, sin psi), x in m forward of
    the point whose velocities are recorded (an antenna that is not at the centre of gravity)."""

    id = "reference_point"
    unit = "m"
    named = True
    corrects = ("north_m", "east_m", "heading_rad")
    separate_by = (
        "where antenna and log stand, and a run at another speed: a delay moves with the speed, a point does not"
    )
    track = (TrackEffect("x", "m", (), lambda path: path.ahead, lambda path: path.lever_floor),)

    def corrected_for(self, record: Record, values: np.ndarray) -> Record:
        """The record with positions moved back by x."""
        psi, x = record.heading_unwrapped(), float(values[0])
        return record.with_channels(
            north_m=record.column("north_m") - x * np.cos(psi), east_m=record.column("east_m") - x * np.sin(psi)
        )
