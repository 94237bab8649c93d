"""Sensor error `yaw_rate_delay`."""

from __future__ import annotations

from ..base import SensorError
from ..comparison.series import TurnEffect, late_floor


class YawRateDelay(SensorError):
    """Late (or smoothed) yaw rate against the heading: recorded(t) = true(t - tau), tau in s."""

    id = "yaw_rate_delay"
    unit = "s"
    named = True
    separate_by = "yaw rate and heading of instruments with known time stamps"
    turn = (
        TurnEffect(
            "tau",
            "s",
            ("yaw_rate_delay",),
            lambda turn: turn.quiet_rate[None] - turn.quiet_rate[:1, None],
            late_floor,
            delay=True,
        ),
    )
