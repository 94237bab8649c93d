"""A uniform current towards a direction, different in each record."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from ..ships import Ship
from .base import WeatherKind


class Current(WeatherKind):
    """A uniform current towards a direction, different in each record."""

    id = "current"
    rank = 20
    units: ClassVar = {"speed": "m/s", "towards": "rad"}
    sized = ("speed",)
    directions = ("towards",)

    def size(self, ship: Ship) -> float:
        return 0.03 * ship.clock

    def forces(self, p) -> dict[str, float]:
        return {"current_north": p["speed"] * np.cos(p["towards"]), "current_east": p["speed"] * np.sin(p["towards"])}
