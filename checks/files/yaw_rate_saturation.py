"""Check `yaw_rate_saturation`."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...datasets.signals import sensor_sd
from ..base import FileCheck
from ..fault import Fault, exact
from ..integrity.runs import runs_of
from .outliers import fault_of

if TYPE_CHECKING:
    from ...datasets.record import Record

CHANNEL = "yaw_rate_rad_s"
FEWEST = 10
"""Samples at the largest value from which a sensor may have been cut off."""
EQUAL = 1e-9
BESIDE = 5
"""Samples beside those that are cut off that are left out too: of noise about the limit only one side remains."""
FASTER, CERTAIN = 1.01, 5.0
"""Times the largest yaw rate, and standard deviations beyond it, by which the heading must turn meanwhile."""


class YawRateSaturation(FileCheck):
    """The yaw-rate sensor cuts off what exceeds its range: r_m = min(max(r, -limit), limit), while the heading turns
    faster."""

    id = "yaw_rate_saturation"
    where = "sensor"
    rank = 10
    unit = "rad/s"
    named = True
    beyond = ("yaw_rate", "limit")
    separate_by = "the sensor's data sheet: its range"

    def find(self, record: Record) -> list[Fault]:
        if not record.has(CHANNEL) or not record.has("heading_rad"):
            return []
        rate, heading, time = record.column(CHANNEL), record.heading_unwrapped(), record.time_s
        limit = float(np.nanmax(np.abs(rate), initial=0.0))
        cut = np.abs(rate) >= limit * (1.0 - EQUAL)
        runs = [r for r in runs_of(rate) if cut[r.start]]
        if cut.sum() < FEWEST or not runs or not limit > 0.0:
            return []
        first, last = np.array([(r.start, r.stop - 1) for r in runs]).T
        turned, lasted = (heading[last] - heading[first]) * np.sign(rate[first]), time[last] - time[first]
        known = np.isfinite(turned)
        turning, noise = turned[known].sum(), sensor_sd(heading) * np.sqrt(2.0 * known.sum())
        if not turning - FASTER * limit * lasted[known].sum() > CERTAIN * noise:
            return []
        mean = turning / lasted[known].sum()
        said = (
            f"{CHANNEL} stands at its largest value, {np.rad2deg(limit):.4g} deg/s, in {int(cut.sum())} samples, while "
            f"the heading turns by {np.rad2deg(mean):.4g} deg/s in the mean: the sensor's range ends there"
        )
        near = np.convolve(cut, np.ones(2 * BESIDE + 1), "same") > 0.0
        fault = fault_of(said, CHANNEL, rate, near)
        return [replace(fault, sizes=(*fault.sizes, exact("limit", limit, "rad/s")))]
