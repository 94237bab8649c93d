"""Records of one run that are no copies sample by sample: rounded, resampled, shifted, rotated, mirrored or jittered.

Two runs never share the noise of their sensors.  What is left of a channel after its motion is taken out (third
differences) is correlated between both records at all lags, each frequency weighted alike (the generalised
cross-correlation with phase transform of Knapp and Carter 1976, doi 10.1109/TASSP.1976.1162830): of the same run it
has one peak, at the same lag in every channel, of independent noise it is nowhere large.  The motion must go along with
it: simulations of one seed share their noise in different manoeuvres.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from .record import Record
from .signals import white_noise

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


class _Correlated(NamedTuple):
    """Correlations of a channel's noise (2 M,) by lag in half samples, negative lags from the end, and the least one
    that is not by chance."""

    values: np.ndarray
    least: float

    def near(self, k: int, sign: float) -> float:
        """The largest correlation of a sign near half lag k."""
        return float(np.max(sign * self.values[np.arange(k - 2 * NEAR, k + 2 * NEAR + 1) % self.values.size]))


class EvenRecords:
    """Records at even steps, ready to be compared with each other."""

    def __init__(self, records: Sequence[Record]) -> None:
        self.records = [r for r in records if r.n >= SHORTEST]
        self._steps = {id(r): (float(np.median(np.diff(r.time_s))), float(np.ptp(r.time_s))) for r in self.records}
        self._sampled: dict[tuple[int, str, float, int], _Sampled | None] = {}

    def same(self, first: Record, second: Record) -> Same | None:
        """What two records share where they are of one run; else None."""
        if min(first.n, second.n) < SHORTEST:
            return None
        (one_s, one_span_s), (other_s, other_span_s) = (self._steps[id(r)] for r in (first, second))
        step = max(one_s, other_s)
        longest = max(one_span_s, other_span_s) / step
        if not np.isfinite(longest) or longest > 4 * max(first.n, second.n):  # a gap that no step bridges
            return None
        size = 1 << int(np.ceil(np.log2(2.0 * longest + 2.0)))
        correlated = {}
        for name in (n for n in CHANNELS if first.has(n) and second.has(n)):
            one, other = (self._of(r, name, step, size) for r in (first, second))
            if one is not None and other is not None and (one.noisy or other.noisy):
                correlated[name] = _correlated(one, other, size)
        return _judged(correlated, step, lambda name, lag: self._motion(first, second, name, step, size, lag))

    def _of(self, record: Record, name: str, step: float, size: int) -> _Sampled | None:
        key = (id(record), name, step, size)
        if key not in self._sampled:
            self._sampled[key] = _sampled(record, name, step, size)
        return self._sampled[key]

    def _motion(self, first: Record, second: Record, name: str, step: float, size: int, lag: float) -> float:
        """Correlation of the motions at a lag in samples."""
        one, other = self._of(first, name, step, size), self._of(second, name, step, size)
        assert one is not None and other is not None
        a, b = one.values[max(round(lag), 0) :], other.values[max(round(-lag), 0) :]
        n = min(a.size, b.size)
        with np.errstate(all="ignore"):  # of gross errors
            if n < SHORTEST // 2 or not (np.std(a[:n]) > 0.0 and np.std(b[:n]) > 0.0):
                return 0.0
            return float(np.nan_to_num(np.corrcoef(a[:n], b[:n])[0, 1]))


def same_run(records: Sequence[Record], others: Sequence[Record] | None = None) -> tuple[Record, Record, Same] | None:
    """The first two records that are of one run, of the records and the others; others None: of the records among each
    other."""
    compared = EvenRecords([*records, *(others or ())])
    if others is None:
        pairs = ((a, b) for i, a in enumerate(records) for b in records[i + 1 :])
    else:
        pairs = product(records, others)
    return next(((a, b, found) for a, b in pairs if (found := compared.same(a, b)) is not None), None)


def _sampled(record: Record, name: str, step: float, size: int) -> _Sampled | None:
    values = record.continuous(name)
    known = np.isfinite(values)
    if known.sum() < SHORTEST:
        return None
    time = record.time_s
    even = np.interp(np.arange(time[0], time[-1], step), time[known], values[known])
    rough = np.diff(even, 3)
    limit = CLIP * 1.4826 * float(np.median(np.abs(rough)))
    rough = np.clip(rough, -limit, limit)
    spectrum = np.fft.rfft(rough - np.mean(rough), size)
    length = np.abs(spectrum)
    if not (np.isfinite(length).all() and length.any()):
        return None
    return _Sampled(even, spectrum / np.maximum(length, 1e-300), white_noise(values) > 0.0)


def _correlated(one: _Sampled, other: _Sampled, size: int) -> _Correlated:
    """Correlations at all lags, half a sample apart: between two samples a peak is shared by both and low in each."""
    values = 2.0 * np.fft.irfft(one.spectrum * np.conj(other.spectrum), 2 * size)
    return _Correlated(values, max(PEAK, CHANCE / np.sqrt(min(one.values.size, other.values.size))))


def _judged(found: dict[str, _Correlated], step: float, motion: Callable[[str, float], float]) -> Same | None:
    """One run, where two channels agree in their lags, or one alone has noise, and the motion goes along.

    The sign of a channel is that of its motion: beside its peak the noise of interpolated samples has others of the
    opposite sign.
    """
    for leading in found.values():
        k = int(np.argmax(np.abs(leading.values)))
        if abs(leading.values[k]) <= leading.least:
            continue
        lag = (k if 2 * k < leading.values.size else k - leading.values.size) / 2.0
        moved = {name: motion(name, lag) for name in found}
        near = {name: c.near(k, np.sign(moved[name])) for name, c in found.items()}
        agree = [name for name, value in near.items() if value > found[name].least]
        enough = len(agree) > 1 or (len(found) == 1 and all(near[name] > ALONE for name in agree))
        motions = [abs(moved[name]) for name in agree]
        if agree and enough and max(motions) > MOTION and min(motions) > NOISY:
            mirrored = any(moved[name] < 0.0 for name in agree)
            return Same(tuple(agree), min(near[name] for name in agree), mirrored, lag * step)
    return None
