"""A sensor of heading or yaw rate drifts linearly through the record."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from ..ships import DEGREE
from ._sensors import SensorKind
from .base import ANTICIPATED, Setting, random_sign


class SensorRamp(SensorKind):
    """A sensor of heading or yaw rate drifts linearly through the record."""

    id = "sensor_ramp"
    group = ANTICIPATED
    rank = 39
    units: ClassVar = {"size": "rad or rad/s"}
    sized = ("size",)
    response = True

    def draw(self, s: Setting, rng: np.random.Generator) -> dict[str, Any]:
        channel = str(rng.choice(("yaw_rate_rad_s", "heading_rad")))
        return {"channel": channel, "size": random_sign(rng) * 0.05 * DEGREE}

    def apply(self, rows, time, p, noise_sd, rng) -> None:
        rows[p["channel"]] = rows[p["channel"]] + p["size"] * time / time[-1]

    def variables(self, p: Mapping[str, Any]) -> frozenset[str]:
        return frozenset({"time"})
