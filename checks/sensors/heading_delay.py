"""Sensor error `heading_delay`."""

from __future__ import annotations

from ..base import SensorError
from ..comparison.series import TrackEffect, TurnEffect, late_floor


class HeadingDelay(SensorError):
    """Late heading: recorded(t) = true(t - tau), tau in s."""

    id = "heading_delay"
    unit = "s"
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
