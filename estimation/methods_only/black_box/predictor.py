"""Accelerations learnt by regressors from states and inputs, and their integration as a predictor.

A 3-DOF model gives the features u, v, r and the inputs, and the targets u_dot, v_dot, r_dot; a first-order response
model r and the rudder, and r_dot; a second-order one r_dot, r, the rudder and its rate, and r_ddot.  Heading and
position are no features: the ship's behaviour does not depend on them.  Features and targets are scaled to zero mean
and unit variance first.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....models.errors import FitFailed
from ....models.model import Model
from ...regression.samples import RegressionSamples
from .compiled import OUTSIDE, Packed, compiled, stacked

PLACES = ("psi", "x", "y")
"""States that accelerations do not depend on."""
LARGEST = 1e100
"""Size of a feature or target above which it counts as not finite."""
CHECKED = 50
"""Training rows on which compiled forms of the regressors are compared with the regressors themselves."""


def training_rows(parts: Sequence[RegressionSamples], model: Model) -> tuple[np.ndarray, np.ndarray]:
    """Features (N, d) and accelerations (N, k) of all records."""
    kept = [place for place, symbol in enumerate(model.regression_states) if symbol not in PLACES]
    x = np.vstack([np.column_stack([part.states[:, kept], part.inputs]) for part in parts])
    return x, np.vstack([part.accelerations for part in parts])


def features_of(model: Model) -> tuple[str, ...]:
    """Symbols of the states and inputs that accelerations depend on."""
    return *(symbol for symbol in model.regression_states if symbol not in PLACES), *model.regression_inputs


def evenly_spaced(count: int, most: int | None) -> np.ndarray:
    """Indices of at most `most` of `count` rows, evenly spaced."""
    if most is None or count <= most:
        return np.arange(count)
    return np.linspace(0, count - 1, most).round().astype(np.int64)


def _scaling(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean (k,) and spread (k,) of columns (N, k); 1 for a column that does not vary."""
    sd = values.std(axis=0)
    mean = values.mean(axis=0)
    return mean, np.where(sd > 1e-12 * np.maximum(np.abs(mean), 1e-300), sd, 1.0)


def learn(x: np.ndarray, y: np.ndarray, make: Callable[[int], Any], model: Model) -> BlackBoxPredictor:
    """Fit regressors to features x (N, d) and accelerations y (N, k), both scaled inside.

    Parameters
    ----------
    make : number of features -> a new regressor.

    Raises
    ------
    FitFailed : the rows are not finite, or a regressor cannot be fitted.
    """
    if not all(np.isfinite(rows).all() and np.abs(rows).max() < LARGEST for rows in (x, y)):
        raise FitFailed("states or accelerations are not finite")
    (x_mean, x_scale), (y_mean, y_scale) = _scaling(x), _scaling(y)
    scaled, target = (x - x_mean) / x_scale, (y - y_mean) / y_scale
    regressors = fit_regressors(scaled, target, make)
    return BlackBoxPredictor(
        states=tuple(model.states),
        inputs=tuple(model.inputs),
        features=features_of(model),
        x_mean=x_mean,
        x_scale=x_scale,
        y_mean=y_mean,
        y_scale=y_scale,
        regressors=regressors,
        fast=compiled(regressors, scaled[evenly_spaced(len(scaled), CHECKED)]),
    )


def fit_regressors(x: np.ndarray, y: np.ndarray, make: Callable[[int], Any]) -> tuple[Any, ...]:
    """One regressor for all targets (N, k) if it takes several, else one for each."""
    from sklearn.utils import get_tags

    first = make(x.shape[1])
    try:
        if y.shape[1] > 1 and get_tags(first).target_tags.multi_output:
            return (first.fit(x, y),)
        return tuple(make(x.shape[1]).fit(x, column) for column in y.T)
    except (TypeError, ValueError, ArithmeticError) as error:
        raise FitFailed(f"{type(first).__name__}: {error}") from error


