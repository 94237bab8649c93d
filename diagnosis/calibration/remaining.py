"""Where the remaining error lies: by rudder, drift, speed and side, in records that were left out."""

from __future__ import annotations

import numpy as np

from ...estimation.diagnosis_only.mixed_effects.problem import THRUST, Problem
from ...models.model import CHANNELS
from .attempts import Attempt
from .result import Remaining

STANDS_OUT = 1.5
"""Share of the error over share of the time from which a condition is told."""


def remaining(p: Problem, final: Attempt) -> tuple[Remaining, ...]:
    """Conditions that hold more of a channel's squared error than of the time, the most telling first."""
    errors, conditions = [], []
    for run, left in zip(p.runs, final.left_out, strict=True):
        theta = final.fitted.theta.copy()
        theta[[n.place for n in final.fitted.numbers]] = left.values
        errors.append(p.residuals(theta, run, np.zeros(p.own_sd.size)))
        conditions.append(_conditions(p, run))
    total = np.concatenate(errors) ** 2
    out = []
    for c, symbol in enumerate(p.channels):
        if symbol == THRUST:
            continue
        square = np.nan_to_num(total[:, c])
        for name in conditions[0]:
            chosen = np.concatenate([part[name] for part in conditions])
            share, time = float(square[chosen].sum() / max(square.sum(), 1e-300)), float(chosen.mean())
            if time > 0.0 and share > STANDS_OUT * time and share > 0.3:
                out.append(Remaining(CHANNELS[symbol], name, share, time))
    return tuple(sorted(out, key=lambda entry: entry.share_of_time - entry.share_of_error))


def _conditions(p: Problem, run) -> dict[str, np.ndarray]:
    """Condition -> where it holds (N,)."""
    column = {symbol: i for i, symbol in enumerate(p.channels)}
    measured = run.series.outputs
    rudder = np.abs(run.series.observe(run.series.inputs[:, 0]))
    found = {"rudder angles above 15 deg": rudder > np.deg2rad(15.0)}
    if "r" in column:
        rate = measured[:, column["r"]]
        found |= {"turns to starboard": rate > 0.0, "turns to port": rate < 0.0}
    if "u" in column and "v" in column:
        u, v = measured[:, column["u"]], measured[:, column["v"]]
        found |= {"drift angles above 5 deg": np.abs(np.arctan2(-v, u)) > np.deg2rad(5.0)}
        found |= {"speeds below 85 % of the approach speed": u < 0.85 * u[np.isfinite(u)][:1]}
    return found
