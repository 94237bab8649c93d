"""Smoothing of measured motions by a kinematic model: an integrated random walk, Kalman filter and smoother.

The states are a signal and its derivatives x, x', ..., the last driven by white noise.  The level of that noise is
chosen by the likelihood of the innovations; the common scale of the sensor variances is eliminated analytically.
Times are in samples throughout, so the numbers do not depend on the sampling step.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from math import factorial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...datasets.record import Record
from ...datasets.signals import sensor_sd
from ..records.series import at_equal_steps, noise_floor, samples

Array = NDArray[np.float64]
WIDE = 3.0
"""Initial standard deviations in units of the sensor's noise and of the largest differences."""
LEVELS = np.arange(-11.0, 7.0)
"""Powers of ten of the process noise tried, in units of the sensor's variance and of samples."""
SHORTEST = 16
"""Samples that a stretch without long gaps needs."""


class SmoothedTrack(NamedTuple):
    """A motion in one record: outputs (N, c), nan = gap, the c-th measuring the derivative `ranks[c]`, in samples."""

    outputs: Array
    ranks: tuple[int, ...]


class Walk(NamedTuple):
    """A kinematic model: number of states, process noise in units of the largest sensor variance, sensor variances
    (c,), and the negative log likelihood."""

    order: int
    level: float
    noise: Array
    cost: float


def random_walk(order: int, level: float) -> tuple[Array, Array]:
    """Transition and process noise (order, order) over one sample of white noise of intensity `level`, integrated."""
    n = order
    f = np.array([[1.0 / factorial(j - i) if j >= i else 0.0 for j in range(n)] for i in range(n)])
    q = [
        [1.0 / (factorial(n - 1 - i) * factorial(n - 1 - j) * (2 * n - 1 - i - j)) for j in range(n)] for i in range(n)
    ]
    return f, level * np.array(q)


def _start(track: SmoothedTrack, order: int, noise: Array) -> tuple[Array, Array]:
    """Initial state and covariance: the first samples; derivatives zero within the largest differences of samples."""
    x, sd = np.zeros(order), np.zeros(order)
    for column, rank, variance in zip(track.outputs.T, track.ranks, noise, strict=True):
        known = column[np.isfinite(column)]
        if known.size > order:
            x[rank], sd[rank] = known[0], WIDE * np.sqrt(variance)
            for k in range(1, order - rank):
                x[rank + k], sd[rank + k] = 0.0, WIDE * (np.abs(np.diff(known, k)).max() + np.sqrt(variance))
    return x, np.diag(np.where(sd > 0.0, sd, WIDE * np.sqrt(noise.max())) ** 2)


def _filtered(track: SmoothedTrack, walk: Walk, keep: bool, like: SmoothedTrack | None = None):
    from . import _kernels

    n, c = walk.order, len(track.ranks)
    f, q = random_walk(n, walk.level)
    scale = np.sqrt(walk.noise.max())
    outputs = np.require(track.outputs / scale, requirements=["C", "W"])
    noise = walk.noise / scale**2
    x, p = _start(SmoothedTrack(outputs, track.ranks), n, noise)
    if like is not None:
        p = _start(SmoothedTrack(like.outputs / scale, like.ranks), n, noise)[1]
    size = len(outputs) if keep else 0
    kept = np.empty((size, n)), np.empty((size, n, n)), np.empty((size, c, n)), np.empty((size, c)), np.empty((size, c))
    columns = np.array(track.ranks, np.int64)
    sums = _kernels.kalman(f, q, columns, noise, outputs, x, p, *kept, n)
    return sums, scale, f, columns, kept


def cost(tracks: Sequence[SmoothedTrack], walk: Walk) -> float:
    """Negative log likelihood of the tracks' innovations at the likeliest common scale of all variances."""
    logs, squares, used = np.sum([_filtered(track, walk, False)[0] for track in tracks], axis=0)
    if not used or not np.isfinite(squares):
        return np.inf
    variance = max(squares / used, 1e-300) * walk.noise.max()
    return float(0.5 * (used * np.log(variance) + logs))


