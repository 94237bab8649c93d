"""Check `outliers`."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...datasets.spikes import AROUND, LIMIT, without_spikes_in_time
from ..base import FileCheck
from ..fault import SENSED, Fault, exact

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


class Outliers(FileCheck):
    """Isolated gross errors: share of samples far from the curve through their neighbours."""

    id = "outliers"
    rank = 100
    named = True
    separate_by = "the sensor's own quality flag"

    def find(self, record: Record) -> list[Fault]:
        found = []
        for name in (n for n in SENSED if record.has(n)):
            values = record.continuous(name)
            found += self._isolated(name, values, record.time_s)
        return found

    def _isolated(self, name: str, values: np.ndarray, time: np.ndarray) -> list[Fault]:
        kept, spikes, near = without_spikes_in_time(values, time, _step_if_coarse(values))
        wrong = np.isfinite(values) & ~np.isfinite(kept)
        if near >= max(spikes, 1):  # a heavy tail, of which only what stands apart is no part
            wrong = _apart(values)
            kept, spikes = np.where(wrong, np.nan, values), int(wrong.sum())
        share = spikes / max(int(np.isfinite(values).sum()), 1)
        if not (spikes > MOST and share < FEW):
            return []
        said = f"{spikes} samples of {name} stand more than {LIMIT} standard deviations off their neighbours"
        off, steps = _off(values, wrong)[wrong], np.diff(kept[np.isfinite(kept)])
        clear = float(np.median(off)) > CLEAR * float(np.median(np.abs(steps - np.median(steps))))
        biases = float(np.sum(off**2)) > HEAVY * float(np.nanvar(kept)) * (steps.size + 1)
        return [replace(fault_of(said, name, values, wrong), material=clear, biases=biases)]


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


def fault_of(said: str, name: str, values: np.ndarray, wrong: np.ndarray) -> Fault:
    """Samples (N,) of a channel that are left out."""
    share = float(wrong.sum() / max(int(np.isfinite(values).sum()), 1))
    blanks = tuple((name, k, k + 1) for k in np.flatnonzero(wrong).tolist())
    return Fault(said, (name,), (exact("share", share, "1"),), blanks=blanks)


def _step_if_coarse(values: np.ndarray) -> float:
    """Usual step of a channel whose samples repeat so often that its steps look like errors; 0 of any other."""
    steps = np.abs(np.diff(values[np.isfinite(values)]))
    moving = steps[steps > 0.0]
    return float(np.median(moving)) if moving.size < (1.0 - COARSE) * steps.size and moving.size else 0.0
