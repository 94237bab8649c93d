"""Predictions without identification, which every method must beat."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..datasets.record import Record
from ..estimation.methods_only.black_box.narx import SteppedPredictor
from ..estimation.methods_only.black_box.rows import outputs_of, signals_of
from ..estimation.results.fit import Fit
from ..models.errors import FitFailed
from ..models.model import Model
from .base import method
from .learner import black_box_fit, in_order


@dataclass(frozen=True)
class ConstantPredictor(SteppedPredictor):
    """Outputs that do not change: `values`, nan for those of the initial state.

    In a free run the outputs take these values from the step after the first sample on; one sample ahead always.
    """

    values: tuple[float, ...]

    def run(self, first: np.ndarray, driven: np.ndarray) -> np.ndarray:
        return np.vstack([first, np.tile(self._held(first), (len(driven) - 1, 1))])

    def ahead(self, z: np.ndarray, inputs: np.ndarray, time: np.ndarray, dt: float) -> np.ndarray:
        return self._held(z)

    def _held(self, outputs: np.ndarray) -> np.ndarray:
        return np.where(np.isnan(self.values), outputs, self.values)


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
    return _constant(model, parts[0].dt, means.tolist())


@method("straight-line", "straight on at the initial speed, without turning", kind="floor")
def StraightLine(records: Sequence[Record], model: Model) -> Fit:
    """The ship keeps the surge and sway speed of its start and does not turn: its yaw rate is zero.

    One sample ahead, the speeds are those of the sample before.  Nothing is learnt from the training records.
    """
    parts = signals_of(in_order(records), model)  # records that no method can use are refused
    return _constant(model, parts[0].dt, [0.0 if name == "r" else np.nan for name in outputs_of(model)])


def _constant(model: Model, dt: float, values: Sequence[float]) -> Fit:
    return black_box_fit(ConstantPredictor(tuple(model.states), outputs_of(model), dt, tuple(values)))
