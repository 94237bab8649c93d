"""The recorded rudder has the wrong sign."""

from __future__ import annotations

from ._rudder import rudder_columns
from ._sensors import SensorKind


class RudderSign(SensorKind):
    """The recorded rudder has the wrong sign."""

    id = "rudder_sign"
    rank = 7
    response = True

    def apply(self, rows, time, p, noise_sd, rng) -> None:
        for name in rudder_columns(rows):
            rows[name] = -rows[name]
