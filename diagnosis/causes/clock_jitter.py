"""Cause `clock_jitter`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...checks.result import NORMAL_90, Size
from ..innovations.searches import ByScan
from ..innovations.tests import rate_statistic
from .base import Cause

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ...estimation.filters.innovations.settings import Setting
    from ..innovations.state import State, Variant

SHARES = (0.03, 0.1, 0.3)
"""Errors that are scanned first, as shares of the sampling step."""
LARGEST_SHARE = 0.5
"""Largest error, as a share of the sampling step: samples keep their order."""
ROUGHER = 1.3
"""Factor on the error that the roughness of the samples allows: roughness and rates of change are estimates."""
GATE = 2.5
"""Standard score of the squared innovations growing with the channels' rates of change, below which none is scanned."""


def errors(state: State) -> list[float]:
    """Errors (s) of the sampling instants to scan."""
    if rate_statistic(state.est, state.now) < GATE:
        return []
    return [share * state.est.segments[0].step_s for share in SHARES]


def largest(est: Estimator) -> float:
    """Largest error of the clock, s: it makes a channel rough by the error times the channel's rate of change.

    The third differences of the samples hold that roughness and more (the sensor's noise, bends of the motion).
    """
    most = LARGEST_SHARE * max(d.step_s for d in est.segments)
    for c in np.flatnonzero(est.channels).tolist():
        rough, fast, count = 0.0, 0.0, 0
        for d in est.segments:
            y = d.measured[:, c]
            third, rate = np.diff(y, 3) ** 2, np.gradient(y, d.time)[1:-2] ** 2
            known = np.isfinite(third) & np.isfinite(rate)
            rough, fast, count = rough + third[known].sum() / 20.0, fast + rate[known].sum(), count + int(known.sum())
        if count > 50 and fast > 0.0:
            most = min(most, ROUGHER * float(np.sqrt(rough / fast)))
    return most


class ClockJitter(Cause):
    """Samples taken at t + error while the time column says t: error of standard deviation sd (s), independent from
    sample to sample; channels are noisier where they change fast."""

    id, where, unit = "clock_jitter", "sampling", "s"
    search = ByScan("clock_jitter", errors, largest)
    separate_by = "time stamps taken by the instruments"
    beside_numbers = False

    def sizes(
        self, est: Estimator, s: Setting, variant: Variant, covariance: np.ndarray, rng: np.random.Generator
    ) -> tuple[Size, ...]:
        """The clock's error with the interval that the likelihood in its logarithm gives.

        One sample's channels share its error: spread of the samples' scores over curvature.
        """
        value, h = float(s.vectors[0, est.index["clock_jitter"]]), 0.05
        ll = []
        for factor in (np.exp(-h), 1.0, np.exp(h)):
            now = est.evaluate(est.with_entries(s, {"clock_jitter": value * factor}))
            ll.append(-np.sum(now.log_s + 0.5 * now.e**2, axis=1))
        curvature = max(-float(np.sum(ll[0] - 2.0 * ll[1] + ll[2])) / h**2, 1.0)
        half = NORMAL_90 * float(np.linalg.norm((ll[2] - ll[0]) / (2.0 * h))) / curvature
        return (Size("sd", value, value * float(np.exp(-half)), value * float(np.exp(half)), "s"),)
