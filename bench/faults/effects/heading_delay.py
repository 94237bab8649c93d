"""The heading is recorded tau seconds late."""

from __future__ import annotations

from ..ships import Ship
from ._sensors import SensorKind, delay_columns
from .base import ScalarKind


class HeadingDelay(ScalarKind, SensorKind):
    """The heading is recorded tau seconds late."""

    id = "heading_delay"
    rank = 13
    parameter, unit = "tau", "s"
    negative = 0.0
    response = True

    def size(self, ship: Ship) -> float:
        return 0.2 * ship.clock

    def delay_s(self, channel, p) -> float:
        return p["tau"] if channel == "heading_rad" else 0.0

    def change_record(self, rows, time, p, rng) -> None:
        delay_columns(rows, time, ["heading_rad"], p["tau"])
