"""Time stamps: missing rows, late stamps, irregular steps."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

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
