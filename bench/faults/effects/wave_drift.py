"""Mean second-order wave forces of a significant wave height Hs, different in each record."""

from __future__ import annotations

from typing import ClassVar

from ..ships import Ship
from .base import WeatherKind


class WaveDrift(WeatherKind):
    """Mean second-order wave forces of a significant wave height Hs, different in each record."""

    id = "wave_drift"
    rank = 23
    units: ClassVar = {"Hs": "m", "from": "rad"}
    sized = ("Hs",)
    directions = ("from",)

    def size(self, ship: Ship) -> float:
        return 0.3 * ship.clock**2

    def forces(self, p) -> dict[str, float]:
        return {"Hs": p["Hs"], "wave_from": p["from"]}
