"""Check `channel_swap`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...models.instruments import SENSORS, SWAPS
from ..integrity.ratios import AGREE, TURN, heading_ratio
from ..integrity.readings import BETTER, better_reading, exchanged, rate_error, read_as
from ._base import ColumnCheck, ColumnFault

if TYPE_CHECKING:
    from ...datasets.record import Record

RATES = ("yaw_rate_rad_s", "roll_rate_rad_s")
STEERED = ("heading_rad", "rudder_rad")
UNEXPLAINED = 0.3
"""Share of the heading's changes that the yaw-rate column must leave unexplained, and a column in its place may not."""


class ChannelSwap(ColumnCheck):
    """Two columns exchanged or mislabelled (`details` names them): yaw rate and roll rate against the heading, heading
    and yaw rate, rudder and heading against the yaw rate, two velocities or two positions against each other."""

    id = "channel_swap"
    rank = 55
    separate_by = "the logger's list of channels"

    def find(self, records: Sequence[Record], starboard: float) -> tuple[list[ColumnFault], list[Record]]:
        faults, fixed = self._of_rates(list(records))
        for look in (self._of_turn, self._of_rudder):
            found, fixed = look(fixed)
            faults += found
        better = better_reading(fixed)
        if better is not None and better.reading.check == self.id:
            said = better.evidence("with the columns exchanged")
            faults.append(self._fault(better.reading.columns, said, better.statistic))
            fixed = read_as(fixed, better.reading)
        return faults, fixed

    def _of_rates(self, records: list[Record]) -> tuple[list[ColumnFault], list[Record]]:
        """The rate channel that goes with the heading: yaw rate, or what is called roll rate."""
        if not all(r.has("heading_rad", *RATES) for r in records):
            return [], records
        own, other = (float(np.mean([rate_error(r, name) for r in records])) for name in RATES)
        if not (other < BETTER * own and own > UNEXPLAINED):
            return [], records
        said = (
            f"the heading moves with the roll-rate column (unexplained share {other:.3f}), "
            f"not with the yaw-rate column ({own:.3f})"
        )
        swap = exchanged(*RATES)
        return [self._fault(RATES, said, (own / max(other, 1e-6)) ** 2)], [swap(r) for r in records]

    def _of_turn(self, records: list[Record]) -> tuple[list[ColumnFault], list[Record]]:
        """Records whose yaw-rate column changes as the integral of the heading column."""
        swap = exchanged(*TURN)
        bad = [r.has(*TURN) and _goes_with(swap(r)) and not _goes_with(r) for r in records]
        if not any(bad):
            return [], records
        said = f"in {sum(bad)} of {len(bad)} records yaw_rate_rad_s changes as the integral of heading_rad does"
        fault = ColumnFault(self, {"channels": list(TURN)}, said, BETTER**-2, {})
        return [fault], [swap(r) if is_bad else r for r, is_bad in zip(records, bad, strict=True)]

    def _of_rudder(self, records: list[Record]) -> tuple[list[ColumnFault], list[Record]]:
        """Records whose yaw rate goes with the rudder column, not with the heading's.

        The rudder is an input, so that the exchange is none of a model's instruments: it is corrected in the records.
        """
        swap = exchanged(*STEERED)
        errors = [_with_rudder(r) for r in records]
        bad = [own > UNEXPLAINED > other and other < BETTER * own for own, other in errors]
        if not any(bad):
            return [], records
        own, other = np.mean([pair for pair, is_bad in zip(errors, bad, strict=True) if is_bad], axis=0)
        said = (
            f"in {sum(bad)} of {len(bad)} records the yaw rate is that of the rudder column (unexplained share "
            f"{other:.3f}), not that of the heading column ({own:.3f})"
        )
        fault = ColumnFault(self, {"channels": list(STEERED)}, said, float((own / max(other, 1e-6)) ** 2), {})
        return [fault], [swap(r) if is_bad else r for r, is_bad in zip(records, bad, strict=True)]

    def _fault(self, columns: Sequence[str], evidence: str, statistic: float) -> ColumnFault:
        names = {column: name for name, (column, _) in SENSORS.items()}
        pair = {names[column] for column in columns}
        switch = next(key for key, swap in SWAPS.items() if {names[c] for c in swap} == pair)
        return ColumnFault(self, {"channels": list(columns)}, evidence, float(statistic), {switch: 1.0})


def _goes_with(record: Record) -> bool:
    """Whether the heading goes with the yaw rate, in one unit."""
    ratio = heading_ratio(record)
    return ratio is not None and ratio.correlation > AGREE and abs(ratio.slope - 1.0) < UNEXPLAINED


def _with_rudder(record: Record) -> tuple[float, float]:
    """Shares of the heading column's and of the rudder column's changes that the yaw rate leaves unexplained; nan where
    a column is missing."""
    if not record.has(*STEERED, "yaw_rate_rad_s"):
        return float("nan"), float("nan")
    return rate_error(record, "yaw_rate_rad_s"), rate_error(exchanged(*STEERED)(record), "yaw_rate_rad_s")
