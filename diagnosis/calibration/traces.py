"""Measured channels of training records against free runs before and after the calibration, for pages and figures."""

from __future__ import annotations

import numpy as np

from ...estimation.diagnosis_only.mixed_effects.problem import THRUST, Problem, Run
from ...models.model import CHANNELS
from ..trace import Trace
from .attempts import Attempt


def left_out_traces(given: Problem, felt: Problem, final: Attempt) -> tuple[Trace, ...]:
    """Training records; the run after the calibration is by the fit that left the record out, with what known causes
    explain in `felt`."""
    places = [n.place for n in final.fitted.numbers]
    out = []
    for plain, run, left in zip(given.runs, felt.runs, final.left_out, strict=True):
        theta = final.fitted.theta.copy()
        theta[places] = left.values
        out.append(_trace((given, plain), (felt, run), theta))
    return tuple(out)


def _trace(given: tuple[Problem, Run], felt: tuple[Problem, Run], theta: np.ndarray) -> Trace:
    """The run after the calibration is told as the record's own sensors would show it."""
    p, run = given
    measured = run.series.outputs
    before = measured - _error(*given, p.model.theta)
    after = measured - _error(*felt, theta)
    names = [CHANNELS[symbol] for symbol in p.channels if symbol != THRUST]
    time = run.series.dt * (run.series.index + run.series.part)
    rudder = run.series.observe(run.series.inputs[:, 0])
    columns = [dict(zip(names, values.T, strict=True)) for values in (measured, before, after)]
    return Trace(run.name, "train", time, rudder, *columns)


def _error(p: Problem, run: Run, theta: np.ndarray) -> np.ndarray:
    """Errors (N, S) of the states of a free run without the record's own effects."""
    states = [c for c in p.channels if c != THRUST]
    return p.residuals(theta, run, np.zeros(p.own_sd.size))[:, : len(states)]
