"""Causes in the sensors: what a check shows between channels, looked for in a model's residuals as well.

What such an error is, its unit and what tells it from its rivals, stands in `checks.sensors`; here stands which number
of the instruments it moves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from ...checks import sensors
from ...checks.base import Prior
from ..innovations.searches import ByScore
from .base import DEGREE, Cause, Number, require_channels

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..innovations.state import Variant


class AxisMisalignment(Cause):
    """Speed log turned on its mount: recorded surge = u cos a + v sin a, sway = -u sin a + v cos a, a in rad."""

    id, where, unit = "axis_misalignment", "sensor", "rad"
    search, channels = ByScore(), ("u", "v")
    number = Number("angle", ("axis_misalignment",), scale=0.05 * DEGREE, low=-0.8, high=0.8)
    smallest = power_size = 0.1 * DEGREE
    prior = Prior(5.0 * DEGREE)
    separate_by = "positions on a straight course: the track's direction against heading and log"


class HeadingDelay(sensors.HeadingDelayError, Cause):
    search, channels = ByScore((0.1, 0.4, 1.0, 2.0)), ("psi",)
    number = Number("tau", ("heading_delay",), scale=0.05, low=0.0, high=5.0)
    smallest, power_size = 0.05, 0.2
    prior = Prior(0.3)


class HeadingOffset(sensors.HeadingOffsetError, Cause):
    search, channels = ByScore(), ("psi", "x", "y")
    number = Number("b", ("heading_bias",), scale=0.05 * DEGREE)
    smallest = power_size = 0.1 * DEGREE


class SpeedScale(sensors.SpeedScaleError, Cause):
    search, channels = ByScore(), ("u", "v")
    number = Number("s", ("surge_scale", "sway_scale"), scale=0.002, low=-0.8, high=2.0)
    smallest, power_size = 0.005, 0.002
    prior = Prior(0.2, needs=("u",), others=(("surge_scale",),))


class SwayOffset(sensors.SwayOffsetError, Cause):
    search, channels = ByScore(), ("v",)
    number = Number("b", ("sway_bias",), scale=0.005)
    smallest = power_size = 0.005
    prior = Prior(0.05)


class VelocityDelay(sensors.VelocityDelayError, Cause):
    search = ByScore((0.3, 1.0, 2.0, 3.5))
    smallest, power_size = 0.05, 0.2
    prior = Prior(0.3, entries=("surge_delay", "sway_delay"), needs=("u", "v"))

    def variants(self, est: Estimator) -> Sequence[Variant]:
        require_channels(est, "u", "v")
        late = (Number("tau", effect.instruments, scale=0.05, low=0.0, high=8.0) for effect in self.track)
        return [number.variant(est, self.unit) for number in late]

    def details(self, est: Estimator, variant: Variant) -> Mapping[str, str]:
        return {"late": "surge, sway, yaw rate and heading" if len(variant[0].slots) > 2 else "surge and sway"}


class YawRateBias(sensors.YawRateBiasError, Cause):
    search, channels = ByScore(), ("r",)
    number = Number("b", ("yaw_rate_bias",), scale=0.002 * DEGREE)
    power_size = 0.003 * DEGREE
    prior = Prior(0.05)


class YawRateScale(sensors.YawRateScaleError, Cause):
    search, channels = ByScore(), ("r",)
    number = Number("s", ("yaw_rate_scale",), scale=0.005, low=-0.8, high=2.0)
    smallest, power_size = 0.005, 0.01
    prior = Prior(0.2)
