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
"""Share of repeated samples from which a channel is not judged."""
MOST = 2
"""Gross errors of a channel that sensors' noise may give."""
CLEAR = 1.5
"""Times its usual step that gross errors of a channel depart by to matter: corners of a smooth motion do not."""


class Outliers(FileCheck):
    """Isolated gross errors: share of samples far from the curve through their neighbours."""

    id = "outliers"
    rank = 100
    named = True
    single = True
    separate_by = "the sensor's own quality flag"

    def find(self, record: Record) -> list[Fault]:
        found = []
        for name in (n for n in SENSED if record.has(n)):
            values = record.heading_unwrapped() if name == "heading_rad" else record.column(name)
            found += self._isolated(name, values, record.time_s)
        return found

    def _isolated(self, name: str, values: np.ndarray, time: np.ndarray) -> list[Fault]:
        if _is_coarse(values):
            return []
        kept, spikes, near = without_spikes_in_time(values, time)
        share = spikes / max(int(np.isfinite(values).sum()), 1)
        if not (spikes > MOST and spikes > near and share < FEW):
            return []
        said = f"{spikes} samples of {name} stand more than {LIMIT} standard deviations off their neighbours"
        wrong = np.isfinite(values) & ~np.isfinite(kept)
        good = np.flatnonzero(np.isfinite(kept))
        off = np.abs(values[wrong] - np.interp(np.flatnonzero(wrong), good, kept[good]))
        steps = np.diff(kept[good])
        clear = float(np.median(off)) > CLEAR * float(np.median(np.abs(steps - np.median(steps))))
        return [replace(fault_of(said, name, values, wrong), material=clear)]


def fault_of(said: str, name: str, values: np.ndarray, wrong: np.ndarray) -> Fault:
    """Samples (N,) of a channel that are left out."""
    share = float(wrong.sum() / max(int(np.isfinite(values).sum()), 1))
    blanks = tuple((name, k, k + 1) for k in np.flatnonzero(wrong).tolist())
    return Fault(said, (name,), (exact("share", share, "1"),), blanks=blanks)


def _is_coarse(values: np.ndarray) -> bool:
    """Whether samples repeat so often that the steps of a coarse channel look like errors."""
    steps = np.diff(values[np.isfinite(values)])
    return bool(steps.size == 0 or np.mean(steps == 0.0) > COARSE)
