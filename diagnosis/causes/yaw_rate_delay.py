"""Cause `yaw_rate_delay`."""

from __future__ import annotations

from ..kinematics.series import TurnEffect, late_floor
from ._check import CheckCause


class YawRateDelay(CheckCause):
    """Late (or smoothed) yaw rate against the heading: recorded(t) = true(t - tau), tau in s."""

    id = "yaw_rate_delay"
    where = "sensor"
    unit = "s"
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
