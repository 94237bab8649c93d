"""Cause `speed_loss`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...estimation.filters.innovations.settings import Parameter
from ...estimation.filters.innovations.vector import SYMBOLS
from ..searches.profile import ByProfile
from .base import Cause, NotTestable, term

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ...estimation.filters.innovations.segments import Segment
    from ..candidate import Variant


HEADING, YAW_RATE = SYMBOLS.index("psi"), SYMBOLS.index("r")


class SpeedLoss(Cause):
    """Speed lost in the turn, for response models: U = U0 (1 - loss), T_u loss_dot = k r^2 - loss, and every term of
    the yaw equation keeps its prime value at the speed U (damping falls with U, the rudder's moment with U^2)."""

    id = "speed_loss"
    where = "hull"
    unit = "s2/rad2"
    search = ByProfile((10.0, 30.0, 100.0, 300.0))
    extension = "speed_loss"
    separate_by = "record the speed through the water"
    smallest = 0.001

    def stands_beside_numbers(self, is_3dof: bool) -> bool:
        return False

    def variants(self, est: Estimator) -> Sequence[Variant]:
        if "loss_gain" not in est.index:
            raise NotTestable("surge is a state of the model already")
        base = float(est.base[est.index["loss_time"]])
        slots, low, high = ((est.index["loss_time"], 1.0),), 3.0 * est.clock - base, 300.0 * est.clock - base
        time = Parameter("recovery", "s", slots, scale=1.0, low=low, high=high, origin=base)
        gain = replace(term(est, "loss_gain", "s2/rad2", "loss_gain", scale=10.0), low=0.0)
        return [(gain, time)]

    def strength(self, est: Estimator, variant: Variant, values: np.ndarray) -> float:
        """Share of the speed that is lost at the rms yaw rate of the records."""
        rates = est.joined(lambda d: d.measured[:, YAW_RATE] if est.channels[YAW_RATE] else _slope(d))
        return abs(float(values[0])) * float(np.nanmean(rates**2))


def _slope(d: Segment) -> np.ndarray:
    return np.gradient(d.measured[:, HEADING], d.time)
