"""Long records as averages over a few samples each: what a comparison of channels needs of them; and headings without
their wraps, whatever their unit is.

Delays, scales and offsets between channels are told by motions that last as long as the ship's turning.  Averages over
equally many samples of all channels keep these, what channels owe to each other (psi' = r holds for averages too), and
the share of noise; they are taken over less time than the comparison can tell from none.
"""

from __future__ import annotations

from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np

from ...datasets.columns import HEADING
from ...datasets.signals import sensor_sd
from ..base import SENSED

if TYPE_CHECKING:
    from ...datasets.record import Record

SMALL_TURN = 2.0 * np.pi * np.pi / 180.0
"""A full turn in radians that was taken for degrees, rad."""
MOST = 50_000
"""Samples up to which a record is compared as it is, and that a longer one should be averaged to."""
SHARE = 0.04
"""Share of the time in which the ship changes its turn that an average may last: half of it is the floor of a delay."""
CLEAR = 4.0
"""Times its noise that the power of the yaw acceleration must be."""
KNOWN = 0.98
"""Share of samples that every channel must have: where one is sampled more slowly, averages would be late."""


_KNOWN_AVERAGES: WeakKeyDictionary[Record, Record] = WeakKeyDictionary()


def averages_of(record: Record) -> Record:
    """The record's compared channels as averages, the heading without wraps; the record itself where it is short, or
    where averages would lose something of its motion or of a slower channel.  Several checks ask for those of one
    record."""
    if record.n <= MOST:
        return record
    if record not in _KNOWN_AVERAGES:
        _KNOWN_AVERAGES[record] = _averages(record)
    return _KNOWN_AVERAGES[record]


def _averages(record: Record) -> Record:
    # of other channels, which wrap or are switched, an average may be none of their values
    channels = {name: record.column(name) for name in SENSED if record.has(name)}
    if any(np.mean(np.isfinite(x)) < KNOWN for x in channels.values()):
        return record
    if HEADING in channels:
        channels[HEADING] = continuous(channels[HEADING])
    count = min(record.n // MOST, _most(channels.get(HEADING), record))
    if count < 2:
        return record
    steps = np.diff(_blocks(record.time_s, count), axis=1)
    whole = steps.max(axis=1) <= 1.5 * record.dt  # a gap in time lies within no average
    means = {name: np.where(whole, _blocks(x, count).mean(axis=1), np.nan) for name, x in channels.items()}
    return type(record)(_blocks(record.time_s, count).mean(axis=1), means, name=record.name, meta=record.meta)


def _blocks(values: np.ndarray, count: int) -> np.ndarray:
    """(N // count, count) values (N,); those of a last block that is not full are left out."""
    return values[: values.size // count * count].reshape(-1, count)


def _most(heading: np.ndarray | None, record: Record) -> int:
    """Samples over which averages keep the turning: of an unknown heading (N,) 1."""
    return 1 if heading is None else int(SHARE * _turning_time_s(heading, record) / record.dt)


def _turning_time_s(heading: np.ndarray, record: Record) -> float:
    """Yaw rate over yaw acceleration (rms of both), s, from the shortest averages of the heading (N,) whose noise hides
    neither; the length of the record where all are hidden, as on a straight course."""
    white = sensor_sd(heading)
    count = 1
    while record.n // count > 200:
        means, span = _blocks(heading, count).mean(axis=1), count * record.dt
        rate, slope = np.diff(means) / span, np.diff(means, 2) / span**2
        power, bend = float(np.nanmean(rate**2)), float(np.nanmean(slope**2))
        noise = 6.0 * white**2 / (count * span**4)
        if bend > CLEAR * noise:
            return float(np.sqrt(max(power - noise * span**2 / 3.0, 0.0) / (bend - noise)))
        count *= 2
    return float(np.ptp(record.time_s))


# ---- wraps
def without_wraps(heading: np.ndarray) -> np.ndarray:
    """Heading (N,) without its wraps: at a full turn in radians, in degrees, or in radians taken for degrees."""
    turn, step, span = 2.0 * np.pi, float(np.max(np.abs(np.diff(heading)))), float(np.ptp(heading))
    if span > 3.0 * turn and step > 0.5 * 360.0:
        turn = 360.0
    elif wraps_at_small_turn(heading):
        turn = SMALL_TURN
    return np.unwrap(heading, period=turn) if span < 1.2 * turn else heading


def swing(record: Record) -> float:
    """Range of a record's headings, rad; 0 where none is known."""
    heading = record.heading_unwrapped() if record.has("heading_rad") else np.zeros(1)
    return float(np.nanmax(heading) - np.nanmin(heading)) if np.isfinite(heading).any() else 0.0


def continuous(heading: np.ndarray) -> np.ndarray:
    """Heading (N,) without its wraps, gaps as they are."""
    known, out = np.isfinite(heading), heading.copy()
    if known.sum() > 1:
        out[known] = without_wraps(heading[known])
    return out


def wraps_at_small_turn(heading: np.ndarray) -> bool:
    """Whether a heading (N,) without gaps wraps at a full turn in radians that was taken for degrees."""
    span, step = float(np.ptp(heading)), float(np.max(np.abs(np.diff(heading))))
    return span < 1.01 * SMALL_TURN and step > 0.9 * SMALL_TURN
