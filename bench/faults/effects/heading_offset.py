"""The heading sensor has a constant bias."""

from __future__ import annotations

from ..ships import DEGREE, Ship
from ._sensors import OffsetKind
from .base import ScalarKind


class HeadingOffset(ScalarKind, OffsetKind):
    """The heading sensor has a constant bias."""

    id = "heading_offset"
    rank = 10
    parameter, unit = "b", "rad"
    channel = "heading_rad"

    def size(self, ship: Ship) -> float:
        return 0.1 * DEGREE
