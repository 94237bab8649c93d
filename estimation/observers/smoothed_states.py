"""States of a ship along a record, smoothed from the record alone: from which runs of any model start.

Every measured channel is smoothed by an integrated random walk of its own (`observers.smoothing`).  No model takes
part, so that all models that are compared start from the same state, and no channel corrects another: where heading
and yaw rate contradict each other, a run starts from both as they were measured.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ...datasets.record import Record
from ..records.series import at_equal_steps, samples
from .smoothing import SHORTEST, SmoothedTrack, fitted_walk, sensor_variances, smoothed

CHANNELS = {"psi": ("psi", "r", "q"), "r": ("r", "q"), "u": ("u",), "v": ("v",), "x": ("x",), "y": ("y",)}
"""Measured state -> the states that its smoother gives, the state and its derivatives; later ones replace earlier."""


def smoothed_states(record: Record, times_s: np.ndarray) -> dict[str, np.ndarray]:
    """Smoothed states at some times, SI: symbol -> (T,); only those that the record measures.

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
