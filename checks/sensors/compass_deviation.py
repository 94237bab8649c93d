"""Sensor error `compass_deviation`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..base import SensorError
from ..comparison.series import TurnEffect, half_a_degree

if TYPE_CHECKING:
    from ...datasets.record import Record

ROUNDS = 8


class CompassDeviation(SensorError):
    """Compass error that goes with the heading: recorded = true + c cos(true) + s sin(true), c and s in rad (iron in
    the ship, or a wrongly calibrated magnetic compass)."""

    id = "compass_deviation"
    unit = "rad"
    named = True
    corrects = ("heading_rad",)
    separate_by = "a full circle against a gyro compass or against courses from positions"
    turn = (
        TurnEffect("c", "rad", (), lambda turn: np.cos(turn.heading)[None] - np.cos(turn.heading[0]), half_a_degree),
        TurnEffect("s", "rad", (), lambda turn: np.sin(turn.heading)[None] - np.sin(turn.heading[0]), half_a_degree),
    )
    least_turn = np.pi
    """Range of headings (rad) from which it is told from a scale error."""

    farthest = 0.6

    def corrected_for(self, record: Record, values: np.ndarray) -> Record:
        """The record with the deviation (c, s) removed from its heading, by fixed-point steps."""
        given = record.heading_unwrapped()
        true = given
        for _ in range(ROUNDS):
            true = given - values[0] * np.cos(true) - values[1] * np.sin(true)
        return record.with_channels(heading_rad=true)
