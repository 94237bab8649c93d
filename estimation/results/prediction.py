"""One-step and free-run prediction of records, and their errors.

Free run: the model is simulated from the record's first samples with the measured rudder.  One step: every sample is
predicted from the one before.  Both are compared with the record's own samples and pooled over all records; heading
is unwrapped.  Units are those of the channels.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...datasets.columns import RUDDERS, TWIN
from ...datasets.instruments import hull_record, observed

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model
    from ..records.series import Series
    from .predictor import Predictor

CHANNELS = ("heading_rad", "yaw_rate_rad_s", "surge_m_s", "sway_m_s", "north_m", "east_m")
"""Channels that are scored, in the order of the record header; heading is unwrapped."""
BOUND = 10.0
"""A free run has diverged where a velocity or the yaw rate exceeds this multiple of the largest in the record."""
SYMBOLS = ("u", "v", "r", "psi", "x", "y")
RATES = ("u", "v", "r")


@dataclass(frozen=True)
class Prediction:
    """Observed and predicted samples of one channel of one record, (N,) each; gaps of `observed` are nan.

    `one` is only meaningful where `stepped` (N,) is true: behind a whole sample.
    """

    channel: str
    observed: np.ndarray
    free: np.ndarray
    one: np.ndarray
    stepped: np.ndarray
    diverged: bool

    def pair(self, horizon: str) -> tuple[np.ndarray, np.ndarray]:
        """Observed and predicted samples of the horizon `free` or `one`."""
        if horizon == "free":
            return self.observed, self.free
        return self.observed[self.stepped], self.one[self.stepped]


def predict(model: Model, record: Record, predictor: Predictor | None = None) -> list[Prediction]:
    """Free-run and one-step predictions of every state of the model that the record measures.

    `predictor` predicts in the model's place where it is given (a black box).
    Raises `CannotFit` where the record lacks an input or measures no state.
    """
    from ...models.model import CHANNELS as channel_of
    from ..records.series import kept_series_of
    from .predictor import ModelPredictor

    predictor = predictor or ModelPredictor(model)
    series = kept_series_of(record.turned(model.positive_rudder), model, SYMBOLS)
    free = _free(predictor, model, series)
    with np.errstate(all="ignore"):
        one, stepped = _one_step(predictor, model, series)
    predictions = []
    for place, state in enumerate(series.columns):
        symbol, observed = model.states[state], series.outputs[:, place]
        lost = _diverged(symbol, observed, free[:, state])
        predictions.append(Prediction(channel_of[symbol], observed, free[:, state], one[:, state], stepped, lost))
    return predictions


def free_runs(
    model: Model, record: Record, predictors: Sequence[Predictor]
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Channel -> observed samples (N,) and those of the free run of every predictor (m, N), as `predict` gives them."""
    from ...models.model import CHANNELS as channel_of
    from ..records.series import kept_series_of

    series = kept_series_of(record.turned(model.positive_rudder), model, SYMBOLS)
    runs = np.array([_free(predictor, model, series) for predictor in predictors])
    names = [channel_of[model.states[state]] for state in series.columns]
    return {
        name: (series.outputs[:, place], runs[:, :, state])
        for place, (name, state) in enumerate(zip(names, series.columns, strict=True))
    }


def _free(predictor: Predictor, model: Model, series: Series) -> np.ndarray:
    """States (N, n) of the free run at the samples of a series."""
    with np.errstate(all="ignore"):
        return series.observe(predictor.simulate(series.inputs, series.dt, _start(model, series)))


def predicted_record(model: Model, record: Record, horizon: str, predictor: Predictor | None = None) -> Record:
    """A record of the predictions with the horizon `free` or `one`, as the model's instruments show them.

    It has the inputs of the record in the model's rudder sign and each predicted channel (N,), nan where there is no
    finite prediction.  `predictor` as for `predict`.
    """
    found = predict(model, hull_record(record, model), predictor)
    return as_shown(
        model,
        record.turned(model.positive_rudder),
        {p.channel: p.free if horizon == "free" else np.where(p.stepped, p.one, np.nan) for p in found},
    )


