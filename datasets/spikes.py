"""Isolated gross errors of a channel: samples far from the curve through their neighbours."""

from __future__ import annotations

from itertools import permutations

import numpy as np

LIMIT, NEAR = 6.5, 4.5
"""Robust standard deviations from which a sample is a gross error, and nearly one."""
LEAST = 3e-4
"""Share of a channel's own spread that its noise is taken to have at least: corners of a noise-free motion are no
gross errors."""
ONE_SIDE = 0.3
"""Share of its distance from the curve by which a gross error also departs from the lines through its neighbours of
either side alone: a corner or a step of the motion goes on from one of them."""
NEARLY = 3.0
"""Robust standard deviations within which a sample goes on from them."""
MANY = 3
"""Samples in turn that are no isolated errors any more."""
ROUNDS, REACH, OFTEN, GROWTH = 12, 5, 0.01, 2.0
"""Rounds of the search, samples that a neighbour may be away, the share of gross errors from which on two may stand
side by side, and how many times those of the first round may become: more are the corners of a motion."""
AROUND = 7
"""Samples of whose median those are far that the search begins with, and those at the ends that are gross errors."""
LARGE = 0.9
"""Share of a channel's steps that are no larger than those of its motion: gross errors make fewer."""
OUTSIDE, BEND = 8.0, 1.0
"""Usual steps by which a gross error is off the median of the samples there, and those that a motion which turns there
is off beside its noise."""


def without_spikes_in_time(values: np.ndarray, time_s: np.ndarray, least: float = 0.0) -> tuple[np.ndarray, int, int]:
    """As `without_spikes`, where rows of the record may be missing: time_s (T,) says between which."""
    step = np.diff(time_s)
    rows = np.clip(np.round(step / np.median(step)), 1, REACH + 1).astype(int) if step.size else step.astype(int)
    place = np.concatenate([[0], np.cumsum(rows)])
    spread = np.full(place[-1] + 1, np.nan)
    spread[place] = values
    cleaned, found, near = without_spikes(spread, least)
    return cleaned[place], found, near


def without_spikes(values: np.ndarray, least: float = 0.0) -> tuple[np.ndarray, int, int]:
    """Series (T,) with single gross errors as gaps, their number, and the number of samples that nearly are.

    A gross error departs from the cubic through its two neighbours to each side by more than LIMIT robust standard
    deviations and, at first, more than they do, or it and the next one depart from the cubic through those beside
    both.  With those found left out of the cubics all are judged again, as gross errors make what is between them
    look like one.  A sample that goes on from its neighbours of one side is a corner of the motion, and none.  Near
    misses lie between NEAR and LIMIT (many of them: a heavy tail, not gross errors).

    least : standard deviation that the noise has at least, as that of a coarse channel.
    """
    known = np.isfinite(values)
    first = settled = None
    least = max(least, LEAST * float(np.std(values[known])) if known.any() else 0.0)
    if values.size < 12 or known.sum() < 12:
        return values.copy(), 0, 0
    good = known
    departure, judged = _departures(values, good)
    usual = LIMIT * _spread(departure, judged, least)
    ends = _at_ends(values, known, usual)
    known = known & ~ends
    spike = _off_the_median(values, known, usual)
    for _ in range(ROUNDS):
        if not np.array_equal(good, known & ~spike):
            good = known & ~spike
            departure, judged = _departures(values, good)
        spread = _spread(departure, good & judged, least)
        # the larger (T,) of the two values beside each
        padded = np.concatenate([[0.0], np.where(spike, 0.0, departure), [0.0]])
        peak = departure >= np.maximum(padded[:-2], padded[2:])
        found = (departure > LIMIT * spread) & (spike | peak) & known & (spread > 0.0)
        if np.array_equal(found, spike):
            if settled is not None and np.array_equal(spike, settled):
                break  # those side by side lead back to it
            settled = spike
            if spike.sum() > OFTEN * values.size:
                # good samples that, both of two in turn, are off the cubic through those beside
                late = _departures(values, good, 1)[0] > LIMIT * spread
                early = _departures(values[::-1], good[::-1], 1)[0][::-1] > LIMIT * spread
                pair = late[:-1] & early[1:] & good[:-1] & good[1:] & (spread > 0.0)
                found = spike | np.append(pair, False) | np.append(False, pair)
        if np.array_equal(found, spike):
            break
        first = found if first is None else first
        if found.sum() > GROWTH * first.sum() + 2:
            spike = first
            break
        spike = found
    else:
        spike = spike if settled is None else settled
    edge = np.flatnonzero(np.diff(np.concatenate([[False], spike, [False]]).astype(int)))
    for start, stop in zip(edge[0::2], edge[1::2], strict=True):
        if stop - start >= MANY and (start < MANY or stop > spike.size - MANY):
            spike[start:stop] = False  # at the record's ends no gross errors, but a motion that starts there
    at = np.flatnonzero(spike)
    spike[at[_corners(values, known & ~spike, NEARLY * spread, at)]] = False
    near = peak & ~spike & ~ends & (departure > NEAR * spread)
    spike |= ends
    return np.where(spike, np.nan, values), int(spike.sum()), int(near.sum())


