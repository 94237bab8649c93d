"""A physical model with identified coefficients, and accelerations learnt from its innovations on top."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ....models.errors import CannotFit
from ....models.model import Model
from .rows import Signals, averaged_signals, outputs_of
from .scaled import Scaled, unchecked


def innovation_rows(parts: Sequence[Signals], model: Model, stride: int) -> tuple[np.ndarray, np.ndarray]:
    """Features (N, d) and the model's one-step errors per second (N, k), over steps of `stride` samples.

    Features are outputs and inputs at the beginning of a step, everything averaged over a step.

    Raises
    ------
    CannotFit : there are no more rows than features.
    """
    x, y = [], []
    for signals in parts:
        own = averaged_signals(signals, stride)
        lost = np.concatenate([[0], np.cumsum(~own.whole)])
        for phase in range(min(stride, len(own.whole))):
            place = np.arange(phase, len(own.whole), stride)
            if len(place) < 2:
                continue
            z, w = own.outputs[place], np.ascontiguousarray(own.inputs[place])
            rates = (z[1:] - _ahead(model, own, place, w, stride * own.dt)) / (stride * own.dt)
            kept = lost[place[1:] + 1] == lost[place[:-1]]
            x.append(np.hstack([z[:-1], w[:-1]])[kept])
            y.append(rates[kept])
    n, d = sum(map(len, y)), sum(part.shape[1] for part in parts[0][1:3])
    if n <= d:
        raise CannotFit(f"{n} usable rows for {d} features")
    return np.vstack(x), np.vstack(y)


def _ahead(model: Model, signals: Signals, place: np.ndarray, inputs: np.ndarray, dt: float) -> np.ndarray:
    """Outputs (N - 1, k) that the model predicts from the outputs at places (N,) one step on."""
    from ....models.simulate import simulated_states, step_map

    names = outputs_of(model)
    states = np.zeros((len(place), len(model.states)))
    columns = [model.states.index(name) for name in names]
    states[:, columns] = signals.outputs[place]
    if "w" in model.states:
        rate = np.gradient(signals.outputs[:, names.index("r")], signals.dt)
        states[:, model.states.index("w")] = rate[place]
    start = simulated_states(model, states, inputs[:, 0])[:-1]
    return step_map(model, start, inputs, dt)[:, columns]


@dataclass(frozen=True)
class HybridPredictor:
    """The model's motion plus `share` times the learnt accelerations at every sample; see `predictor.Predictor`."""

    model: Model
    learnt: Scaled
    share: float

    @cached_property
    def _columns(self) -> list[int]:
        """Places among the states of what the learnt function takes and changes."""
        return [self.model.states.index(name) for name in outputs_of(self.model)]

    def simulate(self, inputs: np.ndarray, dt: float, start: np.ndarray) -> np.ndarray:
        """Free run, as `predictor.Predictor`; rows from where it diverges on are nan."""
        from ....models.simulate import simulated_states, substeps
        from ._kernels import hybrid_run

        states = np.full((len(inputs), len(start)), np.nan)
        states[0] = simulated_states(self.model, start[None], inputs[:1, 0])[0]
        if len(self._columns) + inputs.shape[1] != self.learnt.mean.size:  # compiled code does not look
            raise ValueError(f"{inputs.shape[1]} inputs instead of {self.learnt.mean.size - len(self._columns)}")
        if (packed := self.learnt.packed) is not None:
            hybrid_run(
                *packed, self.share, np.array(self._columns), self.model.kernels.rhs, self.model.theta, dt,
                substeps(self.model, dt), np.ascontiguousarray(inputs, float), states,
            )  # fmt: skip
            return states
        with unchecked(), np.errstate(all="ignore"):
            for k in range(len(inputs) - 1):
                ahead = self._advance(states[k : k + 1], inputs[k : k + 2], dt)
                if not np.isfinite(ahead).all():
                    break
                if self.share and not self.learnt.near(self._features(ahead, inputs[k + 1 : k + 2])).all():
                    break
                states[k + 1] = ahead[0]
        return states

    def step(self, states: np.ndarray, inputs: np.ndarray, dt: float) -> np.ndarray:
        """One sample ahead of each row, as `predictor.Predictor`."""
        from ....models.simulate import simulated_states

        with unchecked(), np.errstate(all="ignore"):
            return self._advance(simulated_states(self.model, states, inputs[: len(states), 0]), inputs, dt)

    def members(self, count: int, rng: np.random.Generator) -> list[HybridPredictor]:
        """Predictors with learnt accelerations drawn from their own uncertainty: `estimation.judgement.ensemble`."""
        drawn = self.learnt.drawn(count, rng) if self.share else []
        return [replace(self, learnt=learnt) for learnt in drawn]

    def _features(self, states: np.ndarray, inputs: np.ndarray) -> np.ndarray:
        """(B, d) of states (B, n) and inputs (B, nu)."""
        return np.hstack([states[:, self._columns], inputs])

    def _advance(self, states: np.ndarray, inputs: np.ndarray, dt: float) -> np.ndarray:
        from ....models.simulate import step_map

        ahead = step_map(self.model, states, inputs, dt)
        if self.share:
            rates = self.learnt(self._features(states, inputs[: len(states)]))
            ahead[:, self._columns] += self.share * dt * rates
        return ahead
