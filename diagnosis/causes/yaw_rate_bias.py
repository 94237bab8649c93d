"""Cause `yaw_rate_bias`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...checks.sensors import yaw_rate_bias
from ..searches.score import ByScore
from .base import DEGREE, Cause, one, require_channels

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..candidate import Variant


class YawRateBias(yaw_rate_bias.YawRateBias, Cause):
    search = ByScore()
    power_size = 0.003 * DEGREE

    def variants(self, est: Estimator) -> Sequence[Variant]:
        require_channels(est, "r")
        return [one(est, "b", "rad/s", "yaw_rate_bias", scale=0.002 * DEGREE)]
