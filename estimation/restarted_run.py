"""A model simulated along a record with restarts at the measurements wherever the run is far from them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .free_run import start_state
from .series import series_of

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model
    from .series import Series

FAR = 3.0
"""Error of a run, in standard deviations of the measured channel, from which it is restarted at the measurements."""
SHORTEST_PIECE = 64
"""Samples of the first piece that is simulated after a restart."""
SHORTEST_HORIZON = 8
"""Samples between two restarts at least."""


def restarted_run(record: Record, model: Model, horizon_s: float | None = None) -> Record:
    """The record with its state channels simulated from its inputs, gaps where the record has them.

    The run starts from the record's first samples.  It is restarted at the measurements every `horizon_s` seconds
    (None: never for this reason) and wherever it is far from them or not finite.
    """
    from ..models.model import CHANNELS

    series = series_of(record, model)
    m = len(series.inputs)
    length = m if horizon_s is None else max(SHORTEST_HORIZON, round(horizon_s / series.dt))
    measured = np.full((m, len(model.states)), np.nan)
    measured[series.index[:, None], series.columns] = series.outputs
    spread = np.nanstd(series.outputs, axis=0)
    states, first, state = np.empty((m, len(model.states))), 0, start_state(model, series, series.start)
    while first < m:
        run = _until_far(model, series, state, measured[first : first + length], spread, first)
        states[first : first + len(run)] = run
        state = run[-1].copy()
        first += len(run)
        if first < m:
            known = np.isfinite(measured[first])
            state[~np.isfinite(state)] = 0.0
            state[known] = measured[first][known]
    observed = series.observe(states)
    channels = {}
    for column in series.columns:
        name = CHANNELS[model.states[column]]
        channels[name] = np.where(np.isfinite(record.column(name)), observed[:, column], np.nan)
    return record.with_channels(**channels)


def _until_far(
    model: Model, series: Series, state: np.ndarray, measured: np.ndarray, spread: np.ndarray, first: int
) -> np.ndarray:
    """The run from `state` at grid point `first` (at least one row), to the end of `measured` or until it is far off.

    It is simulated in pieces, each twice as long as the one before, so the cost stays linear in the number of samples
    however often the run is restarted.
    """
    from ..models.simulate import simulate

    n, piece = len(measured), SHORTEST_PIECE
    run, done = state[None], 0
    while done < n:
        stop = min(done + piece, n)
        inputs = np.ascontiguousarray(series.inputs[first + max(done - 1, 0) : first + stop])
        ahead = simulate(model, inputs, series.dt, run[-1])[min(done, 1) :]
        near = _count_near(ahead[:, series.columns], measured[done:stop][:, series.columns], spread)
        run = np.concatenate([run[:done], ahead[:near]])
        if near < len(ahead):
            return run if len(run) else state[None]
        done, piece = stop, 2 * piece
    return run


def _count_near(run: np.ndarray, measured: np.ndarray, spread: np.ndarray) -> int:
    """Number of leading rows of a run that are finite and near the measurements."""
    error = np.abs(np.where(np.isfinite(measured), run - measured, 0.0))
    bad = (~np.isfinite(run)).any(axis=1) | (error > FAR * np.maximum(spread, 1e-12)).any(axis=1)
    return int(np.argmax(bad)) if bad.any() else len(run)
