"""Check `rudder_sign`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...datasets.columns import RUDDERS
from ...models.linear_algebra import finite
from ._base import ColumnCheck, ColumnFault

if TYPE_CHECKING:
    from ...datasets.record import Record

CLEAR = 6.0
"""Standard deviations by which the rudder must act to the other side."""


class RudderSign(ColumnCheck):
    """The rudder column's sign contradicts the vessel: b in r_dot = a r + b delta + c has the other sign."""

    id = "rudder_sign"
    rank = 58
    joint = True
    separate_by = "one rudder order and the side to which the ship turns"

    def find(self, records: Sequence[Record], starboard: float) -> tuple[list[ColumnFault], list[Record]]:
        z = starboard * rudder_response(records)
        if not z < -CLEAR:
            return [], list(records)
        said = (
            f"a rudder angle the record calls positive turns the ship to the other side than the model's ({-z:.0f} sd)"
        )
        return [ColumnFault(self, {}, said, z * z, {"rudder_reversed": 1.0})], [_turned(r) for r in records]


def rudder_response(records: Sequence[Record]) -> float:
    """b in r_dot = a r + b delta + c, starboard positive, in its standard deviations; 0 without usable records."""
    rows, target = [], []
    for record in records:
        rate = _rate_column(record)
        if rate is None and not record.has("heading_rad"):
            continue
        time = record.time_s
        if rate is None:
            rate = np.gradient(record.heading_unwrapped(), time)
        rudder = record.rudder()
        known = np.isfinite(rate) & np.isfinite(rudder)
        if known.sum() < 20 or np.ptp(rudder[known]) == 0.0:
            continue
        step = max(1, round(time[-1] / 200.0 / np.median(np.diff(time))))
        n = time.size // step
        fill = [
            np.interp(time, time[known], a[known])[: n * step].reshape(n, step).mean(axis=1) for a in (rate, rudder)
        ]
        middle = time[: n * step].reshape(n, step).mean(axis=1)
        slope = np.diff(fill[0]) / np.diff(middle)
        mean = [0.5 * (a[1:] + a[:-1]) for a in fill]
        rows.append(np.column_stack([mean[0], mean[1], np.ones(n - 1)]))
        target.append(slope)
    if not rows:
        return 0.0
    phi, y = np.vstack(rows), np.concatenate(target)
    b, *_ = np.linalg.lstsq(finite(phi), y, rcond=None)
    error = y - phi @ b
    inverse = np.linalg.pinv(finite(phi.T @ phi))
    sd = float(np.sqrt(max(inverse[1, 1], 0.0) * np.sum(error**2) / max(y.size - 3, 1)))
    return float(b[1] / max(sd, 1e-300))


def _rate_column(record: Record) -> np.ndarray | None:
    return record.column("yaw_rate_rad_s") if record.has("yaw_rate_rad_s") else None


def _turned(record: Record) -> Record:
    return record.with_channels(**{n: -record.column(n) for n in RUDDERS if record.has(n)})