@dataclass(frozen=True)
class BlackBoxPredictor:
    """Accelerations learnt by regressors, integrated by RK4 with one step a sample and inputs linear in between.

    `states` and `inputs` are the model's; `features` (d,) names what the regressors take, scaled by x_mean and x_scale
    (d,); their predictions are scaled back by y_mean and y_scale (k,).  `fast`, if set, gives the same predictions.
    """

    states: tuple[str, ...]
    inputs: tuple[str, ...]
    features: tuple[str, ...]
    x_mean: np.ndarray
    x_scale: np.ndarray
    y_mean: np.ndarray
    y_scale: np.ndarray
    regressors: tuple[Any, ...]
    fast: Packed | None

    def simulate(self, inputs: np.ndarray, dt: float, start: np.ndarray) -> np.ndarray:
        """Free run, as `predictor.Predictor`; rows from where it diverges on are nan."""
        states = np.full((len(inputs), len(start)), np.nan)
        states[0] = start
        with unchecked(), np.errstate(all="ignore"):
            for k in range(len(inputs) - 1):
                states[k + 1] = self._advance(states[k : k + 1], inputs[k : k + 1], inputs[k + 1 : k + 2], dt)[0]
                if not np.isfinite(states[k + 1]).all():
                    break
        return states

    def step(self, states: np.ndarray, inputs: np.ndarray, dt: float) -> np.ndarray:
        """One sample ahead of each row at once, as `predictor.Predictor`."""
        with unchecked(), np.errstate(all="ignore"):
            return self._advance(states, inputs[: len(states)], inputs[1 : len(states) + 1], dt)

    def accelerations(self, features: np.ndarray) -> np.ndarray:
        """Accelerations (B, k) at features (B, d); nan where these are far from all training rows."""
        scaled = (features - self.x_mean) / self.x_scale
        inside = (np.abs(scaled) < OUTSIDE).all(axis=1)
        found = np.full((len(scaled), len(self.y_mean)), np.nan)
        if inside.all():
            found = self._predict(scaled)
        elif inside.any():
            found[inside] = self._predict(scaled[inside])
        return found * self.y_scale + self.y_mean

    def _predict(self, scaled: np.ndarray) -> np.ndarray:
        return stacked(self.regressors, scaled) if self.fast is None else self.fast(scaled)

    def _advance(self, x: np.ndarray, before: np.ndarray, after: np.ndarray, dt: float) -> np.ndarray:
        """States (B, n) dt later, inputs (B, nu) going from `before` to `after`."""
        slope, half = (after - before) / dt, (before + after) / 2.0
        k1 = self._rates(x, before, slope)
        k2 = self._rates(x + 0.5 * dt * k1, half, slope)
        k3 = self._rates(x + 0.5 * dt * k2, half, slope)
        k4 = self._rates(x + dt * k3, after, slope)
        return x + dt / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)

    def _rates(self, x: np.ndarray, inputs: np.ndarray, slope: np.ndarray) -> np.ndarray:
        """State derivatives (B, n); q = r_dot stands in the place of w."""
        state = dict(zip(("q" if name == "w" else name for name in self.states), x.T, strict=True))
        current = dict(zip(self.inputs, inputs.T, strict=True))
        current["delta_rate"] = slope[:, self.inputs.index("delta")]
        known = state | current
        found = self.accelerations(np.column_stack([known[name] for name in self.features])).T
        rates = {"psi": state["r"]}
        if len(found) == 3:
            u, v, cos, sin = state["u"], state["v"], np.cos(state["psi"]), np.sin(state["psi"])
            rates |= {"u": found[0], "v": found[1], "r": found[2], "x": u * cos - v * sin, "y": u * sin + v * cos}
        else:
            rates |= {"q": found[0], "r": state["q"]} if "q" in state else {"r": found[0]}
        return np.column_stack([rates[name] for name in state])


def unchecked():
    """Context in which scikit-learn does not check arrays and options that are known to be valid."""
    from sklearn import config_context

    return config_context(assume_finite=True, skip_parameter_validation=True)
