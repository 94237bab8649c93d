"""Runs of the filter over single segments; a fit's latest are kept, as fits come back to what they have just left.

What is kept is found by the content of everything that a run depends on beside the estimator itself.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Sequence
from threading import Lock
from typing import TYPE_CHECKING

import numpy as np

from .vector import CHANNELS, RMS

if TYPE_CHECKING:
    from ._arguments import Recorded, Run, Trace, Values
    from .estimator import Estimator
    from .settings import Setting

    Made = tuple[Run, Trace | None]
KEPT = 2
"""Runs of each segment that are kept."""


class Recent:
    """The latest runs, with their traces where these were asked for; shared by threads."""

    def __init__(self, most: int) -> None:
        self._made: OrderedDict[tuple, Made] = OrderedDict()
        self._most, self._lock = most, Lock()

    def get(self, key: tuple, traced: bool) -> Made | None:
        """The run of a key, None where it is not there, or not with a trace that is wanted."""
        with self._lock:
            found = self._made.get(key)
            if found is None or (traced and found[1] is None):
                return None
            self._made.move_to_end(key)
            return found

    def put(self, key: tuple, made: Made) -> None:
        """Keep a run, and let go of the one that was not asked for longest."""
        with self._lock:
            self._made[key] = made
            self._made.move_to_end(key)
            if len(self._made) > self._most:
                self._made.popitem(last=False)


def filtered(est: Estimator, s: Setting, segment: int, free: int | None, traced: bool, keep: bool) -> Made:
    """One segment through the filter, freely from sample `free` on (None: as the estimator says), traced or not, and
    kept or not.

    The arrays are shared: they are not written to.
    """
    from ._arguments import Run, Trace  # numba
    from ._kernel import run_filter

    free = est.released(segment) if free is None else free
    key = (segment, free, *_content(est, s, segment))
    found = est.recent.get(key, traced)
    if found is not None:
        return found
    recorded, values = _arguments(est, s, segment)
    size, nf, n = recorded.time.size, est.n_forces, est.shape.n
    nx = n + nf + (2 if values.vector[est.n_theta + RMS] > 0.0 else 0)
    run = Run(*(np.empty((size, m)) for m in (CHANNELS, CHANNELS, nx, CHANNELS)))
    rows = size if traced else 0
    trace = Trace(
        np.zeros((rows, nx, nx)), np.zeros((rows, CHANNELS, nx)), np.zeros((rows, CHANNELS, nx)),
        np.zeros((rows, CHANNELS)), np.zeros((rows, nf, nx)), np.zeros((rows, CHANNELS)),
    )  # fmt: skip
    run_filter(est.kernels.rhs, est.kernels.jacobian, est.shape, est.places, recorded, values, free, run, trace)
    made = run, trace if traced else None
    if keep:
        est.recent.put(key, made)
    return made


def pushes(est: Estimator, s: Setting, segment: int, run: Run, varied: Sequence[int], steps: np.ndarray) -> np.ndarray:
    """Changes (T, m, n) of the states over the next step by entries of the vector, along a run at the setting."""
    from ._pushes import run_pushes  # numba

    found = np.zeros((run.e.shape[0], len(varied), est.shape.n))
    if len(varied):
        recorded, values = _arguments(est, s, segment)
        model, which = (est.kernels.rhs, est.kernels.jacobian), np.array(varied, np.int64)
        run_pushes(*model, est.shape, est.places, recorded, values, which, steps, run.states, found)
    return found


def _arguments(est: Estimator, s: Setting, segment: int) -> tuple[Recorded, Values]:
    from ._arguments import Recorded, Values  # numba

    d, noise, vector = est.segments[segment], s.noise, s.vectors[segment].copy()
    vector[est.index["rudder_fault_time"]] -= d.offset_s
    added = np.zeros((d.time.size, est.n_forces + CHANNELS)) if s.added is None else s.added[segment]
    error, tau = np.array([est.rudder_sd, est.corner_error]), np.array([noise.correlation_time_s])
    recorded = Recorded(d.time, d.rudder, d.quiet, d.other, d.environment, d.measured, d.start, d.variance)
    return recorded, Values(vector, est.unit, noise.sensor_sd, noise.force_sd, tau, added, error)


def _content(est: Estimator, s: Setting, segment: int) -> tuple:
    """What a run of a segment depends on, of a setting: the time of a rudder fault of no size is nothing to it."""
    noise, vector = s.noise, s.vectors[segment]
    if vector[est.index["rudder_fault"]] == 0.0:
        vector = vector.copy()
        vector[est.index["rudder_fault_time"]] = 0.0
    added = None if s.added is None else s.added[segment].tobytes()
    numbers = (vector, noise.sensor_sd, noise.force_sd)
    return (*(part.tobytes() for part in numbers), noise.correlation_time_s, added)
