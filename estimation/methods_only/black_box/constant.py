"""Predictions without identification: what every method must beat."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .motion import one_ahead, whole_run


@dataclass(frozen=True)
class ConstantPredictor:
    """Outputs (velocities and yaw rate) that do not change: `values`, nan for those of the initial state.

    In a free run the outputs take these values from the sample after the first on; one sample ahead always.  See
    `predictor.Predictor`.
    """

    states: tuple[str, ...]
    outputs: tuple[str, ...]
    values: tuple[float, ...]

    def simulate(self, inputs: np.ndarray, dt: float, start: np.ndarray) -> np.ndarray:
        """Free run, as `predictor.Predictor`."""
        first = dict(zip(self.states, start, strict=True))
        held = {name: np.full(len(inputs), value) for name, value in self._held(first).items()}
        for name, run in held.items():
            run[0] = first[name]
        states = whole_run(self.states, start, held, dt)
        states[0] = start
        return states

    def step(self, states: np.ndarray, inputs: np.ndarray, dt: float) -> np.ndarray:
        """One sample ahead of each row, as `predictor.Predictor`."""
        ahead = self._held(dict(zip(self.states, states.T, strict=True)))
        return one_ahead(
            self.states, states, {name: np.zeros(len(states)) + value for name, value in ahead.items()}, dt
        )

    def _held(self, now: dict) -> dict:
        return {n: now[n] if np.isnan(value) else value for n, value in zip(self.outputs, self.values, strict=True)}
