"""Isolated gross errors of each channel."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...datasets.spikes import LIMIT, without_spikes
from ..fault import SENSED, Fault, exact

if TYPE_CHECKING:
    from ...datasets.record import Record

FEW = 0.05
"""Share of the samples above which they are no isolated errors any more."""
COARSE = 0.05
"""Share of repeated samples from which a channel is not judged."""
MOST = 2
"""Gross errors of a channel that sensors' noise may give."""


def without_outliers(record: Record) -> tuple[list[Fault], Record]:
    """What there is of gross errors by channel, and the record with them as gaps."""
    faults, channels = [], {}
    for name in (n for n in SENSED if record.has(n)):
        values = record.heading_unwrapped() if name == "heading_rad" else record.column(name)
        if _is_coarse(values):
            continue
        kept, spikes, near = without_spikes(values)
        share = spikes / max(int(np.isfinite(values).sum()), 1)
        if spikes > MOST and spikes > near and share < FEW:
            channels[name] = np.where(np.isfinite(kept), record.column(name), np.nan)
            said = f"{spikes} samples of {name} stand more than {LIMIT} standard deviations off their neighbours"
            faults.append(Fault(said, (name,), (exact("share", share, "1"),)))
    return faults, record.with_channels(**channels)


def _is_coarse(values: np.ndarray) -> bool:
    """Whether samples repeat so often that the steps of a coarse channel look like errors."""
    steps = np.diff(values[np.isfinite(values)])
    return bool(steps.size == 0 or np.mean(steps == 0.0) > COARSE)
