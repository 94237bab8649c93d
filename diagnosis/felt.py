"""Records as the hull made them: without what causes that are none of the hull's explain."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..datasets.instruments import corrected
from ..estimation.filters.innovations.vector import OUTER
from ..estimation.records.weather import CURRENT, WIND, flow_of
from ..models.instruments import INSTRUMENTS, WAVES

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..estimation.filters.innovations.estimator import Estimator
    from ..estimation.filters.innovations.settings import Setting

FLOWS = {"current": CURRENT, "wind": WIND}


def felt(records: Sequence[Record], est: Estimator, s: Setting, kept: Sequence[str] = ()) -> list[Record]:
    """Records with the errors of rudder and sensors removed that a setting says they have, and with its current and
    wind among what was measured.

    Eq. 17 of docs/mathematics/default-route.md.

    est : holds the same records in the same order.  kept : entries of the vector that stay in the records.
    """
    rows = [s.vectors[est.rows(i)[0]] for i in range(len(records))]
    return [
        _in_flows(corrected(r, _instruments(est, row, r, kept)), est, row) for r, row in zip(records, rows, strict=True)
    ]


def _instruments(est: Estimator, row: np.ndarray, record: Record, kept: Sequence[str]) -> dict[str, float]:
    names = [n for n in OUTER if n in INSTRUMENTS and n not in WAVES and n not in kept]
    found = {n: float(row[est.index[n]]) for n in names if row[est.index[n]] != est.base[est.index[n]]}
    if "rudder_fault_time" in found:
        found["rudder_fault_time"] += float(record.time_s[0])
    return found


def _in_flows(record: Record, est: Estimator, row: np.ndarray) -> Record:
    """The record with current and wind of the setting added to what it measures of them."""
    channels = {}
    for name, columns in FLOWS.items():
        own = np.array([row[est.index[f"{name}_towards_{axis}"]] for axis in ("north", "east")])
        if not own.any():
            continue
        measured = flow_of(record, columns)
        total = np.tile(own, (record.n, 1))
        if measured is not None:
            total += np.column_stack([np.interp(record.time_s, measured[0], v) for v in measured[1].T])
        total *= columns[2]
        channels |= {columns[0]: np.hypot(*total.T), columns[1]: np.arctan2(total[:, 1], total[:, 0])}
    return record.with_channels(**channels)
