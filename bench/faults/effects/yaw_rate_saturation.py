"""The yaw-rate sensor cuts off what exceeds its range."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from ..regimes import Regime
from ..ships import Ship
from ._regime import RegimeKind
from ._sensors import SensorKind, Stage
from .base import Setting


class YawRateSaturation(SensorKind, RegimeKind):
    """The yaw-rate sensor cuts off what exceeds its range."""

    id = "yaw_rate_saturation"
    rank = 63
    units: ClassVar = {"limit": "rad/s"}
    response = True
    stage = Stage.COLUMN
    right = ("yaw_rate_scale", "yaw_rate_saturation")

    def draw(self, s: Setting, rng: np.random.Generator) -> dict[str, Any]:
        return {"limit": float(rng.uniform(0.15, 0.24)) * s.ship.speed_m_s / s.ship.length_m}

    def apply(self, rows, time, p, noise_sd, rng) -> None:
        rows["yaw_rate_rad_s"] = np.clip(rows["yaw_rate_rad_s"], -p["limit"], p["limit"])

    def regime(self, p, ship: Ship) -> Regime:
        return Regime("yaw_rate", "above", p["limit"])
