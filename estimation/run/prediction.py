"""Errors of records that are predicted: free runs (`run/run.py`), and every sample from the one before it.

Both are compared with the records' samples and pooled over all of them; heading is unwrapped.  Units are those of the
channels.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ...datasets.instruments import hull_record
from ...models.model import CHANNELS as channel_of
from ..records.series import series_of
from ..results.predictor import ModelPredictor
from .run import CHANNELS, as_shown, run_along, squares_of
from .squares import pooled, squares
from .stretch import SYMBOLS

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model
    from ..records.series import Series
    from ..results.predictor import Predictor


@dataclass(frozen=True)
class OneStep:
    """Observed samples (N,) of one channel of one record, what is predicted of each from the one before it, and where
    (N,) there is a whole sample before it; gaps are nan."""

    channel: str
    observed: np.ndarray
    predicted: np.ndarray
    stepped: np.ndarray

    @property
    def pair(self) -> tuple[np.ndarray, np.ndarray]:
        """Observed and predicted samples behind a whole sample."""
        return self.observed[self.stepped], self.predicted[self.stepped]


def one_step(model: Model, record: Record, predictor: Predictor | None = None) -> list[OneStep]:
    """One-step predictions, behind its instruments, of every state of the model that a record as it was read measures.

    `predictor` predicts in the model's place where it is given (a black box).
    Raises `CannotFit` where the record lacks an input or measures no state.
    """
    series = series_of(hull_record(record, model), model, SYMBOLS)
    with np.errstate(all="ignore"):
        states, stepped = _stepped(predictor or ModelPredictor(model), model, series)
    return [
        OneStep(channel_of[model.states[state]], series.outputs[:, place], states[:, state], stepped)
        for place, state in enumerate(series.columns)
    ]


def stepped_record(model: Model, record: Record, predictor: Predictor | None = None) -> Record:
    """A record of the one-step predictions as the model's instruments show them.

    It has the inputs of the record in the model's rudder sign and each predicted channel (N,), nan where there is no
    finite prediction.  `predictor` as for `one_step`.
    """
    found = one_step(model, record, predictor)
    turned = record.turned(model.positive_rudder)
    return as_shown(model, turned, {p.channel: np.where(p.stepped, p.predicted, np.nan) for p in found})


def prediction_scores(model: Model, records: Sequence[Record], predictor: Predictor | None = None) -> dict[str, Any]:
    """`rmse_*` and `r2_*` columns and the flag `diverged`, pooled over records as they were read.

    Raises `CannotFit` where a record lacks an input or measures no state.
    """
    runs = [run_along(model, record, predictor) for record in records]
    steps = [step for record in records for step in one_step(model, record, predictor)]
    scores: dict[str, Any] = {"diverged": any(run.diverged for run in runs)}
    free = squares_of(runs)
    for channel in (c for c in CHANNELS if c in free):
        sums = {"free": free[channel], "one": pooled(squares(*s.pair) for s in steps if s.channel == channel)}
        for horizon, own in sums.items():
            scores[f"rmse_{horizon}_{channel}"], scores[f"r2_{horizon}_{channel}"] = own.scores()
    return scores


def _stepped(predictor: Predictor, model: Model, series: Series) -> tuple[np.ndarray, np.ndarray]:
    """Predictions (N, n) of every sample from the one before it, and where (N,) there is a whole one before it.

    A state that the record does not measure is held at its initial value; the yaw acceleration of a second-order
    response model is the central difference of the yaw rate.
    """
    place = series.index + series.part
    states = np.empty((len(place), series.start.size))
    states[:] = series.start
    states[:, series.columns] = series.outputs
    if model.states[0] == "w":
        states[:, 0] = np.gradient(states[:, model.states.index("r")], place * series.dt)
    inputs = series.observe(series.inputs)
    ahead = np.full_like(states, np.nan)
    ahead[1:] = predictor.step(states[:-1], inputs, series.dt)
    stepped = np.zeros(len(place), dtype=bool)
    stepped[1:] = (np.abs(np.diff(place) - 1.0) < 1e-3) & np.isfinite(states[:-1]).all(axis=1)
    return ahead, stepped
