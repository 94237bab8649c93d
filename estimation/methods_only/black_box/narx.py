"""Learnt difference equations with lags (NARX) as predictors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ....datasets.geometry import over_ground
from ....models.errors import FitFailed
from ....models.model import Model
from .compiled import OUTSIDE, Packed, compiled, drawn, stacked
from .predictor import CHECKED, LARGEST, evenly_spaced, fit_regressors, unchecked
from .rows import SYMMETRIC, Lags, outputs_of


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


DIGITS = 9
"""Decimals of scaled rows: rounding errors of the records' units do not decide between two splits of a tree."""


@dataclass(frozen=True)
class Scaled:
    """Regressors of scaled features (d,) and targets (k,); constant features are zero.

    `fast`, if set, gives the same predictions as the regressors.
    """

    mean: np.ndarray
    scale: np.ndarray
    y_scale: np.ndarray
    regressors: tuple[Any, ...]
    fast: Packed | None

    @property
    def packed(self) -> tuple[Any, ...] | None:
        """First arguments of the compiled free runs (`_kernels`); None where no compiled form agrees."""
        if self.fast is None:
            return None
        work = np.empty(len(self.mean) + self.fast.work)
        scaling = np.ascontiguousarray([self.mean, self.scale])
        return self.fast.form, self.fast.ints, self.fast.floats, scaling, np.ascontiguousarray(self.y_scale), work

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """Targets (B, k) at features (B, d); nan where these are far from all training rows."""
        scaled = (x - self.mean) * self.scale
        found = self.fast(scaled) if self.fast is not None else stacked(self.regressors, scaled)
        found = found * self.y_scale
        found[~_near(scaled)] = np.nan
        return found

    def near(self, x: np.ndarray) -> np.ndarray:
        """(B,) bool: whether features (B, d) are near enough to the training rows for the function to be asked."""
        return _near((x - self.mean) * self.scale)

    def drawn(self, count: int, rng: np.random.Generator) -> list[Scaled]:
        """At most `count` functions drawn from the regressors' uncertainty; none where they state none."""
        return [replace(self, fast=one) for one in drawn(self.regressors, len(self.y_scale), count, rng)]


def _near(scaled: np.ndarray) -> np.ndarray:
    """(B,) bool: whether scaled features (B, d) are within OUTSIDE; a nan is not outside of anything."""
    return ~(np.abs(scaled).max(axis=1) > OUTSIDE)


def fit_scaled(x: np.ndarray, y: np.ndarray, make: Callable[[int], Any], symbols: tuple[str, ...]) -> Scaled:
    """Fit regressors to features x (N, d) and targets y (N, k), both scaled to unit variance.

    Parameters
    ----------
    make : number of features -> a new regressor.
    symbols : (d,) of the features; those of the ship's symmetry keep their zero.

    Raises
    ------
    FitFailed : the rows are not finite, or a regressor cannot be fitted.
    """
    if not all(max(rows.max(), -rows.min()) < LARGEST for rows in (x, y)):
        raise FitFailed("states or accelerations are not finite")
    still = np.array([symbol in SYMMETRIC for symbol in symbols])
    mean = np.where(still, 0.0, x.mean(axis=0))
    scale, y_scale = inverse_spread(x, mean), 1.0 / inverse_spread(y, np.zeros(y.shape[1]), 1.0)
    scaled, target = x - mean, y / y_scale
    scaled *= scale
    for rows in (scaled, target):
        np.round(rows, DIGITS, out=rows)
    regressors = fit_regressors(scaled, target, make)
    fast = compiled(regressors, scaled[evenly_spaced(len(scaled), CHECKED)])
    return Scaled(mean, scale, y_scale, regressors, fast)


def inverse_spread(values: np.ndarray, mean: np.ndarray, constant: float = 0.0) -> np.ndarray:
    """1 / root mean square of columns (N, k) about mean (k,); `constant` for a column that does not vary."""
    spread = np.sqrt(np.mean((values - mean) ** 2, axis=0))
    varies = (values.std(axis=0) > 1e-9 * np.abs(values).max(axis=0)) & (spread > 0.0)
    return np.where(varies, 1.0 / np.where(varies, spread, 1.0), constant)


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
        known, found = np.isfinite(x).all(axis=1), np.full_like(z, np.nan)
        with unchecked():
            if known.any():
                found[known] = z[known] + dt * self.learnt(x[known])
        return found

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


def learn_narx(x: np.ndarray, y: np.ndarray, make: Callable[[int], Any], model: Model, lags: Lags, dt: float):
    """The predictor of rows (`rows.narx_rows`) of records sampled every dt seconds.

    Raises
    ------
    FitFailed : see `fit_scaled`.
    """
    learnt = fit_scaled(x, y, make, lags.features(model))
    return NarxPredictor(tuple(model.states), outputs_of(model), lags.stride * dt, lags, learnt)
