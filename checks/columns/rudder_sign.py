"""Check `rudder_sign`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...datasets.columns import RUDDERS
from ...datasets.rudder_sign import ONE_SIDE, one_sided, steering_side
from ..integrity.steering import response
from ._base import ColumnCheck, ColumnFault

if TYPE_CHECKING:
    from ...datasets.record import Record

CLEAR = 6.0
"""Standard deviations by which the rudder must act to the other side."""
TURNING = 10.0
"""What a turn all of which goes to one side counts for, in standard deviations."""


class RudderSign(ColumnCheck):
    """The rudder column's sign contradicts the vessel: b in r' = a r + c r |r| + b delta + d has the other sign,
    as it is and at the lag that fits best (a late rudder looks turned, and is not); or all of a turn goes against its
    rudder."""

    id = "rudder_sign"
    rank = 58
    joint = True
    columns = RUDDERS
    separate_by = "one rudder order and the side to which the ship turns"

    def find(self, records: Sequence[Record], starboard: float) -> tuple[list[ColumnFault], list[Record]]:
        z = starboard * _sign(records)
        if not z < -CLEAR:
            return [], list(records)
        said = (
            f"a rudder angle the record calls positive turns the ship to the other side than the model's ({-z:.0f} sd)"
        )
        return [ColumnFault(self, {}, said, z * z, {"rudder_reversed": 1.0})], [_turned(r) for r in records]


def _sign(records: Sequence[Record]) -> float:
    """Standard deviations by which a positive rudder turns the ship to starboard; in turns alone the share of the yaw
    rate that goes to one side, counted as so many; 0 where nothing tells it."""
    swung = [r for r in records if not _held(r)]
    if not swung:
        sides = [side for r in records if (side := steering_side(r)) is not None]
        same = len({side for side, _ in sides}) == 1
        return TURNING * min(sure for _, sure in sides) * (1.0 if sides[0][0] == "starboard" else -1.0) if same else 0.0
    found = response(swung)
    return found.z if found is not None and found.z * found.z_best > 0.0 else 0.0


def _held(record: Record) -> bool:
    """Whether the rudder is held to one side: then the yaw acceleration says little of it."""
    rudder = record.rudder()
    return abs(one_sided(rudder[np.isfinite(rudder)])) > ONE_SIDE


def _turned(record: Record) -> Record:
    return record.with_channels(**{n: -record.column(n) for n in RUDDERS if record.has(n)})
