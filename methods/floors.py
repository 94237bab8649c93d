"""Predictions without identification, which every method must beat."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..datasets.record import Record
from ..estimation.methods_only.black_box.narx import one_ahead, whole_run
from ..estimation.methods_only.black_box.rows import outputs_of, signals_of
from ..estimation.results.fit import Fit
from ..models.errors import FitFailed
from ..models.model import Model
from .base import method
from .learner import black_box_fit, in_order


@dataclass(frozen=True)
class ConstantPredictor:
    """Outputs (velocities and yaw rate) that do not change: `values`, nan for those of the initial state.

    In a free run the outputs take these values from the sample after the first on; one sample ahead always.  See
    `estimation.results.predictor.Predictor`.
    """

    states: tuple[str, ...]
    outputs: tuple[str, ...]
    values: tuple[float, ...]

    def simulate(self, inputs: np.ndarray, dt: float, start: np.ndarray) -> np.ndarray:
        """Free run, as `estimation.results.predictor.Predictor`."""
        first = dict(zip(self.states, start, strict=True))
        held = {name: np.full(len(inputs), value) for name, value in self._held(first).items()}
        for name, run in held.items():
            run[0] = first[name]
        states = whole_run(self.states, start, held, dt)
        states[0] = start
        return states

    def step(self, states: np.ndarray, inputs: np.ndarray, dt: float) -> np.ndarray:
        """One sample ahead of each row, as `estimation.results.predictor.Predictor`."""
        ahead = self._held(dict(zip(self.states, states.T, strict=True)))
        return one_ahead(
            self.states, states, {name: np.zeros(len(states)) + value for name, value in ahead.items()}, dt
        )

    def _held(self, now: dict) -> dict:
        return {n: now[n] if np.isnan(value) else value for n, value in zip(self.outputs, self.values, strict=True)}


@method("mean", "mean speeds and yaw rate of the training records", kind="floor")
def MeanRates(records: Sequence[Record], model: Model) -> Fit:
    """Surge, sway and yaw rate are always those of the training records on average; the rudder is not looked at.

    R^2 of a method compares with the mean of the held-out record itself, which nobody knows before; this is the same
    floor with what is known.  A response model has the yaw rate only.
    """
    parts = signals_of(in_order(records), model)
    means = np.concatenate([part.outputs for part in parts]).mean(axis=0)
    if not np.isfinite(means).all():
        raise FitFailed("the records' means are not finite")
    return black_box_fit(ConstantPredictor(tuple(model.states), outputs_of(model), tuple(map(float, means))))


@method("straight-line", "straight on at the initial speed, without turning", kind="floor")
def StraightLine(records: Sequence[Record], model: Model) -> Fit:
    """The ship keeps the surge and sway speed of its start and does not turn: its yaw rate is zero.

    One sample ahead, the speeds are those of the sample before.  Nothing is learnt from the training records.
    """
    signals_of(records, model)  # records that no method can use are refused
    outputs = outputs_of(model)
    values = tuple(0.0 if name == "r" else np.nan for name in outputs)
    return black_box_fit(ConstantPredictor(tuple(model.states), outputs, values))
