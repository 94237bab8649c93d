"""Where a record is no longer one run: long gaps of rows or rudder, and splices of positions or heading."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from ...datasets.record import Record
from ...models.errors import CannotFit
from ...models.model import Model
from .series import Series, series_of

LONG_GAP_STEPS, LONG_GAP_S = 5.0, 4.0
"""A gap in the rows or in the rudder longer than both, in median steps and in seconds (on a 160 m ship), cuts a
record: nothing is known of what the rudder did there."""
SHORTEST = 16
"""Samples of the shortest stretch that is kept."""
JUMP, BESIDE, USUAL = 12.0, 5, 0.99
"""Times the channel's usual rate of change (the rate that a share USUAL of the samples stays below) that is a splice,
where the level stays moved over so many samples."""


def clock_of(model: Model, records: Sequence[Record]) -> float:
    """Time scale against a 160 m ship: sqrt(L/160 m), or the records' duration over 600 s (at most 1)."""
    length = model.particulars.get("L")
    if length is not None:
        return float(np.sqrt(length / 160.0))
    return float(min(np.median([r.time_s[-1] - r.time_s[0] for r in records]) / 600.0, 1.0))


def parts_of(record: Record, clock: float) -> list[Record]:
    """The stretches of a record between long gaps and splices, each a run with a state of its own."""
    return [record.slice(a, b) for a, b in stretches(record, clock)]


def unbroken(records: Sequence[Record], model: Model) -> list[Record]:
    """All records cut at long gaps and splices; one that has no stretch long enough stays as it is."""
    clock = clock_of(model, records)
    return [part for record in records for part in parts_of(record, clock) or [record]]


def unbroken_series(records: Sequence[Record], model: Model, unknowns: int) -> tuple[list[Record], list[Series]]:
    """Records cut at long gaps and splices, and each as a series.

    Raises
    ------
    CannotFit : a record lacks a channel, or there are no more measured values than `unknowns`.
    """
    cut = unbroken(records, model)
    series = [series_of(record, model) for record in cut]
    if (n := sum(s.n_outputs for s in series)) <= unknowns:
        raise CannotFit(f"{n} measured values for {unknowns} coefficients")
    return cut, series


def stretches(record: Record, clock: float) -> list[tuple[int, int]]:
    """First and last + 1 sample of the stretches between long gaps of the rows or of the rudder, and splices.

    clock : time scale against a 160 m ship.
    """
    known = np.flatnonzero(np.isfinite(record.rudder()))
    if not known.size:
        return []
    longest = max(LONG_GAP_STEPS * record.dt, LONG_GAP_S * clock)
    cut = np.flatnonzero(np.diff(record.time_s[known]) > longest)
    late = record.time_s[known[0]] - record.time_s[0] > longest
    starts = [int(known[0]) if late else 0]
    starts += [int(known[i + 1]) for i in cut]
    last = record.n if record.time_s[-1] - record.time_s[known[-1]] <= longest else int(known[-1]) + 1
    ends = [*(int(known[i]) + 1 for i in cut), last]
    spliced = splices(record)
    found: list[tuple[int, int]] = []
    for a, b in zip(starts, ends, strict=True):
        edges = [a, *(i for i in spliced if a < i < b), b]
        found += pairwise(edges)
    return [(a, b) for a, b in found if b - a >= min(SHORTEST, record.n)]


def splices(record: Record) -> list[int]:
    """Samples at which the position or the heading jumps, and stays, beyond what it ever does from sample to sample."""
    found: set[int] = set()
    for name in ("north_m", "east_m", "heading_rad"):
        if record.has(name):
            values = record.continuous(name)
            found |= set(_jumps(values, record.time_s))
    return sorted(found)


def _jumps(values: np.ndarray, time: np.ndarray) -> list[int]:
    known = np.flatnonzero(np.isfinite(values))
    if known.size < 2 * SHORTEST:
        return []
    y, step = values[known], np.diff(time[known])
    with np.errstate(all="ignore"):
        rate = np.abs(np.diff(y)) / step
    usual = float(np.quantile(rate, USUAL))
    found = []
    for k in np.flatnonzero(rate > JUMP * usual):
        before, after = y[max(k + 1 - BESIDE, 0) : k + 1], y[k + 1 : k + 1 + BESIDE]
        moved = abs(np.median(after) - np.median(before)) > 0.5 * abs(y[k + 1] - y[k])
        if usual > 0.0 and moved and min(before.size, after.size) == BESIDE:
            found.append(int(known[k + 1]))
    return found
