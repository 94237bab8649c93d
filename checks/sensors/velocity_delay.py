"""Sensor error `velocity_delay`."""

from __future__ import annotations

from ..base import SensorError
from ..comparison.series import LogEffect, TrackEffect, late_floor

ALL_LATE = ("surge_delay", "sway_delay", "yaw_rate_delay", "heading_delay")


class VelocityDelay(SensorError):
    """Late velocities: surge and sway (in a second variant yaw rate and heading too) recorded a time tau [s] late
    against the position."""

    id = "velocity_delay"
    unit = "s"
    separate_by = "time stamps of each instrument"
    track = (
        TrackEffect("tau", "s", ("surge_delay", "sway_delay"), lambda path: path.late_speeds, late_floor, delay=True),
        TrackEffect("tau", "s", ALL_LATE, lambda path: path.late_motion, late_floor, delay=True),
    )
    log = (LogEffect("tau", "s", ("surge_delay",), lambda log: log.late_speed, late_floor, delay=True),)
