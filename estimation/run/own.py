"""A trial's own neutral rudder angle and start: they belong to the trial, not to the model.

Half a degree of neutral angle is ten degrees of heading after a zigzag.  Both are estimated under their priors along
the record itself, so that what remains is the model's error:

    min  n sum_c log(rms_c^2 + floor_c^2)^(1/2) + 1/2 sum_j (own_j / sd_j)^2

over the measured states c, n being the independent values that the duration amounts to.  Damped Gauss-Newton steps.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...models.errors import CannotFit
from ...models.time_scale import time_scale_s
from ..likelihood.minimiser import Damping, damped_step, try_steps
from ..records.gaps import clock_of
from ..records.series import MEASURED
from .stretch import Stretch

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model
    from .stretch import FreeRun

NEUTRAL_ANGLE_SD = np.deg2rad(0.3)
"""Standard deviation of a record's neutral rudder angle about the common one, rad."""
START_SD = {"u": 2.5e-3, "v": 2.5e-3, "r": 3e-3, "psi": 2e-3}
"""Standard deviation of a record's initial state about the smoothed one: shares of speed, of speed / length, rad."""
FLOOR = {"u": 2.5e-3, "v": 2.5e-3, "r": 5e-3, "psi": np.deg2rad(0.5)}
"""Error below which a state counts as perfect, in the same units."""
CORRELATION = 1.7
"""Correlation time of the residuals of free runs, in ship lengths sailed (10 s for a 7 m model at 1.18 m/s)."""
REFERENCE_S = 160.0 / (15.0 * 1852.0 / 3600.0)
"""L/U of a ship of 160 m at 15 kn, s."""
STEP, INTEGRATION_STEP = 0.035, 0.05
"""Time step, in ship lengths sailed, that records are thinned to in fits, and the largest of the integration: RK4 with
it errs by under 1e-5 of the yaw rate and the speeds of every vessel here."""
STEPS, DIFFERENCE, ENOUGH = 6, 1e-2, 1e-3
"""Most Gauss-Newton steps, step of the derivatives in prior standard deviations, and the fall that ends them."""
RULE = Damping(growth=5.0, least=0.0, trials=6)


def units(model: Model, length_s: float) -> dict[str, float]:
    """State -> the unit of START_SD and FLOOR, SI; length_s : time of one ship length, s."""
    speed = model.speed_m_s if np.isfinite(model.speed_m_s) else 1.0
    return {"u": speed, "v": speed, "r": 1.0 / length_s, "psi": 1.0}


def own_sd(model: Model, length_s: float) -> dict[str, float]:
    """Prior standard deviations of a record's own effects, SI: neutral rudder angle, then its initial states."""
    unit = units(model, length_s)
    return {"delta": NEUTRAL_ANGLE_SD, **{s: sd * unit[s] for s, sd in START_SD.items() if s in model.states}}


def coarse(record: Record, length_s: float) -> Record:
    """The record thinned to STEP."""
    return record.thinned(max(1, int(STEP * length_s / record.dt + 1e-9)))


def coarsely_integrated(model: Model, length_s: float) -> Model:
    """The model with integration steps of INTEGRATION_STEP where its own are shorter."""
    return replace(model, max_step_s=max(model.max_step_s, INTEGRATION_STEP * length_s))


class _Point(NamedTuple):
    """Own effects (k,), errors (N, C) of the run with them, their size (C,) with the floor, and the criterion."""

    own: np.ndarray
    errors: np.ndarray
    size: np.ndarray
    cost: float


def own_run(stretch: Stretch) -> FreeRun:
    """The free run with the stretch's own neutral rudder angle and start, which are fitted under their priors."""
    fit = _Fit(stretch)
    return fit.run(stretch, fit.fitted().own)


class _Fit:
    """The criterion along one stretch, thinned."""

    def __init__(self, stretch: Stretch) -> None:
        model = stretch.model
        try:
            length_s = time_scale_s(model)
        except CannotFit:
            length_s = REFERENCE_S * clock_of(model, [stretch.record])
        self.start, self.sd = stretch.state_at(0), own_sd(model, length_s)
        if model.inputs[0] != "delta":
            del self.sd["delta"]
        thinned = coarse(stretch.record, length_s)
        self.coarse = Stretch.of(coarsely_integrated(model, length_s), thinned, predictor=stretch.predictor)
        series = self.coarse.series
        symbols = [model.states[i] for i in series.columns.tolist()]
        self.counted = [c for c, s in enumerate(symbols) if s in MEASURED]
        self.floor = np.array([FLOOR[s] * units(model, length_s)[s] for s in symbols if s in MEASURED])
        self.weight = series.dt * len(series.inputs) / (CORRELATION * length_s)

    def run(self, along: Stretch, own: np.ndarray) -> FreeRun:
        """The free run along the stretch, or as it is thinned, with own effects (k,)."""
        inputs, start = along.series.inputs, self.start.copy()
        for value, symbol in zip(own.tolist(), self.sd, strict=True):
            if symbol == "delta":
                inputs = inputs.copy()
                inputs[:, 0] += value
            else:
                start[along.model.states.index(symbol)] += value
        return along.run(start, inputs)

    def fitted(self) -> _Point:
        """Where the criterion is least."""
        here, damping = self._at(np.zeros(len(self.sd))), 1e-3
        for _ in range(STEPS):
            trial = try_steps(partial(damped_step, *self._equations(here)), partial(self._moved, here), here.cost,
                              damping, 0.0, RULE)  # fmt: skip
            if not trial.better or here.cost - trial.point.cost < ENOUGH:
                return trial.point if trial.better else here
            here, damping = trial.point, max(trial.damping / RULE.growth, 1e-9)
        return here

    def _moved(self, here: _Point, step: np.ndarray) -> _Point:
        return self._at(here.own + step)

    def _at(self, own: np.ndarray) -> _Point:
        errors = self._errors(own)
        size = np.sqrt(np.nan_to_num(np.nanmean(errors**2, axis=0)) + self.floor**2)
        sd = np.array(list(self.sd.values()))
        cost = self.weight * float(np.sum(np.log(size))) + 0.5 * float(np.sum((own / sd) ** 2))
        return _Point(own, errors, size, cost)

    def _errors(self, own: np.ndarray) -> np.ndarray:
        """Measured less predicted states (N, C)."""
        series = self.coarse.series
        found = series.outputs - series.observe(self.run(self.coarse, own).states[:, series.columns])
        return found[:, self.counted]

    def _equations(self, here: _Point) -> tuple[np.ndarray, np.ndarray]:
        """Normal equations (k, k), (k,) with the priors."""
        sd = np.array(list(self.sd.values()))
        moved = [self._errors(here.own + step) for step in DIFFERENCE * np.diag(sd)]
        slopes = np.array([(errors - here.errors) / h for errors, h in zip(moved, DIFFERENCE * sd, strict=True)])
        counts = np.maximum(np.isfinite(here.errors).sum(axis=0), 1)
        root = np.sqrt(self.weight / counts) / here.size
        rows = np.nan_to_num(slopes * root).reshape(len(sd), -1)
        target = np.nan_to_num(here.errors * root).ravel()
        return rows @ rows.T + np.diag(sd**-2.0), -rows @ target - here.own * sd**-2.0
