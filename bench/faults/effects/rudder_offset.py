"""The rudder at the hull is off by a constant angle delta0."""

from __future__ import annotations

from ..ships import DEGREE, Ship
from ._rudder import rudder_columns
from .base import RecordEffect, ScalarKind


class RudderOffset(ScalarKind, RecordEffect):
    """The rudder at the hull is off by a constant angle delta0."""

    id = "rudder_offset"
    rank = 0
    parameter, unit = "delta0", "rad"
    response = True

    def size(self, ship: Ship) -> float:
        return 0.1 * DEGREE

    def rudder(self, p) -> dict[str, float]:
        return {"offset": p["delta0"]}

    def change_record(self, rows, time, p, rng) -> None:
        for name in rudder_columns(rows):
            rows[name] = rows[name] - p["delta0"]
