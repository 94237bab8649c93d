"""Checks of a record's time stamps: rows that are missing, stamps that come late or irregularly."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..base import Fault, FileCheck, exact

if TYPE_CHECKING:
    from ...datasets.record import Record

LATE, UNEVEN, MISSING = 0.2, 0.05, 1.5
"""Shares of the median step: from which one stamp is late, steps are uneven, rows are missing."""


class Stamps(NamedTuple):
    """Median step s, rows missing and in how many gaps, longest gap s, late stamps, share of other uneven steps,
    and the standard deviation of the uneven steps, s."""

    step_s: float
    missing: int
    gaps: int
    longest_s: float
    late: np.ndarray
    uneven: float
    spread_s: float


def stamps(time: np.ndarray) -> Stamps:
    """What the times (N,) of a record show, N >= 3."""
    steps = np.diff(time)
    dt = float(np.median(steps))
    gap = steps > MISSING * dt
    off = np.abs(steps - dt)
    pair = (off[:-1] > LATE * dt) & (np.abs(steps[:-1] + steps[1:] - 2.0 * dt) < 0.1 * dt)
    late = np.flatnonzero(pair) + 1
    of_pairs = np.zeros(steps.size, bool)
    of_pairs[late - 1] = of_pairs[late] = True
    uneven = (off > UNEVEN * dt) & ~of_pairs & ~gap
    rows = np.maximum(np.round(steps[gap & ~of_pairs] / dt) - 1.0, 1.0)
    return Stamps(
        dt,
        int(rows.sum()),
        rows.size,
        float(steps[gap].max(initial=0.0)),
        late,
        float(np.mean(uneven)),
        float(np.std(steps[~gap])),
    )


UNEVEN_SHARE = 0.02
MISSING_SHARE = 0.02
TOO_MANY, TOO_LONG = 0.1, 0.2
"""Share of the rows that may be missing, and share of the record that one gap may take, for a motion to be followed."""
LONG = 20
"""Steps below which no gap is too long."""


class TimeStamps(FileCheck):
    """Time stamps that repeat, go back, come late or irregularly, or rows that are missing."""

    id, rank, unit = "time_stamps", 10, "s"
    ends = True
    separate_by = "the logger's own sample counter"

    def find(self, record: Record) -> list[Fault]:
        if record.n < 3:
            return []
        s, faults = stamps(record.time_s), []
        if s.missing:
            said = f"{s.missing} rows are missing in {s.gaps} gaps of up to {s.longest_s:.4g} s (step {s.step_s:.4g} s)"
            much = s.missing > MISSING_SHARE * record.n
            share = s.missing / (record.n + s.missing)
            torn = s.longest_s > max(TOO_LONG * float(np.ptp(record.time_s)), LONG * s.step_s)
            size = (exact("longest gap", s.longest_s, "s"),)
            faults.append(Fault(said, ("time_s",), size, much or torn, standing=share > TOO_MANY or torn))
        if s.late.size:
            at = ", ".join(f"{record.time_s[k]:.6g}" for k in s.late[:3])
            said = f"{s.late.size} stamps come early or late between their neighbours, at {at} s"
            faults.append(Fault(said, ("time_s",)))
        if s.uneven > UNEVEN_SHARE:
            said = f"{100.0 * s.uneven:.0f} % of the steps differ from {s.step_s:.4g} s by more than 5 %"
            faults.append(Fault(said, ("time_s",), (exact("standard deviation of the step", s.spread_s, "s"),)))
        return faults
