"""The yaw-rate sensor has a constant bias."""

from __future__ import annotations

from ..ships import DEGREE, Ship
from ._sensors import OffsetKind
from .base import ScalarKind


class YawRateBias(ScalarKind, OffsetKind):
    """The yaw-rate sensor has a constant bias."""

    id = "yaw_rate_bias"
    rank = 8
    parameter, unit = "b", "rad/s"
    channel = "yaw_rate_rad_s"
    response = True

    def size(self, ship: Ship) -> float:
        return 0.003 * DEGREE / ship.clock
