"""Check `derived_channel`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...datasets.geometry import velocity_over_ground
from ..base import FileCheck
from ..fault import Fault
from ..integrity.copies import equal_columns, rate_is_derived
from ..integrity.readings import TRACK
from ..integrity.stamps import stamps

if TYPE_CHECKING:
    from ...datasets.record import Record

MISSING = 0.02
"""Share of missing rows from which nothing is said of the rest."""
TURN = ("heading_rad", "yaw_rate_rad_s")


class DerivedChannel(FileCheck):
    """A channel that was computed from another one in the record: the two cannot check each other."""

    id = "derived_channel"
    rank = 70
    separate_by = "the raw output of each sensor"

    def find(self, record: Record) -> list[Fault]:
        found = [Fault(f"{a} and {b} hold the same numbers", (a, b), material=False) for a, b in equal_columns(record)]
        if record.n < 3 or stamps(record.time_s).missing > MISSING * record.n:
            return found  # noise over steps that differ is not comparable
        if record.has(*TURN):
            why = rate_is_derived(record.heading_unwrapped(), record.column(TURN[1]), record.time_s)
            if why:
                found.append(Fault(f"yaw_rate_rad_s is made from heading_rad: {why}", TURN))
        if record.has(*TRACK):
            velocity = velocity_over_ground(record)
            whys = [
                rate_is_derived(record.column(name), rate, record.time_s)
                for name, rate in zip(TRACK[3:], (velocity.real, velocity.imag), strict=True)
            ]
            if all(whys):
                found.append(Fault(f"surge_m_s and sway_m_s are made from the positions: {whys[0]}", TRACK[1:]))
        return found
