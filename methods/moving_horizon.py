"""Moving-horizon estimation of states and coefficients."""

from __future__ import annotations

from ..estimation.likelihood.moving_horizon import fit_moving_horizon
from .base import Method


class MovingHorizon(Method):
    """x"""

    name = "moving-horizon"
    title = "moving-horizon estimation of states and coefficients"
    order_matters = True

    def __init__(self, horizon=60, stretches=3, forgetting=1.0, passes=3, inflation=5.0):
        self.horizon, self.stretches, self.forgetting, self.passes, self.inflation = horizon, stretches, forgetting, passes, inflation

    def estimate(self, records, model):
        return fit_moving_horizon(records, model, self.horizon, self.stretches, self.forgetting, self.passes, self.inflation)
