"""A steady wind from a direction, different in each record."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from ..ships import Ship
from .base import WeatherKind


class Wind(WeatherKind):
    """A steady wind from a direction, different in each record."""

    id = "wind"
    rank = 21
    units: ClassVar = {"speed": "m/s", "from": "rad"}
    sized = ("speed",)
    directions = ("from",)

    def size(self, ship: Ship) -> float:
        return 0.7 * ship.clock

    def forces(self, p) -> dict[str, float]:
        return {"wind_north": -p["speed"] * np.cos(p["from"]), "wind_east": -p["speed"] * np.sin(p["from"])}