def as_shown(model: Model, record: Record, runs: Mapping[str, np.ndarray]) -> Record:
    """Predicted channels (N,) of the hull as the model's instruments show them, beside the inputs of the record.

    The record has the model's rudder sign.  Predictions are nan where they are not finite.
    """
    inputs = {name: record.column(name) for name in (*RUDDERS, "propeller_rps", *TWIN) if record.has(name)}
    channels = {name: np.where(np.isfinite(values), values, np.nan) for name, values in runs.items()}
    return observed(replace(record, channels={**inputs, **channels}), model.instruments)


def prediction_scores(model: Model, records: Sequence[Record], predictor: Predictor | None = None) -> dict[str, Any]:
    """`rmse_*` and `r2_*` columns and the flag `diverged`, pooled over records."""
    found = [prediction for record in records for prediction in predict(model, record, predictor)]
    scores: dict[str, Any] = {"diverged": any(prediction.diverged for prediction in found)}
    for channel in CHANNELS:
        own = [prediction for prediction in found if prediction.channel == channel]
        for horizon in ("free", "one") if own else ():
            pairs = [prediction.pair(horizon) for prediction in own]
            rmse, r2 = error_and_r2(*(np.concatenate(parts) for parts in zip(*pairs, strict=True)))
            scores[f"rmse_{horizon}_{channel}"], scores[f"r2_{horizon}_{channel}"] = rmse, r2
    return scores


def error_and_r2(observed: np.ndarray, predicted: np.ndarray) -> tuple[float, float]:
    """Root mean square error and R^2 = 1 - SSE/SST of (N,) samples; nan where nothing was observed.

    R^2 is nan for an observation that does not vary; both are where a prediction is not finite.
    """
    return squares(observed, predicted).scores()


class Squares(NamedTuple):
    """Number of samples, sum of squared errors, and sum of squared deviations of the observations from their mean.

    Sums of several runs are added, so that each counts from its own mean.
    """

    n: int = 0
    error: float = 0.0
    spread: float = 0.0

    def plus(self, other: Squares) -> Squares:
        """The sums of both."""
        return Squares(self.n + other.n, self.error + other.error, self.spread + other.spread)

    def scores(self) -> tuple[float, float]:
        """Root mean square error and R^2, as `error_and_r2`."""
        if not self.n or not np.isfinite(self.error):
            return np.nan, np.nan
        return float(np.sqrt(self.error / self.n)), 1.0 - self.error / self.spread if self.spread > 0.0 else np.nan


def squares(observed: np.ndarray, predicted: np.ndarray) -> Squares:
    """The sums over (N,) samples, gaps of `observed` (nan) left out."""
    known = np.isfinite(observed)
    if not known.all():
        observed, predicted = observed[known], predicted[known]
    if not observed.size:
        return Squares()
    with np.errstate(all="ignore"):
        error = np.sum((predicted - observed) ** 2)
        spread = np.sum((observed - observed.mean()) ** 2)
    return Squares(observed.size, float(error), float(spread))


def _start(model: Model, series: Series) -> np.ndarray:
    """Initial state (n,) of a free run: the first samples; no yaw acceleration."""
    start = series.start.copy()
    for place, state in enumerate(series.columns):
        known = np.flatnonzero(np.isfinite(series.outputs[:, place]))
        if model.states[state] in ("x", "y") and known.size:
            start[state] = series.outputs[known[0], place]
    return start


def _one_step(predictor: Predictor, model: Model, series: Series) -> tuple[np.ndarray, np.ndarray]:
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


def _diverged(symbol: str, observed: np.ndarray, free: np.ndarray) -> bool:
    largest = np.nanmax(np.abs(observed)) if symbol in RATES else 0.0
    limit = BOUND * largest if largest > 0.0 else np.inf
    return divergence(free[:, None], np.array([limit])) is not None


def divergence(states: np.ndarray, limits: np.ndarray) -> int | None:
    """The first row of a run (N, n) that is not finite or has an absolute value above the limits (n,); None: none."""
    with np.errstate(invalid="ignore"):
        lost = ~(np.isfinite(states) & (np.abs(states) <= limits)).all(axis=1)
    return int(np.argmax(lost)) if lost.any() else None
