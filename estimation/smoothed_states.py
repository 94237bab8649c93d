"""States of a ship along a record, smoothed from the record alone: where runs of any model start honestly.

Every measured motion is smoothed by an integrated random walk (`observers.smoothing`); heading and yaw rate are two
sensors of one motion.  No model takes part, so that all models that are compared start from the same state.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .observers.smoothing import fitted_walk, smoothed
from .regression.smoothed import SHORTEST, at_equal_steps, sensor_variances, track_of
from .series import samples

if TYPE_CHECKING:
    from ..datasets.record import Record

MOTIONS = {"r": ("psi", "r", "q"), "u": ("u",), "v": ("v",), "x": ("x",), "y": ("y",)}
"""Motion by its symbol -> the states that its smoother gives: the motion and its derivatives."""
ORDERS = {"r": (3, 4)}
"""States of the random walks tried for a motion; (2, 3) where nothing is said."""


def smoothed_states(record: Record, times_s: np.ndarray) -> dict[str, np.ndarray]:
    """Smoothed states at some times, SI: symbol -> (T,); only those that the record measures.

    Parameters
    ----------
    record : a record without long gaps; shorter ones are bridged by the smoother.
    times_s : (T,) within the record.

    Returns
    -------
    psi (not wrapped), r and q = r_dot from heading and yaw rate, whichever there is; u, v, x, y.  Motions with fewer
    than 16 samples are left out.
    """
    even = at_equal_steps(record)
    found: dict[str, np.ndarray] = {}
    for motion, states in MOTIONS.items():
        if _measured(even, motion):
            derivatives = _derivatives(even, motion)
            for rank, symbol in enumerate(states):
                found[symbol] = np.interp(times_s, even.time_s, derivatives[:, rank])
    return found


def _measured(record: Record, motion: str) -> bool:
    channels = ("psi", "r") if motion == "r" else (motion,)
    return any((v := samples(record, s)) is not None and np.isfinite(v).sum() >= SHORTEST for s in channels)


def _derivatives(record: Record, motion: str) -> np.ndarray:
    """The motion and its derivatives (N, order) per s^k at the record's equal steps."""
    track = track_of(record, motion)
    walk = fitted_walk([track], sensor_variances([track]), ORDERS.get(motion, (2, 3)))
    return smoothed(track, walk) / record.dt ** np.arange(walk.order)
