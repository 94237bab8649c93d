"""Runs of the filter over single segments; a fit's latest are kept, as fits come back to what they have just left.

What is kept is found by the content of everything that a run depends on beside the estimator itself.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping
from threading import Lock
from typing import TYPE_CHECKING

import numpy as np

from .vector import CHANNELS, RMS

if TYPE_CHECKING:
    from ....models.kernels import Kernels
    from ._arguments import FilterRun, FilterSizes, Recorded, Trace, Values
    from .settings import Setting

    Made = tuple[FilterRun, Trace | None]
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


def run_of(
    kernels: Kernels,
    shape: FilterSizes,
    places: np.ndarray,
    recorded: Recorded,
    values: Values,
    free: int,
    traced: bool,
) -> Made:
    """A segment through the filter, freely from sample `free` on, traced or not.

    places : the state of each channel, as `Estimator.places`.
    """
    from ._arguments import FilterRun, Trace  # numba
    from ._kernel import run_filter

    size, nf = recorded.time.size, shape.n_forces
    nx = shape.n + nf + (2 if values.vector[shape.n_theta + RMS] > 0.0 else 0)
    run = FilterRun(*(np.empty((size, m)) for m in (CHANNELS, CHANNELS, nx, CHANNELS)))
    rows = size if traced else 0
    trace = Trace(
        np.zeros((rows, nx, nx)), np.zeros((rows, CHANNELS, nx)), np.zeros((rows, CHANNELS, nx)),
        np.zeros((rows, CHANNELS)), np.zeros((rows, nf, nx)), np.zeros((rows, CHANNELS)),
    )  # fmt: skip
    run_filter(kernels.rhs, kernels.jacobian, shape, places, recorded, values, free, run, trace)
    return run, trace if traced else None


def content_of(s: Setting, segment: int, index: Mapping[str, int]) -> tuple:
    """What a run of a segment depends on, of a setting: the time of a rudder fault of no size is nothing to it.

    index : name -> entry of the parameter vector.
    """
    noise, vector = s.noise, s.vectors[segment]
    if vector[index["rudder_fault"]] == 0.0:
        vector = vector.copy()
        vector[index["rudder_fault_time"]] = 0.0
    added = None if s.added is None else s.added[segment].tobytes()
    numbers = (vector, noise.sensor_sd, noise.force_sd)
    return (*(part.tobytes() for part in numbers), noise.correlation_time_s, added)
