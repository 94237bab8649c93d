"""Cause `velocity_delay`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from ..kinematics.series import TrackEffect, late_floor
from ..searches.score import ByScore
from .base import Cause, one, require_channels

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..state import Variant

ALL_LATE = ("surge_delay", "sway_delay", "yaw_rate_delay", "heading_delay")


class VelocityDelay(Cause):
    """Late velocities: surge and sway (in a second variant yaw rate and heading too) recorded a time tau [s] late
    against the position."""

    id = "velocity_delay"
    where = "sensor"
    unit = "s"
    search = ByScore((0.3, 1.0, 2.0, 3.5))
    smallest = 0.05
    largest = 6.0
    power_size = 0.2
    separate_by = "time stamps of each instrument"
    track = (
        TrackEffect("tau", "s", ("surge_delay", "sway_delay"), lambda path: path.late_speeds, late_floor, delay=True),
        TrackEffect("tau", "s", ALL_LATE, lambda path: path.late_motion, late_floor, delay=True),
    )

    def variants(self, est: Estimator) -> Sequence[Variant]:
        require_channels(est, "u", "v")
        late = {"scale": 0.05, "low": 0.0, "high": 8.0}
        return [
            one(est, "tau", "s", "surge_delay", "sway_delay", **late),
            one(est, "tau", "s", *ALL_LATE, **late),
        ]

    def details(self, est: Estimator, variant: Variant) -> Mapping[str, str]:
        return {"late": "surge, sway, yaw rate and heading" if len(variant[0].slots) > 2 else "surge and sway"}