def _off_the_median(y: np.ndarray, good: np.ndarray, limit: float) -> np.ndarray:
    """(T,) good samples further than the limit, and than OUTSIDE times the way of the motion's large steps across, from
    the median of the AROUND good ones about them, which gross errors beside each other do not move."""
    own, off, reach = np.flatnonzero(good), np.zeros(y.size, bool), AROUND // 2
    if own.size >= AROUND and limit > 0.0:
        steps = np.abs(np.diff(y[own]))
        furthest = max(limit, OUTSIDE * reach * float(np.quantile(steps, LARGE)))
        if (AROUND - 1) * float(steps.max()) <= furthest:
            return off
        windows = np.lib.stride_tricks.sliding_window_view(y[own], AROUND)
        parts = [y[own][i : own.size - AROUND + 1 + i] for i in range(AROUND)]
        ranges = np.maximum.reduce(parts) - np.minimum.reduce(parts)
        wide = np.flatnonzero(ranges > furthest)  # in others no sample is as far from the median
        inner = own[reach + wide]
        off[inner] = np.abs(y[inner] - np.median(windows[wide], axis=1)) > furthest
    return off


def _corners(y: np.ndarray, good: np.ndarray, limit: float, place: np.ndarray) -> np.ndarray:
    """(M,) those of the samples at place (M,) that go on from the line through two good neighbours of one side, by a
    share of their distance from the straight line between both sides, or by less than the limit."""
    own = np.flatnonzero(good)
    after, before = np.searchsorted(own, place, side="right"), np.searchsorted(own, place)
    inside = (before >= 2) & (after + 2 <= own.size)
    k, before, after = place[inside], before[inside], after[inside]
    a, b, c, d = (own[i] for i in (before - 2, before - 1, after, after + 1))

    def off(i: np.ndarray, j: np.ndarray) -> np.ndarray:
        return np.abs(y[k] - y[i] - (y[j] - y[i]) * (k - i) / (j - i))

    corner = np.zeros(place.size, bool)
    share = np.where(c - b > 2, 2.0 * ONE_SIDE, ONE_SIDE)  # across a gap the motion has bent further
    corner[inside] = np.minimum(off(a, b), off(c, d)) < np.maximum(share * off(b, c), limit)
    return corner


def _spread(departure: np.ndarray, judged: np.ndarray, least: float) -> float:
    """Robust standard deviation, at least `least`, of the distances (T,) that are judged (T,)."""
    usual = departure[judged]
    return max(1.4826 * float(np.median(usual)), least) if usual.size else least


def _at_ends(y: np.ndarray, good: np.ndarray, limit: float) -> np.ndarray:
    """(T,) first and last good samples, which no curve through both sides judges, that are further from the median of
    the AROUND there than the limit and than OUTSIDE usual steps."""
    gross, middle = np.zeros(y.size, bool), AROUND // 2
    for order in (1, -1):
        own = np.flatnonzero(good)[::order][:AROUND]
        if own.size < AROUND or not limit > 0.0:
            continue
        off = np.abs(y[own] - np.median(y[own]))[:middle]
        step = float(np.median(np.abs(np.diff(y[own]) / np.diff(own))))
        rows = np.abs(own[middle] - own[:middle]) / np.arange(middle, 0, -1)  # from one known sample to the next
        gross[own[:middle]] = off > np.maximum(np.sqrt(2.0) * limit + BEND * step, OUTSIDE * step * rows)
    return gross


def _departures(y: np.ndarray, good: np.ndarray, skip: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Distances (T,) from the cubic through the two good neighbours to each side, in units of noise alike for all,
    and (T,) where there are any: neighbours more than REACH samples away say nothing, and the distance is 0.

    skip : so many samples after each are not used for it.
    """
    out, judged = np.zeros(y.size), np.zeros(y.size, bool)
    own, beside = np.flatnonzero(good), np.array([-2, -1, 1 + skip, 2 + skip])
    inner = np.arange(2, max(y.size - 2 - skip, 2))
    even = np.logical_and.reduce([good[inner + i] for i in beside]) if inner.size else np.zeros(0, bool)
    uneven = np.ones(y.size, bool)
    uneven[inner] = ~even
    place = np.flatnonzero(uneven)
    after = np.searchsorted(own, place + skip, side="right")
    before = np.searchsorted(own, place)
    inside = (before >= 2) & (after + 2 <= own.size)
    k, before, after = place[inside], before[inside], after[inside]
    gaps = np.stack([own[before - 2], own[before - 1], own[after], own[after + 1]])
    for samples, nodes, away in ((inner[even], None, beside[:, None]), (k, gaps, gaps - k)):
        near = [y[samples + i] for i in beside] if nodes is None else y[nodes]
        far, weights = away.astype(float), np.ones(away.shape)
        for i, j in permutations(range(4), 2):
            weights[i] *= far[j] / (far[j] - far[i])
        curve = weights[0] * near[0] + weights[1] * near[1] + weights[2] * near[2] + weights[3] * near[3]
        distance = np.abs(y[samples] - curve) / np.sqrt(1.0 + np.sum(weights**2, axis=0))
        told = np.isfinite(distance) & (np.abs(away).max(axis=0) <= REACH)
        judged[samples], out[samples] = told, np.where(told, distance, 0.0)
    return out, judged
