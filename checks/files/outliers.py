"""Check `outliers`."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...datasets.spikes import LIMIT, without_spikes_in_time
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
            values = record.heading_unwrapped() if name == "heading_rad" else record.column(name)
            found += self._isolated(name, values, record.time_s)
        return found

    def _isolated(self, name: str, values: np.ndarray, time: np.ndarray) -> list[Fault]:
        kept, spikes, near = without_spikes_in_time(values, time, _step_if_coarse(values))
        share = spikes / max(int(np.isfinite(values).sum()), 1)
        if not (spikes > MOST and spikes > near and share < FEW):
            return []
        said = f"{spikes} samples of {name} stand more than {LIMIT} standard deviations off their neighbours"
        wrong = np.isfinite(values) & ~np.isfinite(kept)
        good = np.flatnonzero(np.isfinite(kept))
        off = np.abs(values[wrong] - np.interp(np.flatnonzero(wrong), good, kept[good]))
        steps = np.diff(kept[good])
        clear = float(np.median(off)) > CLEAR * float(np.median(np.abs(steps - np.median(steps))))
        biases = float(np.sum(off**2)) > HEAVY * float(np.nanvar(kept)) * good.size
        return [replace(fault_of(said, name, values, wrong), material=clear, biases=biases)]


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
