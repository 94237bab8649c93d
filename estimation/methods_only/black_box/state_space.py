"""Learnt state-space models as predictors: a state from past samples, and a map that moves it on by a step.

Signals are those of `rows`: velocities and yaw rate z, inputs w, both averaged over one step h and scaled.  The past of
a sample is

    p(t) = z(t), z(t - h), ..., z(t - (l - 1) h), w(t - h), ..., w(t - l h)

and the model is s(t) = begin(p(t)), s(t + h) = advance(s(t), w(t)); the first k entries of a state are the outputs z.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from ....datasets.record import Record
from ....models.errors import CannotFit, FitFailed
from ....models.model import Model
from ...results.fit import Fit
from .compiled import OUTSIDE
from .narx import SteppedPredictor, at_earlier
from .rows import SYMMETRIC, Signals, averaged_signals, outputs_of, signals_of
from .scaled import DIGITS, LARGEST, inverse_spread


class System(Protocol):
    """A learnt state-space model of scaled signals."""

    def begin(self, past: np.ndarray) -> np.ndarray:
        """States (N, m) after pasts (N, l (k + nu)); the first k columns are the latest outputs."""
        ...

    def advance(self, state: np.ndarray, inputs: np.ndarray) -> np.ndarray:
        """States (N, m) one step after states (N, m) under inputs (N, nu)."""
        ...


class SignalScales(NamedTuple):
    """Means and inverse spreads of outputs (k,) and inputs (nu,); a constant signal has the inverse spread zero."""

    z_mean: np.ndarray
    z_scale: np.ndarray
    w_mean: np.ndarray
    w_scale: np.ndarray

    def z(self, values: np.ndarray) -> np.ndarray:
        """Scaled outputs (N, k)."""
        return (values - self.z_mean) * self.z_scale

    def w(self, values: np.ndarray) -> np.ndarray:
        """Scaled inputs (N, nu)."""
        return (values - self.w_mean) * self.w_scale

    def unscaled(self, z: np.ndarray) -> np.ndarray:
        """Outputs (N, k) in SI units."""
        return z / np.where(self.z_scale > 0.0, self.z_scale, np.inf) + self.z_mean


@dataclass(frozen=True)
class Training:
    """Scaled and averaged signals of records for a step of `stride` samples of dt seconds."""

    model: Model
    stride: int
    dt: float
    scales: SignalScales
    parts: tuple[Signals, ...]

    def fit(self, system: System, lags: int) -> Fit:
        """The system as a predictor of the model's states, whose pasts have so many steps, as a method's result."""
        names = tuple(self.model.states), outputs_of(self.model)
        predictor = StateSpacePredictor(*names, self.stride * self.dt, lags, self.scales, system)
        return Fit(np.empty(0), predictor=predictor, extra={"rows": sum(len(part.whole) for part in self.parts)})


def training_of(records: Sequence[Record], model: Model, stride: int) -> Training:
    """Signals of records for identification.

    Raises
    ------
    CannotFit : a channel is missing, or no record is as long as a step.
    FitFailed : the signals are not finite.
    """
    given = signals_of(records, model)
    parts = [part for part in (averaged_signals(one, stride) for one in given) if part.whole.any()]
    if not parts:
        raise CannotFit(f"no usable samples for a step of {stride} samples")
    z, w = (
        np.vstack([part.outputs[part.whole] for part in parts]),
        np.vstack([part.inputs[part.whole] for part in parts]),
    )
    every = [rows for part in parts for rows in (part.outputs, part.inputs)]
    if not all(np.isfinite(rows).all() and np.abs(rows).max() < LARGEST for rows in every):
        raise FitFailed("velocities, yaw rate or inputs are not finite")
    scales = SignalScales(*_scales(z, outputs_of(model)), *_scales(w, tuple(model.inputs)))
    scaled = [
        part._replace(outputs=np.round(scales.z(part.outputs), DIGITS), inputs=np.round(scales.w(part.inputs), DIGITS))
        for part in parts
    ]
    return Training(model, stride, given[0].dt, scales, tuple(scaled))


def _scales(values: np.ndarray, symbols: tuple[str, ...]) -> tuple[np.ndarray, np.ndarray]:
    mean = np.where([symbol in SYMMETRIC for symbol in symbols], 0.0, values.mean(axis=0))
    return mean, inverse_spread(values, mean)


def pasts(signals: Signals, place: np.ndarray, stride: int, lags: int) -> np.ndarray:
    """Pasts (M, l (k + nu)) of samples `place` (M,); before the first sample all is as at the first."""
    earlier = np.maximum(place[:, None] - stride * np.arange(lags + 1), 0)
    z, w = signals.outputs[earlier[:, :-1]], signals.inputs[earlier[:, 1:]]
    return np.hstack([z.reshape(len(place), -1), w.reshape(len(place), -1)])


@dataclass(frozen=True)
class StateSpacePredictor(SteppedPredictor):
    """A learnt state-space model."""

    lags: int
    scales: SignalScales
    system: System

    def run(self, first: np.ndarray, driven: np.ndarray) -> np.ndarray:
        z, w = self.scales.z(first[None]), self.scales.w(driven)
        still = Signals(self.step_s, z, w[:1], np.ones(1, bool))
        state = self.system.begin(pasts(still, np.zeros(1, np.int64), 1, self.lags))
        found = np.full((len(w), len(first)), np.nan)
        found[0] = z[0]
        for step in range(len(w) - 1):
            if not np.abs(state).max() < OUTSIDE:
                break
            state = self.system.advance(state, w[step : step + 1])
            found[step + 1] = state[0, : len(first)]
        run = self._unscaled(found, first)
        run[0] = first
        return run

    def ahead(self, z: np.ndarray, inputs: np.ndarray, time: np.ndarray, dt: float) -> np.ndarray:
        back = self.step_s * np.arange(self.lags + 1)
        past = [self.scales.z(z if not t else at_earlier(z, time, t)) for t in back[:-1]]
        past += [self.scales.w(at_earlier(inputs, time, t)) for t in back[1:]]
        begun = self.system.begin(np.hstack(past))
        found = self.system.advance(begun, self.scales.w(inputs))[:, : z.shape[1]]
        return z + dt / self.step_s * (self._unscaled(found, z) - z)

    def _unscaled(self, scaled: np.ndarray, before: np.ndarray) -> np.ndarray:
        """Outputs (N, k) in SI units; one that was constant in training stays as it was before."""
        far = np.abs(scaled).max(axis=1, keepdims=True) > OUTSIDE
        found = np.where(self.scales.z_scale > 0.0, self.scales.unscaled(scaled), before)
        return np.where(far | ~np.isfinite(scaled), np.nan, found)
