"""Check `outliers`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..fault import SENSED
from ._base import ColumnCheck, ColumnFault

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ...datasets.record import Record

HUGE, COMMON = 1e4, 0.99
"""Times the size that a share of the samples does not exceed, from which a sample cannot be."""
STATISTIC = 100.0


class Outliers(ColumnCheck):
    """Isolated gross errors: share of samples far from the curve through their neighbours."""

    id = "outliers"
    rank = -1
    separate_by = "the sensor's own quality flag"

    def find(self, records: Sequence[Record], starboard: float) -> tuple[list[ColumnFault], list[Record]]:
        """Samples that cannot be become gaps here; the others are gaps of a filter's segments."""
        cleaned = [_without_huge(record) for record in records]
        count = sum(number for _, number in cleaned)
        if not count:
            return [], list(records)
        said = f"{count} sample{'s' if count > 1 else ''} more than {HUGE:g} times as large as the others are left out"
        return [ColumnFault(self, {"samples": count}, said, STATISTIC, {})], [record for record, _ in cleaned]


def _without_huge(record: Record) -> tuple[Record, int]:
    """The record with samples that cannot be as gaps, and their number."""
    channels, count = {}, 0
    for name in (n for n in SENSED if record.has(n)):
        values = record.column(name)
        size = np.abs(values[np.isfinite(values)])
        common = float(np.quantile(size, COMMON, method="lower")) if size.size else 0.0
        huge = np.abs(values) > HUGE * common
        if common > 0.0 and huge.any():
            channels[name] = np.where(huge, np.nan, values)
            count += int(huge.sum())
    return (record.with_channels(**channels), count) if count else (record, 0)
