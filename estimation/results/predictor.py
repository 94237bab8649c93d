"""Predictors of a ship's motion: a model with coefficients, or a black box.

Scores and tuning need free runs and one-step predictions.  States are in the model's order; the yaw acceleration
q = r_dot takes the place of the hidden state w of a second-order response model (w = q - c rudder).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ...datasets.record import Record
from ...models.model import Model
from ..records.series import MEASURED, series_of


class Predictor(Protocol):
    """Predicts states from inputs; a run that diverges gives rows that are not finite, and no error."""

    def simulate(self, inputs: np.ndarray, dt: float, start: np.ndarray) -> np.ndarray:
        """Free run: states (M + 1, n) from start (n,) under inputs (M + 1, nu), linear between samples dt apart, s."""
        ...

    def step(self, states: np.ndarray, inputs: np.ndarray, dt: float) -> np.ndarray:
        """One sample ahead: states (N, n) of the next sample from each of states (N, n), with inputs (N + 1, nu)."""
        ...


@dataclass(frozen=True)
class ModelPredictor:
    """A model with coefficients as a predictor; `step` gives the hidden state itself, not the yaw acceleration."""

    model: Model

    def simulate(self, inputs: np.ndarray, dt: float, start: np.ndarray) -> np.ndarray:
        from ...models.simulate import simulate, simulated_states

        return simulate(self.model, inputs, dt, simulated_states(self.model, start[None, :], inputs[:1, 0])[0])

    def step(self, states: np.ndarray, inputs: np.ndarray, dt: float) -> np.ndarray:
        from ...models.simulate import simulated_states, step_map

        return step_map(self.model, simulated_states(self.model, states, inputs[: len(states), 0]), inputs, dt)


def free_run_error(
    predictor: Predictor, records: Sequence[Record], model: Model, since: Sequence[int] | None = None
) -> float:
    """Normalised root mean square error of free runs over records; inf where one diverges.

    Every record is run from its first sample with its own inputs.  Each channel's mean square error, over the samples
    from `since` on, is divided by the variance of its samples there; heading only counts where no yaw rate is measured.

    Parameters
    ----------
    since : first sample that counts, of each record; default: all count.
    """
    total = np.zeros(2)
    for record, first in zip(records, since or [0] * len(records), strict=True):
        series = series_of(record.turned(model.positive_rudder), model, MEASURED)
        with np.errstate(all="ignore"):
            run = series.observe(predictor.simulate(series.inputs, series.dt, series.start))[:, series.columns]
            total += _relative_squares(series.outputs[first:], run[first:], _counted(model, series.columns))
    return float(np.sqrt(total[0] / total[1])) if np.isfinite(total).all() and total[1] else np.inf


def _counted(model: Model, columns: np.ndarray) -> list[int]:
    """Which of the measured columns count."""
    symbols = [model.states[column] for column in columns]
    return [place for place, symbol in enumerate(symbols) if symbol != "psi" or "r" not in symbols]


def _relative_squares(observed: np.ndarray, predicted: np.ndarray, columns: Sequence[int]) -> np.ndarray:
    """Sum over channels of n MSE / variance, and of n."""
    total = np.zeros(2)
    for column in columns:
        known = np.isfinite(observed[:, column])
        spread = np.var(observed[known, column]) if known.any() else 0.0
        if spread > 0.0:
            total[0] += np.sum((observed[known, column] - predicted[known, column]) ** 2) / spread
            total[1] += known.sum()
    return total
