"""The velocities are recorded tau seconds late, and heading and yaw rate too where `attitude` is 1."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from ._sensors import ATTITUDE, VELOCITY, SensorKind, delay_columns
from .base import Setting


class VelocityDelay(SensorKind):
    """The velocities are recorded tau seconds late, and heading and yaw rate too where `attitude` is 1."""

    id = "velocity_delay"
    rank = 14
    units: ClassVar = {"tau": "s", "attitude": "0 or 1"}
    sized = ("tau",)

    def draw(self, s: Setting, rng: np.random.Generator) -> dict[str, float]:
        return {"tau": 0.2 * s.ship.clock * rng.uniform(0.7, 1.4), "attitude": float(rng.random() < 0.5)}

    def delay_s(self, channel, p) -> float:
        return p["tau"] if channel in self._channels(p) else 0.0

    def change_record(self, rows, time, p, rng) -> None:
        delay_columns(rows, time, [name for name in self._channels(p) if name in rows], p["tau"])

    @staticmethod
    def _channels(p) -> tuple[str, ...]:
        return (*VELOCITY, *ATTITUDE) if p.get("attitude") else VELOCITY
