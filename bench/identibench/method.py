"""Every method of helmbench as a model of identibench: `build_model(context)` -> callable (u, y_init, attrs) -> y.

A model is run from the state at the end of the initial window, with the inputs that follow.  The state is smoothed
from the window alone, as for helmbench's errors ahead (`estimation.observers.smoothing`); what the window does
not measure is that of a run through the window.  The predictions within the window are those of that run, not the
samples that were given.  A window of fewer than 16 samples gives the free run from its first sample, as helmbench's
scores have it.

Columns of which the model has no state, such as the roll, are held at their mean over the window.  The wind's angle
turns with the predicted yaw rate r: d(alpha)/dt = c r, with c of the training records, rounded to -1, 0 or 1: a wind
that keeps its direction over the earth turns against the ship, and the sign depends on how alpha is counted.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from typing import Any

import numpy as np

from ...datasets.instruments import hull_record
from ...datasets.record import Record, RecordMeta
from ...datasets.signals import integral
from ...estimation.estimates.estimate import Estimate, predictor_of
from ...estimation.observers.smoothing import SHORTEST, smoothed_states
from ...estimation.records.series import series_of
from ...estimation.run.run import as_shown
from ...estimation.run.stretch import SYMBOLS
from ...methods.base import Method
from ...methods.registry import make
from ...models.argument_types import typed
from ...models.errors import BadInput
from ...models.model import CHANNELS, Model, resolve
from .columns import MEANINGS, WIND_ANGLE, check_columns, record_of, side_of, step_of


@typed
def identibench_model(
    method: Method | str, model: Model | str | PathLike[str]
) -> Callable[[Any], Callable[..., np.ndarray]]:
    """A method of helmbench as `build_model` of `identibench.run_benchmark`.

    The method is fitted to the training sequences of the benchmark.  Its hyperparameters are options of the method; an
    option `seed` is the benchmark's.

    Parameters
    ----------
    method : a method, or its text: 'output-error', 'arx,order=3' (`list_methods`); each fit takes a copy.
    model : the structure: a model, or a vessel id, a family id or the path of a model.json.

    Returns
    -------
    A function of identibench's `TrainingContext`.  It gives a callable (u (T, inputs), y_init (W, outputs), attrs) -> y
    (T, outputs) with W >= 1, not finite where a run diverges; its `estimate` is the fit, its `held` names the columns
    that the model does not predict.

    Raises
    ------
    BadInput : an unknown method or model.  When the function is called: a column that helmbench cannot read, a file of
        another set than the ship's without its sampling rate, or a hyperparameter that the method does not have.
    CannotFit, FitFailed : when the function is called, as `Method.fit`.
    """
    structure = model if isinstance(model, Model) else resolve(model)
    if isinstance(method, str):
        make(method)

    def build(context: Any) -> FittedModel:
        fitter = _configured(method, context)
        u_cols, y_cols = tuple(context.spec.u_cols), tuple(context.spec.y_cols)
        check_columns((*u_cols, *y_cols))
        parts = [_Sequence(u_cols, y_cols, *part) for part in context.get_train_sequences()]
        records = [hull_record(part.record(f"train-{i}"), structure) for i, part in enumerate(parts, start=1)]
        estimate = fitter.fit(records, structure)
        return FittedModel(estimate, u_cols, y_cols, _turn(parts))

    return build


def _configured(method: Method | str, context: Any) -> Method:
    """A new method with the hyperparameters and the seed of a benchmark."""
    fitter = make(method) if isinstance(method, str) else type(method)(**method.get_params(deep=False))
    seed = {"seed": context.seed} if "seed" in fitter.options else {}
    return fitter.set_params(**(seed | dict(context.hyperparameters)))


@dataclass(frozen=True)
class _Sequence:
    """One file of a benchmark: inputs u (N, nu), outputs y (N, ny), nan where they are not known, and attributes."""

    u_cols: tuple[str, ...]
    y_cols: tuple[str, ...]
    u: np.ndarray
    y: np.ndarray
    attrs: Mapping[str, object]

    @property
    def names(self) -> tuple[str, ...]:
        return (*self.u_cols, *self.y_cols)

    @property
    def step_s(self) -> float:
        return step_of(self.attrs, self.names)

    def columns(self) -> dict[str, np.ndarray]:
        """Name -> (N,)."""
        return dict(zip(self.names, np.asarray(np.hstack([self.u, self.y]), float).T, strict=True))

    def record(self, name: str) -> Record:
        meta = RecordMeta(positive_rudder=side_of(self.attrs, self.names))  # ty: ignore[invalid-argument-type]
        return record_of(self.columns(), self.step_s, name, meta)


@dataclass(frozen=True)
class FittedModel:
    """A fitted method as a model of identibench.

    `turn` is c of the wind's angle, d(alpha)/dt = c r.
    """

    estimate: Estimate
    u_cols: tuple[str, ...]
    y_cols: tuple[str, ...]
    turn: int

    @property
    def held(self) -> tuple[str, ...]:
        """Columns that the model does not predict."""
        return tuple(name for name in self.y_cols if not self._told(name))

    def _told(self, name: str) -> bool:
        states = self.estimate.model.states
        if name in WIND_ANGLE:
            return self.turn != 0 and "r" in states and set(WIND_ANGLE) <= set(self.y_cols)
        return MEANINGS[name][0] in {CHANNELS[s] for s in states if s in SYMBOLS}

    def __call__(self, u: np.ndarray, y_init: np.ndarray, attrs: Mapping[str, object]) -> np.ndarray:
        """Predictions (T, outputs) under inputs u (T, inputs) after the window y_init (W, outputs); SI as in the files.

        Raises
        ------
        BadInput : the window is empty.
        """
        window = len(y_init)
        if not window:
            hint = "give the task an init_window of 1 or more"
            raise BadInput("helmbench's models start from measured samples, and the initial window is empty", hint=hint)
        y = np.full((len(u), len(self.y_cols)), np.nan)
        y[:window] = y_init
        part = _Sequence(self.u_cols, self.y_cols, u, y, attrs)
        shown = self._run(part.record("test"), window)
        found = np.tile(y[:window].mean(axis=0), (len(u), 1))
        for place, name in enumerate(self.y_cols):
            if self._told(name) and name not in WIND_ANGLE:
                channel, factor = MEANINGS[name]
                found[:, place] = shown.column(channel) / factor
        if self._told(WIND_ANGLE[0]):
            places = [self.y_cols.index(name) for name in WIND_ANGLE]
            swung = self.turn * _turned_by(shown.column("yaw_rate_rad_s"), part.step_s)
            found[:, places] = _turned(y[:window, places], swung)
        return found

    def _run(self, record: Record, window: int) -> Record:
        """The predicted channels of the model's states, of which the first `window` samples are measured."""
        model = self.estimate.model
        if window < SHORTEST:
            return self.estimate.simulate(record)
        states = _states(self.estimate, hull_record(record, model), window)
        turned = record.turned(model.positive_rudder)
        return as_shown(model, turned, {CHANNELS[s]: states[:, i] for i, s in enumerate(model.states) if s in SYMBOLS})


