"""Records that hold samples of each other, a run given twice or cut out of another, or the same noise."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import combinations, product
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ..models.errors import BadInput
from .record import Record
from .signals import white_noise

FEWEST, SHARE = 20, 2.0 / 3.0
"""Samples in turn, and their share of the shorter record, from which one record is a part of another: two noise-free
runs may begin alike."""
LIKE = "rounded, resampled, shifted or turned"
FACTORS = np.random.default_rng(0).integers(1, 2**63, 64, dtype=np.uint64) * np.uint64(2) + np.uint64(1)
"""Odd numbers by which the bits of a row's channels are multiplied to make one number of the row."""


def check_no_copies(records: Sequence[Record], others: Sequence[Record] | None = None) -> None:
    """Refuse records that hold samples of another one: they would count twice.

    others : held-out records, which are compared with the records; None: the records are compared with each other.

    Raises
    ------
    BadInput : naming both records.
    """
    for first, second in _suspects(records, others):
        shared = shared_samples(first, second)
        if shared < max(FEWEST, SHARE * min(first.n, second.n)):
            continue
        hint = "give every run once; a held-out record takes no part in training"
        if shared == first.n == second.n:
            repeated = f"holds the same samples as {first.name}"
            said = repeated if others is None else "is both a training record and held out"
        else:
            training = "" if others is None else "the training record "
            said = f"shares {shared} of its {second.n} samples with {training}{first.name}"
        raise BadInput(said, file=second.name, hint=hint)
    found = same_run(records, others)
    if found is not None:
        first, second, same = found
        how = f"mirrored, {LIKE}" if same.mirrored else LIKE
        when = f" {same.later_s:.3g} s on" if same.later_s else ""
        said = (
            f"is the run of {first.name} again{when}, {how}: the noise of {' and '.join(same.channels)} is the same "
            f"(correlation {same.correlation:.2f})"
        )
        raise BadInput(said, file=second.name, hint="give every run once; a held-out record takes no part in training")


def _suspects(records: Sequence[Record], others: Sequence[Record] | None) -> Iterable[tuple[Record, Record]]:
    """The pairs to compare: those with a sample in common, or all where the records' channels differ."""
    every = [*records, *(others or ())]
    if len({frozenset(record.channels) for record in every}) > 1:
        return combinations(records, 2) if others is None else product(records, others)
    # numbers (i, j), i < j, of records with the same channels that have at least one sample in common
    names = sorted(every[0].channels) if every else []
    rows = [_rows(record, names) for record in every]
    owner = np.repeat(np.arange(len(rows)), [row.size for row in rows])
    values = np.concatenate([np.zeros(0, dtype=np.uint64), *rows])
    order = np.lexsort((owner, values))
    values, owner = values[order], owner[order]
    starts = np.flatnonzero(np.append(True, values[1:] != values[:-1])) if values.size else np.zeros(0, dtype=int)
    ends = np.append(starts[1:], values.size)
    found: set[tuple[int, int]] = set()
    for start, end in zip(starts[ends - starts > 1].tolist(), ends[ends - starts > 1].tolist(), strict=True):
        found.update(combinations(np.unique(owner[start:end]).tolist(), 2))
    pairs = sorted(found)
    if others is not None:
        pairs = [(i, j) for i, j in pairs if i < len(records) <= j]
    return [(every[i], every[j]) for i, j in pairs]


def shared_samples(first: Record, second: Record) -> int:
    """Number of samples in turn that two records share in all channels that both have, whatever their names and times.

    Samples that repeat the one before do not count, unless the records are equal.  One record may hold every k-th
    sample of the other.
    """
    names = sorted(first.channels.keys() & second.channels.keys())
    if len(names) < 2:
        return 0
    if first.n == second.n and all(
        np.array_equal(first.channels[k], second.channels[k], equal_nan=True) for k in names
    ):
        return first.n
    one, other = _rows(first, names), _rows(second, names)
    return max(_in_turn(one, other), _in_turn(other, one))


def _rows(record: Record, names: Sequence[str]) -> np.ndarray:
    """A number (N,) for each sample, the same for equal samples."""
    out = np.zeros(record.n, dtype=np.uint64)
    for name, factor in zip(names, FACTORS, strict=False):
        bits = (record.channels[name] + 0.0).view(np.uint64)  # -0 becomes 0
        mixed = (bits ^ (bits >> np.uint64(29))) * factor
        out += mixed ^ (mixed >> np.uint64(32))
    return out


