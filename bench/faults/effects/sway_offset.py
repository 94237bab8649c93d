"""The sway velocity has a constant bias."""

from __future__ import annotations

from ..ships import Ship
from ._sensors import OffsetKind
from .base import ScalarKind


class SwayOffset(ScalarKind, OffsetKind):
    """The sway velocity has a constant bias."""

    id = "sway_offset"
    rank = 12
    parameter, unit = "b", "m/s"
    channel = "sway_m_s"

    def size(self, ship: Ship) -> float:
        return 0.005 * ship.clock
