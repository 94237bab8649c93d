"""Learnt difference equations with lags (NARX) as predictors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ....datasets.geometry import over_ground
from .rows import Lags
from .scaled import Scaled, unchecked


def whole_run(names: Sequence[str], start: np.ndarray, outputs: dict[str, np.ndarray], dt: float) -> np.ndarray:
    """States (M + 1, n) `names` from start (n,) and outputs (M + 1,) by symbol, dt seconds apart."""
    count = len(next(iter(outputs.values())))
    known = dict(outputs)
    if "w" in names:
        known["w"] = np.gradient(known["r"], dt) if count > 1 else np.zeros(count)
    if "psi" in names:
        known["psi"] = _integral(known["r"], dt, start[names.index("psi")])
    if "x" in names:
        way = over_ground(known["u"], known["v"], known["psi"])
        known |= {s: _integral(rate, dt, start[names.index(s)]) for s, rate in (("x", way.real), ("y", way.imag))}
    return np.column_stack([known[name] for name in names])


def one_ahead(names: Sequence[str], states: np.ndarray, ahead: dict[str, np.ndarray], dt: float) -> np.ndarray:
    """States (N, n) one sample after each of states (N, n), from the outputs there (N,) by symbol."""
    now = dict(zip(names, states.T, strict=True))
    known = dict(ahead)
    if "w" in names:
        known["w"] = (ahead["r"] - now["r"]) / dt
    if "psi" in names:
        known["psi"] = now["psi"] + dt * (now["r"] + ahead["r"]) / 2.0
    if "x" in names:
        before = over_ground(now["u"], now["v"], now["psi"])
        moved = dt * (before + over_ground(ahead["u"], ahead["v"], known["psi"])) / 2.0
        known |= {"x": now["x"] + moved.real, "y": now["y"] + moved.imag}
    return np.column_stack([known[name] for name in names])


def _integral(rate: np.ndarray, dt: float, start: float) -> np.ndarray:
    return start + np.concatenate([[0.0], np.cumsum(dt * (rate[:-1] + rate[1:]) / 2.0)])


def on_steps(inputs: np.ndarray, dt: float, step_s: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times (N,) of inputs (N, nu), times (S,) of a predictor's steps, and the inputs (S, nu) at these."""
    time = dt * np.arange(len(inputs))
    grid = step_s * np.arange(int(np.ceil(time[-1] / step_s - 1e-9)) + 1)
    return time, grid, np.column_stack([np.interp(grid, time, column) for column in inputs.T])


@dataclass(frozen=True)
class SteppedPredictor:
    """A black box of the outputs at steps of `step_s`; see `predictor.Predictor`.

    Before the first sample everything is taken as constant.  Free runs are interpolated between the steps; one sample
    ahead, a share of the step is taken.  A subclass implements `run` and `ahead`.
    """

    states: tuple[str, ...]
    outputs: tuple[str, ...]
    step_s: float

    def run(self, first: np.ndarray, driven: np.ndarray) -> np.ndarray:
        """Outputs (K, k) at the steps from the first (k,) under inputs (K, nu)."""
        raise NotImplementedError(f"{type(self).__name__} does not implement run()")

    def ahead(self, z: np.ndarray, inputs: np.ndarray, time: np.ndarray, dt: float) -> np.ndarray:
        """Outputs (N, k) one sample after each of z (N, k) under inputs (N, nu), at times (N,) dt apart; earlier rows
        are the past of a row."""
        raise NotImplementedError(f"{type(self).__name__} does not implement ahead()")

    def simulate(self, inputs: np.ndarray, dt: float, start: np.ndarray) -> np.ndarray:
        """Free run, as `predictor.Predictor`; rows from where it diverges on are nan."""
        time, grid, driven = on_steps(inputs, dt, self.step_s)
        first = np.array([start[self.states.index(name)] for name in self.outputs])
        with np.errstate(all="ignore"):
            z = self.run(first, driven)
            found = {name: np.interp(time, grid, z[:, i]) for i, name in enumerate(self.outputs)}
            states = whole_run(self.states, start, found, dt)
        states[0] = start
        return states

    def step(self, states: np.ndarray, inputs: np.ndarray, dt: float) -> np.ndarray:
        """One sample ahead of each row, as `predictor.Predictor`; the rows before it are its past."""
        z = np.column_stack([states[:, self.states.index(name)] for name in self.outputs])
        with np.errstate(all="ignore"):
            ahead = self.ahead(z, inputs[: len(z)], dt * np.arange(len(z)), dt)
            return one_ahead(self.states, states, dict(zip(self.outputs, ahead.T, strict=True)), dt)


@dataclass(frozen=True)
class NarxPredictor(SteppedPredictor):
    """A learnt difference equation; see `rows`."""

    lags: Lags
    learnt: Scaled

    def run(self, first: np.ndarray, driven: np.ndarray) -> np.ndarray:
        from ._kernels import difference_run

        before = np.maximum(np.arange(len(driven))[:, None] - np.arange(self.lags.inputs), 0)
        driven = np.ascontiguousarray(driven[before].reshape(len(driven), -1))
        k, h = len(first), self.step_s
        known = k * self.lags.outputs
        z = np.full((len(driven), k), np.nan)
        z[0] = first
        if known + driven.shape[1] != self.learnt.mean.size:  # compiled code does not look
            raise ValueError(f"{driven.shape[1]} lagged inputs instead of {self.learnt.mean.size - known}")
        if (packed := self.learnt.packed) is not None:
            difference_run(*packed, self.lags.outputs, h, driven, z)
            return z
        x = np.concatenate([np.tile(first, self.lags.outputs), driven[0]])[None]
        with unchecked():
            for step in range(len(driven) - 1):
                x[0, known:] = driven[step]
                ahead = z[step] + h * self.learnt(x)[0]
                if not np.isfinite(ahead).all():
                    break
                z[step + 1] = ahead
                x[0, k:known] = x[0, : known - k].copy()
                x[0, :k] = ahead
        return z

    def ahead(self, z: np.ndarray, inputs: np.ndarray, time: np.ndarray, dt: float) -> np.ndarray:
        past = [z, *(at_earlier(z, time, j * self.step_s) for j in range(1, self.lags.outputs))]
        x = np.hstack([*past, *(at_earlier(inputs, time, j * self.step_s) for j in range(self.lags.inputs))])
        with unchecked():
            return z + dt * self.learnt(x)

    def members(self, count: int, rng: np.random.Generator) -> list[NarxPredictor]:
        """Predictors with the learnt function drawn from its own uncertainty; see `estimation.judgement.ensemble`."""
        return [replace(self, learnt=learnt) for learnt in self.learnt.drawn(count, rng)]


def at_earlier(values: np.ndarray, time: np.ndarray, earlier: float) -> np.ndarray:
    """Columns (N, c) at times (N,) minus `earlier`, gaps bridged; before the first sample as at the first."""
    columns = []
    for column in values.T:
        known = np.isfinite(column)
        columns.append(np.interp(time - earlier, time[known], column[known]) if known.any() else column)
    return np.column_stack(columns)
