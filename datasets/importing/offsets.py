"""Offsets between the clocks of loggers, estimated from what both have recorded."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from ...models.linear_algebra import lstsq
from ..geometry import unwrapped
from ..signals import integral
from .convert import Stream
from .evidence import correlation

Curve: TypeAlias = tuple[np.ndarray, np.ndarray]
"""Times (N,), s, and values (N,)."""
NEAR_S = 120.0
"""Offset that is searched between clocks that both show the date."""
AGREEING = 0.9
"""Correlation from which on two clocks are compared."""
LIKELY, ALIKE, PEAKS = 0.5, 0.05, 20
"""Correlation of the changes from which a lag is tried, difference to the largest one up to which it is, and lags that
are tried at most."""
MOST_RATE, SURE_RATE = 0.05, 6.0
"""Largest rate of a clock, and standard errors from which on it is one."""
MOST_LAGS, FEWEST, OVERLAP = 1500, 30, 0.4
"""Lags that are tried, samples in common, and the share of the shorter log that must overlap."""


@dataclass(frozen=True)
class Offset:
    """Seconds to add to the times of the second clock, standard error, correlation, and the quantity compared.

    rate : by how much a second of the second clock is shorter than one of the first, where its offset changes: seconds
    are added at `middle`, s, of the second clock, and rate (t - middle) more at its time t.
    """

    seconds: float
    stderr: float
    correlation: float
    quantity: str
    rate: float = 0.0
    middle: float = 0.0


def estimate_offset(first: Sequence[Stream], second: Sequence[Stream]) -> Offset | None:
    """The offset between two clocks with streams that share a quantity; None where nothing is shared or it disagrees.

    The second series is moved against the first: from the lags of the largest correlations of the changes by least
    squares of first(t) = second(t - offset) + a + b t, of which the best fit counts.
    """
    own, other = _series(first), _series(second)
    shared = [name for name in ("turn", "speed", "north", "east", "rudder", "roll") if name in own and name in other]
    dated = all(stream.dated for stream in (*first, *second))
    found = [_between(own[name], other[name], dated, name) for name in shared]
    sure = [offset for offset in found if offset is not None and offset.correlation >= AGREEING]
    return min(sure, key=lambda offset: offset.stderr) if sure else None


def _series(streams: Sequence[Stream]) -> dict[str, Curve]:
    """What can be compared, by name; turning is compared as heading."""
    out: dict[str, Curve] = {}
    for stream in streams:
        q = stream.quantities
        if (turn := turning(stream)) is not None:
            out.setdefault("turn", turn)
        for name in ("north", "east", "roll", "rudder"):
            if name in q:
                out.setdefault(name, known(stream.time, q[name]))
        if "speed_over_ground" in q:
            out.setdefault("speed", known(stream.time, q["speed_over_ground"]))
        elif "surge" in q and "sway" in q:
            out.setdefault("speed", known(stream.time, np.hypot(q["surge"], q["sway"])))
    return {name: pair for name, pair in out.items() if pair[0].size >= FEWEST}


def turning(stream: Stream) -> Curve | None:
    """The heading of a stream without jumps, by its sensor or the integral of the yaw rate; None without any."""
    q = stream.quantities
    heading = q.get("heading", q.get("heading_magnetic"))
    if heading is not None:
        return known(stream.time, unwrapped(heading))
    if "yaw_rate" not in q:
        return None
    time, rate = known(stream.time, q["yaw_rate"])
    return time, integral(rate, time)


def known(time: np.ndarray, values: np.ndarray) -> Curve:
    """The times and values (K,) of those (N,) that are known."""
    sound = np.isfinite(values) & np.isfinite(time)
    return time[sound], values[sound]


def _between(first: Curve, second: Curve, dated: bool, name: str) -> Offset | None:
    (t1, x1), (t2, x2) = first, second
    step = max(float(np.median(np.diff(t1))), float(np.median(np.diff(t2))))
    shortest = min(t1[-1] - t1[0], t2[-1] - t2[0])
    overlap = min(t1[-1], t2[-1]) - max(t1[0], t2[0])
    if dated and overlap > OVERLAP * shortest:
        low, high = -NEAR_S, NEAR_S
    else:
        keep = OVERLAP * shortest
        low, high = t1[0] + keep - t2[-1], t1[-1] - keep - t2[0]
    count = int(min(MOST_LAGS, max(3, math.ceil((high - low) / step))))
    lags = np.linspace(low, high, count)
    grid_step = max(step, shortest / 2000.0)
    scores = [_correlation(t1, x1, t2 + lag, x2, grid_step, OVERLAP * shortest) for lag in lags]
    peaks = [float(lags[i]) for i in _peaks(np.array(scores)) if scores[i] >= LIKELY]
    refined = (_refined(t1, x1, t2, x2, lag, grid_step, name) for lag in peaks)
    return max((offset for offset in refined if offset is not None), key=lambda o: o.correlation, default=None)


def _peaks(scores: np.ndarray) -> list[int]:
    """Places of the local maxima that are nearly as large as the largest, at most PEAKS: with a clock that goes slow,
    one manoeuvre of many is like those before it, too."""
    around = np.concatenate([[-np.inf], scores, [-np.inf]])
    tops = np.flatnonzero((scores >= around[:-2]) & (scores > around[2:]) & (scores > scores.max() - ALIKE))
    return sorted(tops.tolist(), key=lambda i: -scores[i])[:PEAKS]


def _common(t1: np.ndarray, t2: np.ndarray, step: float) -> np.ndarray:
    return np.arange(max(t1[0], t2[0]), min(t1[-1], t2[-1]), step)


def _correlation(t1: np.ndarray, x1: np.ndarray, t2: np.ndarray, x2: np.ndarray, step: float, least: float) -> float:
    """Correlation of the changes of two series where they overlap; -1 where they overlap too little."""
    grid = _common(t1, t2, step)
    if grid.size < FEWEST or grid[-1] - grid[0] < least:
        return -1.0
    width = max(1, grid.size // 100)
    a, b = np.interp(grid, t1, x1), np.interp(grid, t2, x2)
    return correlation(a[width:] - a[:-width], b[width:] - b[:-width])


def _refined(t1, x1, t2, x2, lag: float, step: float, name: str) -> Offset | None:
    """The offset by least squares from a first lag, with a rate where the offset surely changes."""
    still = _fitted(t1, x1, t2, x2, Offset(lag, math.inf, 0.0, name, 0.0, (t2[0] + t2[-1]) / 2.0), step, 1)
    if still is None:
        return None
    moving = _fitted(t1, x1, t2, x2, still[0], step, 2)
    if moving is None:
        return still[0]
    rate, error = moving[0].rate, moving[1]
    changes = abs(rate) * (t2[-1] - t2[0]) > 2.0 * step
    return moving[0] if changes and SURE_RATE * error < abs(rate) < MOST_RATE else still[0]


def _fitted(t1, x1, t2, x2, start: Offset, step: float, count: int) -> tuple[Offset, float] | None:
    """(offset, standard error of its rate) by Gauss-Newton steps on the offset (count 1) and the rate (2), with a
    constant and a trend beside them; None where too little is in common."""
    at, error = start, math.inf
    for _ in range(12):
        moved = t2 + at.seconds + at.rate * (t2 - at.middle)
        grid = _common(t1, moved, step)
        if grid.size < FEWEST:
            return None
        a, b = np.interp(grid, t1, x1), np.interp(grid, moved, x2)
        slope = np.gradient(b, grid)
        own = np.column_stack([slope, slope * (grid - at.seconds - at.middle)])[:, :count]
        columns = np.column_stack([-own, np.ones(grid.size), grid - grid[0]])
        solution = lstsq(columns, a - b)
        rest = a - b - columns @ solution
        line = columns[:, count:] @ lstsq(columns[:, count:], a)
        fit = math.sqrt(max(0.0, 1.0 - float(rest @ rest) / max(float(np.sum((a - line) ** 2)), 1e-300)))
        more = float(np.clip(solution[0], -5.0 * step, 5.0 * step))
        faster = float(np.clip(solution[1], -0.01, 0.01)) if count > 1 else 0.0
        error = _stderr(rest, own[:, 1]) if count > 1 else math.inf
        at = Offset(at.seconds + more, _stderr(rest, slope), fit, at.quantity, at.rate + faster, at.middle)
        if abs(more) < 1e-4 * step and abs(faster) * (t2[-1] - t2[0]) < 1e-4 * step:
            break
    return at, error


def _stderr(rest: np.ndarray, slope: np.ndarray) -> float:
    """Standard error of the offset, residuals being correlated from sample to sample."""
    power = float(np.sum((slope - slope.mean()) ** 2))
    variance = float(np.mean(rest**2))
    r = float(np.sum(rest[1:] * rest[:-1]) / max(float(np.sum(rest**2)), 1e-300))
    inflation = (1.0 + r) / max(1.0 - r, 1e-3)
    return math.sqrt(variance * max(inflation, 1.0) / power) if power > 0.0 else math.inf
