"""Sensor error `speed_scale`."""

from __future__ import annotations

from ..base import SensorError
from ..comparison.series import LogEffect, TrackEffect, half_a_percent


class SpeedScale(SensorError):
    """Scale error of the speed log: recorded surge and sway = (1 + s) true."""

    id = "speed_scale"
    unit = "1"
    separate_by = "a measured mile in both directions"
    farthest = 1.0
    track = (TrackEffect("s", "1", ("surge_scale", "sway_scale"), lambda path: -path.way, half_a_percent),)
    log = (LogEffect("s", "1", ("surge_scale",), lambda log: -log.run[None], half_a_percent),)
