"""Samples are taken at times with a random error."""

from __future__ import annotations

import numpy as np

from ..ships import Ship
from ._sensors import SensorKind
from .base import ScalarKind


class ClockJitter(ScalarKind, SensorKind):
    """Samples are taken at times with a random error."""

    id = "clock_jitter"
    rank = 19
    parameter, unit = "sd", "s"
    negative = 0.0
    variance_only = True
    response = True

    def size(self, ship: Ship) -> float:
        """Large errors (ten times) are below half of a sampling step of .5 s: samples keep their order."""
        return 0.015 * ship.clock

    def jitter_s(self, p) -> float:
        return p["sd"]

    def change_record(self, rows, time, p, rng) -> None:
        taken = np.clip(time + p["sd"] * rng.standard_normal(time.size), time[0], time[-1])
        for name, values in rows.items():
            rows[name] = np.interp(taken, time, values)
