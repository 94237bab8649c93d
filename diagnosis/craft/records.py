"""What the records of a craft allow: inputs that were measured, feedback on the steering, and the envelope."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from scipy.ndimage import median_filter

from ...estimation.records.series import samples, speed_of, yaw_rate_of
from ...models.linear_algebra import lstsq
from .rungs import ASTERN, PAIR, SPEED, TURNS, WIDE, WIND
from .windows import known_speed_of, thrust_of, turns_of, wind_speed_of

if TYPE_CHECKING:
    from ...datasets.record import Record
    from .windows import Piece, Scales

SPIKED, NEAR, SPIKE = ("yaw_rate_rad_s", "heading_rad", "surge_m_s"), 7, 12.0
"""Channels freed of spikes, samples of the median, and usual distances from it that a spike exceeds."""
COPIED = 0.97
"""Share of a rudder's or command's variation that heading and yaw rate of the same moment explain: it is computed."""
CHANGES, LEAST, FEWEST, FED_BACK = 0.5, 0.2, 50, 0.8
"""Part of the craft's own time over which changes of the steering are compared with those of the motion; the least
ones, in standard deviations, and the fewest; and share of them from which a controller steers: simulated ones had .85
to .9, eight measured sets at most .14, zigzags .98 with the motion and not against it."""
CAUCHY, ROUNDS = 1.5, 50
"""Change, in middle ones, from which the weight of it falls below a half, and times that weights are set anew."""
TONE = 0.9
"""Share of a rudder's or command's variation that one sine explains, from which it is a sine manoeuvre."""
MARGIN = 1.25
"""What held-out records may exceed the training records by and still count as inside."""
OUTSIDE = 0.1
"""Share of a held-out record outside the training envelope that is told."""
BACKWARDS = 0.05
"""Share of the samples that go astern, at BACKWARDS of the speed or faster, where the craft goes astern."""
WIDEST_RUDDER = 1.0
"""Angle, rad, that 95 % of the samples of a rudder stay below: what is turned further is an azimuth thruster."""
EXCITED = 1.0
"""Smooth yaw rate over what smoothing took away, averaged, below which no manoeuvre stands out."""


def without_spikes(record: Record) -> tuple[Record, int]:
    """The record with samples of yaw rate, heading and surge as gaps that stand out of their neighbours, and how many.

    A sample stands out where it is further from the median of NEAR samples than SPIKE times the usual distance, and
    than half the range of nine tenths of the channel.
    """
    found, count = {}, 0
    for name in SPIKED:
        if not record.has(name):
            continue
        values = record.continuous(name)
        known = np.flatnonzero(np.isfinite(values))
        if known.size < 4 * NEAR:
            continue
        y = values[known]
        away = np.abs(y - median_filter(y, NEAR, mode="mirror"))
        low, high = np.quantile(y, (0.05, 0.95))
        spikes = away > max(SPIKE * float(np.median(away)), 0.5 * float(high - low))
        if spikes.any() and spikes.mean() < 0.1:
            found[name] = record.column(name).copy()
            found[name][known[spikes]] = np.nan
            count += int(spikes.sum())
    return (record.with_channels(**found) if found else record), count


def measured_by_all(records: Sequence[Record], scales: Scales) -> frozenset[str]:
    """The inputs that all records measure."""
    channels = {SPEED: known_speed_of, TURNS: turns_of, WIND: wind_speed_of, PAIR: thrust_of}
    sizes = {SPEED: scales.speed, TURNS: scales.turns, WIND: scales.wind2, PAIR: scales.thrust}
    given = {n for n, of in channels.items() if sizes[n] > 0.0 and all(of(r) is not None for r in records)}
    given |= {ASTERN} if SPEED in given and _goes_astern(records, scales.speed) else set()
    return frozenset(given | ({WIDE} if PAIR not in given and scales.rudder > WIDEST_RUDDER else set()))


def _goes_astern(records: Sequence[Record], speed: float) -> bool:
    every = np.concatenate([speed_of(r) for r in records])
    return bool(np.mean(every[np.isfinite(every)] < -BACKWARDS * speed) > BACKWARDS)


def copied_input(pieces: Sequence[Piece]) -> float:
    """Share of the steering's variation that a straight line of heading and yaw rate at the same moment explains, the
    least of all pieces: near one where the column was computed from them.

    A sine manoeuvre says nothing of it: of three sines of one period each is a sum of the two others.
    """
    shares = []
    for piece in pieces:
        y = piece.record.rudder()
        x = np.column_stack([np.ones(y.size), piece.smooth])
        known = np.isfinite(y)
        if known.sum() < 20 or np.std(y[known]) == 0.0 or sine_share(y[known]) > TONE:
            continue
        rest = y[known] - x[known] @ lstsq(x[known], y[known])
        shares.append(1.0 - float(np.var(rest) / np.var(y[known])))
    return min(shares, default=0.0)


def feedback_share(pieces: Sequence[Piece], time_s: float) -> float:
    """By how much a line of heading and yaw rate at the same moments makes the middle one of all changes of the
    steering smaller, over a part of the craft's own time, `time_s`: near one where a controller steers, however often
    its reference changes; 0 where the line is not against the motion.

    The line is fitted with Cauchy weights, as jumps of the reference are no feedback (Holland and Welsch 1977).
    """
    changes, motion = list[np.ndarray](), list[np.ndarray]()
    for piece in pieces:
        steering, lag = piece.record.rudder(), max(1, int(CHANGES * time_s / piece.record.dt))
        changes.append(steering[lag:] - steering[:-lag])
        motion.append(piece.smooth[lag:, ::-1] - piece.smooth[:-lag, ::-1])
    y, x = np.concatenate(changes), np.concatenate(motion)
    known = np.isfinite(y) & np.isfinite(x).all(axis=1)
    known &= np.abs(y) > LEAST * np.std(y[known])
    if known.sum() < FEWEST:
        return 0.0
    weight = np.ones(known.sum())
    y, x = y[known], x[known]
    for _ in range(ROUNDS):
        root = np.sqrt(weight)
        line = lstsq(x * root[:, None], y * root)
        rest = np.abs(y - x @ line)
        weight = 1.0 / (1.0 + (rest / (CAUCHY * max(float(np.median(rest)), 1e-12))) ** 2)
    share = 1.0 - float(np.median(rest) / np.median(np.abs(y)))
    return share if np.all(line < 0.0) else 0.0


def sine_share(y: np.ndarray) -> float:
    """Share of the variation of even samples (N,) that the sine of their strongest period explains."""
    length = 8 * y.size
    cycles = int(np.argmax(np.abs(np.fft.rfft(y - y.mean(), length)))) / length
    phase = 2.0 * np.pi * cycles * np.arange(y.size)
    waves = np.column_stack([np.ones(y.size), np.cos(phase), np.sin(phase)])
    return 1.0 - float(np.var(y - waves @ lstsq(waves, y)) / np.var(y))


def weak_motion(pieces: Sequence[Piece]) -> float:
    """Standard deviation of the smoothed yaw rate over what the smoothing took away."""
    rate = np.concatenate([p.smooth[:, 0] for p in pieces])
    rest = []
    for piece in pieces:
        measured = samples(piece.record, "r")
        if measured is not None:
            rest.append((measured - piece.smooth[:, 0])[np.isfinite(measured)])
    noise = float(np.std(np.concatenate(rest))) if rest and sum(map(len, rest)) else 0.0
    count = np.sqrt(max(len(rate), 1))
    return float(np.std(rate) / max(noise / min(count, 8.0), 1e-12))


def outside(train: Sequence[Record], other: Record) -> list[str]:
    """In what a record leaves the envelope of the training records, in words with shares of its time."""
    told = []
    for name, values in ENVELOPE.items():
        own, known = values(other), [values(r) for r in train]
        if own is None or any(k is None for k in known):
            continue
        every = np.concatenate([k for k in known if k is not None])
        low, high = (float(f(every)) for f in (np.nanmin, np.nanmax))
        room = (MARGIN - 1.0) * max(high - low, 1e-12)
        share = float(np.nanmean((own < low - room) | (own > high + room)))
        told += [f"{name} ({100.0 * share:.0f} % of the time)"] if share > OUTSIDE else []
    return told


ENVELOPE = {
    "yaw rate": yaw_rate_of,
    "rudder or command": lambda record: record.rudder(),
    "speed": known_speed_of,
    "surge": lambda record: samples(record, "u"),
    "revolutions": turns_of,
}
"""What is compared -> its samples (N,), None where a record has none."""
