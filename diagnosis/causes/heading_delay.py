"""Cause `heading_delay`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..kinematics.series import TrackEffect, TurnEffect, late_floor
from ..searches.score import ByScore
from .base import Cause, one, require_channels

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..state import Variant


class HeadingDelay(Cause):
    """Late heading: recorded(t) = true(t - tau), tau in s."""

    id = "heading_delay"
    where = "sensor"
    unit = "s"
    search = ByScore((0.1, 0.4, 1.0, 2.0))
    smallest = 0.05
    largest = 4.0
    power_size = 0.2
    separate_by = "yaw rate and heading of instruments with known time stamps"
    turn = (
        TurnEffect(
            "tau",
            "s",
            ("heading_delay",),
            lambda turn: turn.quiet_rate[:1, None] - turn.quiet_rate[None],
            late_floor,
            delay=True,
        ),
    )
    track_without_model = (
        TrackEffect("tau", "s", ("heading_delay",), lambda path: path.late_heading, late_floor, delay=True),
    )

    def variants(self, est: Estimator) -> Sequence[Variant]:
        require_channels(est, "psi")
        return [one(est, "tau", "s", "heading_delay", scale=0.05, low=0.0, high=5.0)]
