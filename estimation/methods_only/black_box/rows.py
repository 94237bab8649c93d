"""Rows of a nonlinear difference equation with lags (NARX) from records.

With step h, outputs z (u, v, r of a 3-DOF model, r of a response model) and inputs w,

    (z(t + h) - z(t)) / h = f(z(t), z(t - h), ..., w(t), w(t - h), ...)

Outputs and inputs are averaged over one step by the same window first: it keeps linear relations between them and
takes out sensor noise.  Heading and position are no features: the ship's behaviour does not depend on them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ....datasets.record import Record
from ....datasets.signals import bridged
from ....models.errors import CannotFit
from ....models.model import Model
from ...records.series import at_equal_steps, inputs_of, require, yaw_rate_of

OUTPUTS = ("u", "v", "r")
SYMMETRIC = ("v", "r", "delta")
"""Channels whose zero is that of the ship's symmetry: they are scaled, but not moved."""
BRIDGED = 5
"""Samples of a gap that is bridged."""


class Lags(NamedTuple):
    """Step h as a number of samples, and how many values of the outputs and of the inputs f takes."""

    stride: int = 1
    outputs: int = 1
    inputs: int = 1

    def features(self, model: Model) -> tuple[str, ...]:
        """Symbol of each feature (d,)."""
        return outputs_of(model) * self.outputs + tuple(model.inputs) * self.inputs


class Signals(NamedTuple):
    """Outputs (N, k) and inputs (N, nu) of a record every dt seconds; `whole` (N,): not within a long gap."""

    dt: float
    outputs: np.ndarray
    inputs: np.ndarray
    whole: np.ndarray


def outputs_of(model: Model) -> tuple[str, ...]:
    """States of the model that a black box predicts; the others follow from them by integration."""
    return tuple(symbol for symbol in OUTPUTS if symbol in model.states)


def signals_of(records: Sequence[Record], model: Model) -> list[Signals]:
    """Every record at the steps of the first.

    Raises
    ------
    CannotFit : a record lacks a channel, or a channel has no samples.
    """
    dt = records[0].dt
    return [_at_steps(_signals(at_equal_steps(record), model), dt) for record in records]


def _signals(record: Record, model: Model) -> Signals:
    given = {s: yaw_rate_of(record) if s == "r" else require(record, s) for s in outputs_of(model)}
    driven = inputs_of(record, model)
    columns = [*given.values(), *(driven[s] for s in model.inputs)]
    whole = ~np.any([_in_long_gap(values) for values in columns], axis=0)
    z, w = (
        np.column_stack([bridged(values, record.time_s) for values in part])
        for part in (columns[: len(given)], columns[len(given) :])
    )
    return Signals(record.dt, z, w, whole)


def _in_long_gap(values: np.ndarray) -> np.ndarray:
    """Where (N,) a series has more than BRIDGED missing samples in a row."""
    finite = np.isfinite(values)
    if finite.all():
        return ~finite
    known, place = np.flatnonzero(finite), np.arange(len(values))
    after = np.searchsorted(known, place)
    right = np.append(known, len(values))[after]
    left = np.append(-1, known)[np.searchsorted(known, place, side="right")]
    return (right - left - 1 > BRIDGED) & ~finite


def _at_steps(signals: Signals, dt: float) -> Signals:
    """Signals at another step, interpolated."""
    if abs(signals.dt - dt) < 1e-3 * dt:
        return signals._replace(dt=dt)
    time = signals.dt * np.arange(len(signals.whole))
    grid = np.arange(0.0, time[-1] + 1e-6 * dt, dt)
    z, w = (np.column_stack([np.interp(grid, time, column) for column in part.T]) for part in signals[1:3])
    return Signals(dt, z, w, np.interp(grid, time, signals.whole.astype(float)) > 0.99)


def averaged_signals(signals: Signals, window: int) -> Signals:
    """Means over `window` samples, everything by the same window."""
    if window == 1:
        return signals
    if len(signals.whole) < window:
        return Signals(signals.dt, signals.outputs[:0], signals.inputs[:0], signals.whole[:0])
    z, w, whole = (_means(np.asarray(part, float), window) for part in signals[1:])
    return Signals(signals.dt, z, w, whole > 1.0 - 0.5 / window)


def _means(values: np.ndarray, window: int) -> np.ndarray:
    total = np.cumsum(np.concatenate([np.zeros_like(values[:1]), values]), axis=0)
    return (total[window:] - total[:-window]) / window


def whole_places(whole: np.ndarray, before: int, after: int) -> np.ndarray:
    """Places (M,) from `before` samples before which to `after` samples behind which every sample is whole (N,)."""
    lost, place = np.concatenate([[0], np.cumsum(~whole)]), np.arange(before, len(whole) - after)
    return place[lost[place + after + 1] == lost[place - before]]


def lagged(values: np.ndarray, place: np.ndarray, stride: int, count: int) -> list[np.ndarray]:
    """Values (N, c) at places (M,) and `count` - 1 strides before, the latest first: `count` arrays (M, c)."""
    return [values[place - j * stride] for j in range(count)]


def narx_rows(parts: Sequence[Signals], lags: Lags) -> tuple[np.ndarray, np.ndarray]:
    """Features (N, d) and increments over the step, per second (N, k), of all records.

    Raises
    ------
    CannotFit : there are no more rows than features.
    """
    x, y = [], []
    for signals in parts:
        s, longest = lags.stride, max(lags.outputs, lags.inputs)
        own = averaged_signals(signals, s)
        place, z, w = whole_places(own.whole, s * (longest - 1), s), own.outputs, own.inputs
        x.append(np.hstack([*lagged(z, place, s, lags.outputs), *lagged(w, place, s, lags.inputs)]))
        y.append((z[place + s] - z[place]) / (s * own.dt))
    n = sum(map(len, y))
    d = parts[0].outputs.shape[1] * lags.outputs + parts[0].inputs.shape[1] * lags.inputs
    if n <= d:
        raise CannotFit(f"{n} usable rows for {d} features")
    return (x[0], y[0]) if len(x) == 1 else (np.vstack(x), np.vstack(y))
