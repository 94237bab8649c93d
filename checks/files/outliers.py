"""Checks of samples that are no measurements: gross errors, impossible values, and what a sensor cuts off."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...datasets.signals import sensor_sd
from ...datasets.spikes import AROUND, LIMIT, without_spikes_in_time
from ..base import ChannelCheck, Fault, FileCheck, exact, without
from ..integrity.runs import runs_of

if TYPE_CHECKING:
    from ...datasets.record import Record

FEW = 0.05
"""Share of the samples above which they are no isolated errors any more."""
COARSE = 0.05
"""Share of repeated samples from which a channel's noise is at least its usual step."""
MOST = 2
"""Gross errors of a channel that sensors' noise may give."""
HEAVY = 0.02
"""Share of a channel's variance that gross errors must have to bias a fit that does not leave them out."""
APART = 3.0
"""Times the largest step of all other samples from which on gross errors stand apart from a heavy tail of the noise."""
CLEAR = 1.5
"""Times its usual step that gross errors of a channel depart by to matter: corners of a smooth motion do not."""


class Outliers(ChannelCheck):
    """Isolated gross errors: share of samples far from the curve through their neighbours."""

    id, rank = "outliers", 100
    is_cause = True
    separate_by = "the sensor's own quality flag"

    def of_channel(self, record: Record, name: str) -> Iterator[Fault]:
        values = record.continuous(name)
        kept, spikes, near = without_spikes_in_time(values, record.time_s, _step_if_coarse(values))
        wrong = np.isfinite(values) & ~np.isfinite(kept)
        if near >= max(spikes, 1):  # a heavy tail, of which only what stands apart is no part
            wrong = _apart(values)
            kept, spikes = np.where(wrong, np.nan, values), int(wrong.sum())
        share = spikes / max(int(np.isfinite(values).sum()), 1)
        if not (spikes > MOST and share < FEW):
            return
        said = f"{spikes} samples of {name} stand more than {LIMIT} standard deviations off their neighbours"
        off, steps = _off(values, wrong)[wrong], np.diff(kept[np.isfinite(kept)])
        clear = float(np.median(off)) > CLEAR * float(np.median(np.abs(steps - np.median(steps))))
        biases = float(np.sum(off**2)) > HEAVY * float(np.nanvar(kept)) * (steps.size + 1)
        yield replace(_left_out(said, record, name, wrong), material=clear, biases=biases)


def _apart(values: np.ndarray) -> np.ndarray:
    """(T,) samples that are further from their neighbours than APART times the largest step of all others: of those
    that stand more than LIMIT robust standard deviations off the median of AROUND samples about them."""
    from scipy.ndimage import median_filter

    known = np.flatnonzero(np.isfinite(values))
    off = np.abs(values[known] - median_filter(values[known], AROUND, mode="mirror"))
    wrong = np.zeros(values.size, bool)
    wrong[known] = off > LIMIT * 1.4826 * float(np.median(off))
    while wrong.any():
        rest = values[np.isfinite(values) & ~wrong]
        kept = wrong & (_off(values, wrong) > APART * float(np.max(np.abs(np.diff(rest)), initial=0.0)))
        if np.array_equal(kept, wrong):
            break
        wrong = kept
    return wrong


def _off(values: np.ndarray, wrong: np.ndarray) -> np.ndarray:
    """Distances (T,) of samples from the straight line between those beside that are not wrong."""
    good = np.flatnonzero(np.isfinite(values) & ~wrong)
    return (
        np.abs(values - np.interp(np.arange(values.size), good, values[good])) if good.size else np.zeros(values.size)
    )


def _left_out(said: str, record: Record, name: str, wrong: np.ndarray) -> Fault:
    """Samples (N,) of a column that are left out."""
    share = float(wrong.sum() / max(int(np.isfinite(record.column(name)).sum()), 1))
    return Fault(said, (name,), (exact("share", share, "1"),), columns=without(record, name, wrong))


def _step_if_coarse(values: np.ndarray) -> float:
    """Usual step of a channel whose samples repeat so often that its steps look like errors; 0 of any other."""
    steps = np.abs(np.diff(values[np.isfinite(values)]))
    moving = steps[steps > 0.0]
    return float(np.median(moving)) if moving.size < (1.0 - COARSE) * steps.size and moving.size else 0.0


HUGE, COMMON = 1e4, 0.99
"""Times the size that a share of the samples does not exceed, from which a sample cannot be."""


class ImpossibleSamples(ChannelCheck):
    """Single samples thousands of times as large as all others: a sentinel for a missing value, or a broken row."""

    id, rank = "impossible_samples", -10
    is_cause = True
    separate_by = "the sensor's own quality flag"

    def of_channel(self, record: Record, name: str) -> Iterator[Fault]:
        values = record.column(name)
        size = np.abs(values[np.isfinite(values)])
        common = float(np.quantile(size, COMMON, method="lower")) if size.size else 0.0
        huge = np.abs(values) > HUGE * common
        if common > 0.0 and huge.any():
            said = f"{huge.sum()} samples of {name} are more than {HUGE:g} times as large as the others"
            yield _left_out(said, record, name, huge)


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

    id, where, rank, unit = "yaw_rate_saturation", "sensor", 10, "rad/s"
    is_cause = True
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
        fault = _left_out(said, record, CHANNEL, near)
        return [replace(fault, sizes=(*fault.sizes, exact("limit", limit, "rad/s")))]
