"""The axes of the speed log are turned by an angle to starboard."""

from __future__ import annotations

from ..ships import DEGREE, Ship
from ._sensors import SensorKind, Stage, turn_velocity
from .base import ScalarKind


class AxisMisalignment(ScalarKind, SensorKind):
    """The axes of the speed log are turned by an angle to starboard."""

    id = "axis_misalignment"
    rank = 17
    parameter, unit = "angle", "rad"
    cap = 0.6
    stage = Stage.ALIGNMENT

    def size(self, ship: Ship) -> float:
        return 0.1 * DEGREE

    def apply(self, rows, time, p, noise_sd, rng) -> None:
        turn_velocity(rows, p["angle"])
