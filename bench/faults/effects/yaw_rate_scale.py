"""The yaw-rate sensor gives 1 + s times the yaw rate."""

from __future__ import annotations

from ..ships import Ship
from ._sensors import ScaleKind
from .base import ScalarKind


class YawRateScale(ScalarKind, ScaleKind):
    """The yaw-rate sensor gives 1 + s times the yaw rate."""

    id = "yaw_rate_scale"
    rank = 9
    parameter, unit = "s", "1"
    cap = 0.6
    channels = ("yaw_rate_rad_s",)
    response = True

    def size(self, ship: Ship) -> float:
        return 0.01
