"""The rudder at the hull follows the recorded one after tau seconds."""

from __future__ import annotations

import numpy as np

from ..ships import Ship
from ._rudder import rudder_columns
from .base import RecordEffect, ScalarKind


class RudderDelay(ScalarKind, RecordEffect):
    """The rudder at the hull follows the recorded one after tau seconds."""

    id = "rudder_delay"
    rank = 2
    parameter, unit = "tau", "s"
    negative = 0.0
    response = True

    def size(self, ship: Ship) -> float:
        return 0.2 * ship.clock

    def rudder(self, p) -> dict[str, float]:
        return {"delay": p["tau"]}

    def change_record(self, rows, time, p, rng) -> None:
        """The end, for which there is no later rudder, keeps the last value: a rudder column has no gaps."""
        for name in rudder_columns(rows):
            rows[name] = np.interp(time + p["tau"], time, rows[name])