def _in_turn(dense: np.ndarray, thin: np.ndarray) -> int:
    """Number of changing samples of `thin` that stand in `dense` with one shift and one stride."""
    rows, inverse = np.unique(dense, return_index=True)
    place = np.minimum(np.searchsorted(rows, thin), rows.size - 1)
    found = np.flatnonzero(rows[place] == thin)
    found = found[np.diff(thin[found], prepend=np.uint64(0)) != 0]
    if found.size < FEWEST:
        return 0
    at = inverse[place[found]]
    stride = max(1, round(float(np.median(np.diff(at) / np.diff(found)))))
    shifts, counts = np.unique(at - stride * found, return_counts=True)
    shift = int(shifts[counts.argmax()])
    low, high = max(0, -(shift // stride)), min(thin.size, (dense.size - 1 - shift) // stride + 1)
    if high - low < 2:
        return 0
    thin = thin[low:high]
    equal = dense[shift + stride * np.arange(low, high)] == thin
    return int(equal[0]) + int(np.sum(equal[1:] & (np.diff(thin) != 0)))


# ---- Records of one run that are no copies sample by sample: rounded, resampled, shifted, rotated, mirrored, jittered.
#
# Two runs never share the noise of their sensors.  What is left of a channel after its motion is taken out (third
# differences) is correlated between both records at all lags, each frequency weighted alike (the generalised
# cross-correlation with phase transform of Knapp and Carter 1976, doi 10.1109/TASSP.1976.1162830): of the same run it
# has one peak, at the same lag in every channel, of independent noise it is nowhere large.  The motion must go along
# with it: simulations of one seed share their noise in different manoeuvres.

CHANNELS = ("yaw_rate_rad_s", "heading_rad", "surge_m_s", "sway_m_s")
SHORTEST = 60
"""Samples below which nothing is compared."""
PEAK, CHANCE = 0.38, 5.0
"""Least correlation of noise at the peak, and the same in standard deviations of independent noise."""
ALONE = 0.5
"""The same where one channel alone has noise."""
NEAR = 2
"""Samples by which the lags of two channels may differ."""
MOTION, NOISY = 0.98, 0.7
"""Correlations of the motions, shifted so, of one channel and at least of every other, from which they are one."""
CLIP = 4.0
"""Robust standard deviations to which differences are limited: a step of the rudder is in many runs."""

SURE = 0.999
"""Share of the least correlation that one in single precision must reach: it errs by far less."""
MOST_NUMBERS = 200_000
"""Correlations that are computed at a time."""
MOST_PAIRS = 4_000_000
"""Pairs of records that are listed at a time."""


class Same(NamedTuple):
    """Two records of one run: channels whose noise they share, the least correlation of it, whether port and starboard
    are exchanged in one, and by how many seconds the second one is later."""

    channels: tuple[str, ...]
    correlation: float
    mirrored: bool
    later_s: float


class _Sampled(NamedTuple):
    """A channel (N,) at even steps, and the spectrum of its noise, each frequency of size one."""

    values: np.ndarray
    spectrum: np.ndarray
    noisy: bool


_Grid: TypeAlias = tuple[float, int]
"""Even steps, s, on which two records are compared, and the size of their spectra."""


def same_run(records: Sequence[Record], others: Sequence[Record] | None = None) -> tuple[Record, Record, Same] | None:
    """The first two records that are of one run, of the records and the others; others None: of the records among each
    other."""
    every = [*records, *(others or ())]
    suspects: dict[tuple[int, int], _Grid] = {}  # pairs whose noise in some channel has a peak in common
    for grid, pairs in _pairs(every, None if others is None else len(records)):
        for name in CHANNELS:
            suspects |= dict.fromkeys(_with_peak(every, pairs, name, grid), grid)
    for (i, j), grid in sorted(suspects.items()):
        if (same := _compared(every[i], every[j], grid)) is not None:
            return every[i], every[j], same
    return None


def _pairs(records: Sequence[Record], split: int | None) -> Iterator[tuple[_Grid, np.ndarray]]:
    """Grids, and the pairs of places (P, 2) that are compared on them; without those with a gap that no step bridges.

    The grid of two records has the longer of their steps.
    """
    places = np.array([i for i, r in enumerate(records) if r.n >= SHORTEST], dtype=int)
    counts = np.array([records[i].n for i in places])
    steps = np.array([np.median(np.diff(records[i].time_s)) for i in places])
    spans = np.array([np.ptp(records[i].time_s) for i in places])
    for step in np.unique(steps).tolist():
        coarse, b = np.flatnonzero(steps == step), np.flatnonzero(steps <= step)
        for a in np.array_split(coarse, 1 + coarse.size * b.size // MOST_PAIRS):
            mask = (steps[b] < step) | (a[:, None] < b)
            if split is not None:
                mask &= (places[a] < split)[:, None] != (places[b] < split)
            if not mask.any():
                continue
            with np.errstate(all="ignore"):
                longest = np.maximum.outer(spans[a], spans[b]) / step
            mask &= longest <= 4 * np.maximum.outer(counts[a], counts[b])
            powers = np.ceil(np.log2(2.0 * np.where(mask, longest, 0.0) + 2.0)).astype(int)
            for power in np.unique(powers[mask]).tolist():
                i, j = np.nonzero(mask & (powers == power))
                yield (step, 1 << power), np.sort(np.column_stack([places[a[i]], places[b[j]]]), axis=1)


def _with_peak(records: Sequence[Record], pairs: np.ndarray, name: str, grid: _Grid) -> Iterator[tuple[int, int]]:
    """Those of the pairs (P, 2) whose noise in a channel is correlated by more than chance at some lag.

    Many are computed at a time, in single precision.
    """
    holders = [i for i in np.unique(pairs).tolist() if records[i].has(name)]
    channels = {i: c for i in holders if (c := _sampled(records[i], name, grid, np.complex64)) is not None}
    if not channels:
        return
    row = np.full(len(records), -1)
    row[[*channels]] = np.arange(len(channels))
    spectra = np.array([c.spectrum for c in channels.values()])
    sizes = np.array([c.values.size for c in channels.values()])
    noisy = np.array([c.noisy for c in channels.values()])
    pairs = pairs[(row[pairs] >= 0).all(axis=1)]
    pairs = pairs[noisy[row[pairs]].any(axis=1)]
    block = max(1, MOST_NUMBERS // (2 * grid[1]))
    for start in range(0, len(pairs), block):
        own = pairs[start : start + block]
        one, other = row[own].T
        values = 2.0 * np.fft.irfft(spectra[one] * np.conj(spectra[other]), 2 * grid[1])
        largest = np.maximum(values.max(axis=1), -values.min(axis=1))
        alike = own[largest > SURE * _least(np.minimum(sizes[one], sizes[other]))]
        yield from ((i, j) for i, j in alike.tolist())


def _compared(first: Record, second: Record, grid: _Grid) -> Same | None:
    """What two records share where they are of one run; else None.

    Two channels agree in their lags, or one alone has noise, and the motion goes along.  The sign of a channel is that
    of its motion: beside its peak the noise of interpolated samples has others of the opposite sign.
    """
    channels = {}
    for name in (n for n in CHANNELS if first.has(n) and second.has(n)):
        one, other = (_sampled(r, name, grid) for r in (first, second))
        if one is not None and other is not None and (one.noisy or other.noisy):
            channels[name] = (one, other)
    # half a sample apart: between two samples a peak is shared by both and low in each
    noise = {n: 2.0 * np.fft.irfft(a.spectrum * np.conj(b.spectrum), 2 * grid[1]) for n, (a, b) in channels.items()}
    least = {n: float(_least(min(a.values.size, b.values.size))) for n, (a, b) in channels.items()}
    for leading, values in noise.items():
        k = int(np.argmax(np.abs(values)))
        if abs(values[k]) <= least[leading]:
            continue
        lag = (k if 2 * k < values.size else k - values.size) / 2.0
        moved = {name: _motion(*pair, lag) for name, pair in channels.items()}
        near = {name: _near(own, k, np.sign(moved[name])) for name, own in noise.items()}
        agree = [name for name, value in near.items() if value > least[name]]
        enough = len(agree) > 1 or (len(noise) == 1 and all(near[name] > ALONE for name in agree))
        motions = [abs(moved[name]) for name in agree]
        if agree and enough and max(motions) > MOTION and min(motions) > NOISY:
            mirrored = any(moved[name] < 0.0 for name in agree)
            return Same(tuple(agree), min(near[name] for name in agree), mirrored, lag * grid[0])
    return None


def _motion(one: _Sampled, other: _Sampled, lag: float) -> float:
    """Correlation of the motions at a lag in samples."""
    a, b = one.values[max(round(lag), 0) :], other.values[max(round(-lag), 0) :]
    n = min(a.size, b.size)
    with np.errstate(all="ignore"):  # of gross errors
        if n < SHORTEST // 2 or not (np.std(a[:n]) > 0.0 and np.std(b[:n]) > 0.0):
            return 0.0
        return float(np.nan_to_num(np.corrcoef(a[:n], b[:n])[0, 1]))


def _sampled(record: Record, name: str, grid: _Grid, precision: type = np.complex128) -> _Sampled | None:
    values = record.continuous(name)
    known = np.isfinite(values)
    if known.sum() < SHORTEST:
        return None
    time = record.time_s
    even = np.interp(np.arange(time[0], time[-1], grid[0]), time[known], values[known])
    rough = np.diff(even, 3)
    limit = CLIP * 1.4826 * float(np.median(np.abs(rough)))
    rough = np.clip(rough, -limit, limit)
    spectrum = np.fft.rfft(rough - np.mean(rough), grid[1])
    length = np.abs(spectrum)
    if not (np.isfinite(length).all() and length.any()):
        return None
    spectrum = (spectrum / np.maximum(length, 1e-300)).astype(precision, copy=False)
    return _Sampled(even, spectrum, white_noise(values) > 0.0)


def _least(size: ArrayLike) -> np.ndarray:
    """The least correlation, at its peak, that noise of so many samples does not have by chance."""
    return np.maximum(PEAK, CHANCE / np.sqrt(size))


def _near(values: np.ndarray, k: int, sign: float) -> float:
    """The largest correlation (2 M,) of a sign near half lag k; negative lags stand at the end."""
    return float(np.max(sign * values[np.arange(k - 2 * NEAR, k + 2 * NEAR + 1) % values.size]))
