"""Cause `outliers`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..result import Finding, Size
from ._records import RecordCause
from .base import NORMAL_90

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ...datasets.record import Record
    from ...estimation.filters.innovations.estimator import Estimator
    from ._records import RecordFault

MOST = 2
"""Gross errors that sensors' noise may give."""
LIMIT = 6.5


class Outliers(RecordCause):
    """Isolated gross errors: share of samples far from the curve through their neighbours."""

    id = "outliers"
    rank = 4
    separate_by = "the sensor's own quality flag"

    def find(self, records: Sequence[Record], starboard: float) -> tuple[list[RecordFault], list[Record]]:
        return [], list(records)  # they are gaps of the filter's segments: see `findings`

    def findings(self, est: Estimator) -> list[Finding]:
        """Outliers if there are more than sensors' noise gives, and more than near misses (a heavy tail)."""
        spikes, count = sum(d.spikes for d in est.segments), est.n_values
        if spikes <= MOST or spikes <= sum(d.near_spikes for d in est.segments):
            return []
        share = spikes / max(count + spikes, 1)
        half = NORMAL_90 * float(np.sqrt(share * (1.0 - share) / max(count, 1)))
        size = Size("share", share, max(share - half, 0.0), share + half, "1")
        said = f"{spikes} of {count + spikes} samples stand more than {LIMIT} standard deviations off their neighbours"
        return [Finding(self.id, (), "kinematics", float(spikes), 1e-6, (size,), evidence=said)]
