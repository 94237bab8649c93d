"""Cause `velocity_delay`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from ...checks.sensors import velocity_delay
from ..searches.score import ByScore
from .base import Cause, Number, require_channels

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..candidate import Variant


class VelocityDelay(velocity_delay.VelocityDelay, Cause):
    search = ByScore((0.3, 1.0, 2.0, 3.5))
    smallest = 0.05
    power_size = 0.2

    def variants(self, est: Estimator) -> Sequence[Variant]:
        require_channels(est, "u", "v")
        late = (Number("tau", effect.instruments, scale=0.05, low=0.0, high=8.0) for effect in self.track)
        return [number.variant(est, self.unit) for number in late]

    def details(self, est: Estimator, variant: Variant) -> Mapping[str, str]:
        return {"late": "surge, sway, yaw rate and heading" if len(variant[0].slots) > 2 else "surge and sway"}
