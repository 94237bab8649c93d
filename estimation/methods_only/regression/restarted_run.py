"""A model simulated along a record with restarts at the measurements wherever the run is far from them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...records.series import series_of
from ...simulation.free_run import start_state

if TYPE_CHECKING:
    from ....datasets.record import Record
    from ....models.model import Model
    from ...records.series import Series

FAR = 3.0
"""Error of a run, in standard deviations of the measured channel, from which it is restarted at the measurements."""
SHORTEST_PIECE = 8
"""Samples of the first piece that is simulated after a restart."""
SHORTEST_HORIZON = 8
"""Samples between two restarts at least."""


def restarted_run(record: Record, model: Model, horizon_s: float | None = None) -> Record:
    """The record with its state channels simulated from its inputs, gaps where the record has them.

    The run starts from the record's first samples.  It is restarted at the measurements every `horizon_s` seconds
    (None: never for this reason) and wherever it is far from them or not finite.
    """
    from ....models.model import CHANNELS

    series = series_of(record, model)
    observed = series.observe(_states(model, series, horizon_s))
    channels = {}
    for column in series.columns:
        name = CHANNELS[model.states[column]]
        channels[name] = np.where(np.isfinite(record.column(name)), observed[:, column], np.nan)
    return record.with_channels(**channels)


def _states(model: Model, series: Series, horizon_s: float | None) -> np.ndarray:
    """States (M, n) of the restarted run on the grid of the series."""
    from ....models.simulate import substeps, variant
    from . import _restart_kernels

    m = len(series.inputs)
    length = m if horizon_s is None else max(SHORTEST_HORIZON, round(horizon_s / series.dt))
    measured = np.full((m, len(model.states)), np.nan)
    measured[series.index[:, None], series.columns] = series.outputs
    far = FAR * np.maximum(np.nanstd(series.outputs, axis=0), 1e-12)
    kernels, theta = variant(model, series.inputs.shape[1], model.theta)
    count, states = substeps(model, series.dt), np.empty((m, len(model.states)))
    _restart_kernels.restarted(
        kernels.simulate, start_state(model, series, series.start), np.ascontiguousarray(series.inputs), theta,
        series.dt / count, count, measured, np.asarray(series.columns, dtype=np.int64), far, length, SHORTEST_PIECE,
        states,
    )  # fmt: skip
    return states