def sensor_variances(tracks: Sequence[SmoothedTrack]) -> np.ndarray:
    """Variances (c,) of the sensors' white noise, of tracks with the same sensors."""
    columns = [np.concatenate(column) for column in zip(*(list(t.outputs.T) for t in tracks), strict=True)]
    sd = [
        max(np.sqrt(np.mean([sensor_sd(t.outputs[:, c]) ** 2 for t in tracks])), noise_floor(column))
        for c, column in enumerate(columns)
    ]
    return np.array(sd) ** 2


def fitted_walk(tracks: Sequence[SmoothedTrack], noise: Array, orders: Sequence[int]) -> Walk:
    """The likeliest order and process noise for all tracks; noise (c,) gives the sensors' ratio of variances."""
    best = Walk(orders[0], 1.0, noise, np.inf)
    for order in orders:
        best = min([best, *_tried(tracks, noise, order, LEVELS)], key=lambda walk: walk.cost)
    for step in (0.5, 0.25):
        middle = np.log10(best.level)
        near = _tried(tracks, noise, best.order, [middle - step, middle + step])
        best = min([best, *near], key=lambda walk: walk.cost)
    return best


def _tried(tracks: Sequence[SmoothedTrack], noise: Array, order: int, powers: Sequence[float] | Array) -> list[Walk]:
    walks = [Walk(order, 10.0 ** float(power), noise, np.inf) for power in powers]
    return [walk._replace(cost=cost(tracks, walk)) for walk in walks]


def smoothed(track: SmoothedTrack, walk: Walk, like: SmoothedTrack | None = None) -> Array:
    """The signal and its derivatives (N, order), per sample^k, given all outputs of the track.

    With `like`, another track with the same sensors and gaps, the linear map is the one by which that is smoothed.
    """
    from . import _kernels

    _, scale, f, columns, kept = _filtered(track, walk, True, like)
    states = np.empty((len(track.outputs), walk.order))
    _kernels.smooth(f, columns, *kept, states)
    return states * scale


def averaging_length(walk: Walk) -> float:
    """Approximate number of samples that the smoother averages over: level^(-1/(2 order))."""
    return float(walk.level ** (-0.5 / walk.order))


# ---- States of a ship along a record, smoothed from the record alone: from which runs of any model start.

CHANNELS = {"psi": ("psi", "r", "q"), "r": ("r", "q"), "u": ("u",), "v": ("v",), "x": ("x",), "y": ("y",)}
"""Measured state -> the states that its smoother gives, the state and its derivatives; later ones replace earlier."""


def smoothed_states(record: Record, times_s: np.ndarray) -> dict[str, np.ndarray]:
    """Smoothed states at some times, SI: symbol -> (T,); only those that the record measures.

    Every measured channel has a random walk of its own.  No model takes part, so that all models that are compared
    start from the same state, and no channel corrects another: where heading and yaw rate contradict each other, a run
    starts from both as they were measured.

    Parameters
    ----------
    record : a record without long gaps; shorter ones are bridged by the smoother.
    times_s : (T,) within the record.

    Returns
    -------
    psi (not wrapped), u, v, x, y; r and q = r_dot from the yaw rate, or else from the heading.  Channels with fewer
    than 16 samples are left out.
    """
    even = at_equal_steps(record)
    found: dict[str, np.ndarray] = {}
    for symbol, states in CHANNELS.items():
        values = samples(even, symbol)
        if values is not None and np.isfinite(values).sum() >= SHORTEST:
            derivatives = _derivatives(values.tobytes(), len(states)) / even.dt ** np.arange(len(states))
            found |= {s: np.interp(times_s, even.time_s, derivatives[:, rank]) for rank, s in enumerate(states)}
    return found


@lru_cache(maxsize=256)
def _derivatives(series: bytes, count: int) -> np.ndarray:
    """A series (N,) of float64 and its derivatives, (N, count), per sample^k; nan = gap.

    Kept for some series: many models are compared on the same records.
    """
    track = SmoothedTrack(np.frombuffer(series)[:, None], (0,))
    with np.errstate(divide="ignore"):  # a series without any noise has an infinite likelihood
        walk = fitted_walk([track], sensor_variances([track]), (count + 1, count + 2))
    return smoothed(track, walk)[:, :count]
