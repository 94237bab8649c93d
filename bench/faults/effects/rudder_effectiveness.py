"""The rudder acts 1 + e times as strongly as its recorded angle."""

from __future__ import annotations

from ..ships import Ship
from ._rudder import rudder_columns
from .base import RecordEffect, ScalarKind


class RudderEffectiveness(ScalarKind, RecordEffect):
    """The rudder acts 1 + e times as strongly as its recorded angle."""

    id = "rudder_effectiveness"
    rank = 1
    parameter, unit = "e", "1"
    negative = 0.8
    cap = 0.8
    response = True

    def size(self, ship: Ship) -> float:
        return 0.01

    def rudder(self, p) -> dict[str, float]:
        return {"effectiveness": p["e"]}

    def change_record(self, rows, time, p, rng) -> None:
        for name in rudder_columns(rows):
            rows[name] = rows[name] / (1.0 + p["e"])
