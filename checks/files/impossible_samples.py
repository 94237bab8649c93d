"""Check `impossible_samples`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..base import FileCheck
from ..fault import SENSED, Fault
from .outliers import fault_of

if TYPE_CHECKING:
    from ...datasets.record import Record

HUGE, COMMON = 1e4, 0.99
"""Times the size that a share of the samples does not exceed, from which a sample cannot be."""


class ImpossibleSamples(FileCheck):
    """Single samples thousands of times as large as all others: a sentinel for a missing value, or a broken row."""

    id = "impossible_samples"
    rank = -10
    named = True
    separate_by = "the sensor's own quality flag"

    def find(self, record: Record) -> list[Fault]:
        found = []
        for name in (n for n in SENSED if record.has(n)):
            values = record.column(name)
            huge = _huge(values)
            if huge.any():
                said = f"{huge.sum()} samples of {name} are more than {HUGE:g} times as large as the others"
                found.append(fault_of(said, name, values, huge))
        return found


def _huge(values: np.ndarray) -> np.ndarray:
    """(N,) samples that cannot be."""
    size = np.abs(values[np.isfinite(values)])
    common = float(np.quantile(size, COMMON, method="lower")) if size.size else 0.0
    return np.abs(values) > HUGE * common if common > 0.0 else np.zeros(values.size, bool)
