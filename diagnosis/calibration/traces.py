"""Measured channels against free runs before and after the calibration, for pages and figures."""

from __future__ import annotations

import numpy as np

from ...estimation.mixed_effects.problem import THRUST, Problem, Run
from ...models.model import CHANNELS
from ..result import Trace
from .forward import Selection


def left_out_traces(p: Problem, found: Selection) -> tuple[Trace, ...]:
    """Training records; the run after the calibration is by the fit that left the record out."""
    places = [n.place for n in found.final.fitted.numbers]
    out = []
    for run, left in zip(p.runs, found.final.left_out, strict=True):
        theta = found.final.fitted.theta.copy()
        theta[places] = left.values
        out.append(_trace(p, run, "train", theta))
    return tuple(out)


def held_out_traces(p: Problem | None, found: Selection) -> tuple[Trace, ...]:
    """Held-out records by the final numbers."""
    return () if p is None else tuple(_trace(p, run, "held_out", found.final.fitted.theta) for run in p.runs)


def _trace(p: Problem, run: Run, role: str, theta: np.ndarray) -> Trace:
    measured, none = run.series.outputs, np.zeros(p.own_sd.size)
    before, after = (measured - p.residuals(c, run, none)[:, : measured.shape[1]] for c in (p.model.theta, theta))
    names = [CHANNELS[symbol] for symbol in p.channels if symbol != THRUST]
    time = run.series.dt * (run.series.index + run.series.part)
    rudder = run.series.observe(run.series.inputs[:, 0])
    columns = [dict(zip(names, values.T, strict=True)) for values in (measured, before, after)]
    return Trace(run.name, role, time, rudder, *columns)
