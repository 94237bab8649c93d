"""Check `rudder_from_sensor`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...datasets.record import RUDDERS
from ..base import FileCheck
from ..fault import Fault, exact
from ..integrity.copies import CLEAR, SHARED, shared_noise

if TYPE_CHECKING:
    from ...datasets.record import Record


class RudderFromSensor(FileCheck):
    """The rudder column carries another sensor's noise at the same instant: it was computed from that sensor (an
    autopilot's order), so that no rudder cause can be named."""

    id = "rudder_from_sensor"
    rank = 80
    separate_by = "a rudder angle feedback, or a rudder order that does not depend on the sensors"

    def find(self, record: Record) -> list[Fault]:
        found = []
        for rudder in (name for name in RUDDERS if record.has(name)):
            for name in ("yaw_rate_rad_s", "heading_rad"):
                if not record.has(name):
                    continue
                other = record.continuous(name)
                correlation, z = shared_noise(record.column(rudder), other)
                if abs(correlation) > SHARED and abs(z) > CLEAR:
                    said = (
                        f"the noise of {rudder} goes with that of {name} at lag zero (correlation {correlation:.2f}, "
                        f"z = {z:.0f})"
                    )
                    found.append(Fault(said, (rudder, name), (exact("correlation", correlation, "1"),)))
        return found
