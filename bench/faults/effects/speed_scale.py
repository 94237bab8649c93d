"""The speed log gives 1 + s times both velocities."""

from __future__ import annotations

from ..ships import Ship
from ._sensors import VELOCITY, ScaleKind
from .base import ScalarKind


class SpeedScale(ScalarKind, ScaleKind):
    """The speed log gives 1 + s times both velocities."""

    id = "speed_scale"
    rank = 11
    parameter, unit = "s", "1"
    cap = 0.6
    channels = VELOCITY

    def size(self, ship: Ship) -> float:
        return 0.002