def _states(estimate: Estimate, hull: Record, window: int) -> np.ndarray:
    """States (T, n) of a run through the window and, from the state at its end, of the run after it."""
    model, predictor = estimate.model, predictor_of(estimate)
    series = series_of(hull, model, SYMBOLS)
    measured = hull.slice(0, window)
    ends = smoothed_states(measured, measured.time_s[[0, -1]])
    hidden = [i for i, symbol in enumerate(model.states) if symbol == "w"]
    with np.errstate(all="ignore"):
        before = predictor.simulate(series.inputs[:window], series.dt, _overlaid(series.start, model, ends, 0))
        start = before[-1].copy()
        start[hidden] = series.start[hidden]
        after = predictor.simulate(series.inputs[window - 1 :], series.dt, _overlaid(start, model, ends, 1))
    return np.vstack([before, after[1:]])


def _overlaid(state: np.ndarray, model: Model, known: Mapping[str, np.ndarray], at: int) -> np.ndarray:
    """A state (n,) with what is known of it; the yaw acceleration q takes the place of the hidden w."""
    found = state.copy()
    for place, symbol in enumerate(model.states):
        symbol = "q" if symbol == "w" else symbol
        if symbol in known:
            found[place] = known[symbol][at]
    return found


def _turn(parts: Sequence[_Sequence]) -> int:
    """How the wind's angle turns with the yaw rate, -1, 0 or 1: least squares over the steps of training sequences."""
    if not {*WIND_ANGLE, "r"} <= set(parts[0].y_cols):
        return 0
    product, square = 0.0, 0.0
    for part in parts:
        columns = part.columns()
        alpha_x, alpha_y, r = (columns[name] for name in (*WIND_ANGLE, "r"))
        swing, turned = np.diff(np.unwrap(np.arctan2(alpha_y, alpha_x))), np.diff(_turned_by(r, part.step_s))
        product, square = product + float(swing @ turned), square + float(turned @ turned)
    return int(np.clip(np.round(product / square), -1, 1)) if square > 0.0 else 0


def _turned_by(yaw_rate: np.ndarray, step_s: float) -> np.ndarray:
    """Angle (N,) that a yaw rate (N,) turns from the first sample on."""
    return integral(yaw_rate, step_s * np.arange(len(yaw_rate)))


def _turned(window: np.ndarray, swung: np.ndarray) -> np.ndarray:
    """Cosine and sine (T, 2) of an angle that turns by `swung` (T,): from the window's (W, 2) first sample within the
    window, then from its last."""
    first = len(window) - 1
    angle = np.arctan2(window[[0, -1], 1], window[[0, -1], 0])
    size = np.hypot(window[[0, -1], 0], window[[0, -1], 1])
    late = (np.arange(len(swung)) > first).astype(int)
    turned = angle[late] + swung - swung[[0, first]][late]
    return size[late, None] * np.column_stack([np.cos(turned), np.sin(turned)])
