"""Where the remaining error lies: by rudder, drift, speed and side, in records that were left out."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .attempts import Attempt
from .result import Remaining
from .traces import blind_error
from .whole_records import columns_of_states

if TYPE_CHECKING:
    from ..free_runs.problem import FreeRuns

STANDS_OUT = 1.5
"""Share of the error over share of the time from which a condition is told."""
MOST_OF_IT = 0.3
"""Share of the error from which a condition is told."""


def remaining(runs: FreeRuns, final: Attempt) -> tuple[Remaining, ...]:
    """Conditions that hold more of a channel's squared error than of the time, the most telling first."""
    each = [blind_error(runs, k, values) ** 2 for k, values in enumerate(final.fitted.without)]
    squares, conditions = np.concatenate(each), [_conditions(runs, k) for k in range(len(runs.units))]
    out = []
    for column, square in zip(columns_of_states(runs), squares.T, strict=True):
        for name in conditions[0]:
            chosen = np.concatenate([part[name] for part in conditions])
            share, time = float(square[chosen].sum() / max(square.sum(), 1e-300)), float(chosen.mean())
            if time > 0.0 and share > max(STANDS_OUT * time, MOST_OF_IT):
                out.append(Remaining(column, name, share, time))
    return tuple(sorted(out, key=lambda entry: entry.share_of_time - entry.share_of_error))


def _conditions(runs: FreeRuns, k: int) -> dict[str, np.ndarray]:
    """Condition -> where it holds (N,)."""
    own = dict(zip(runs.symbols, runs.measured[k].T, strict=False))
    series = runs.units[k].stretch.series
    out = {"rudder angles above 15 deg": np.abs(series.observe(series.inputs[:, 0])) > np.deg2rad(15.0)}
    if "r" in own:
        out |= {"turns to starboard": own["r"] > 0.0, "turns to port": own["r"] < 0.0}
    if "u" in own and "v" in own:
        u, v = own["u"], own["v"]
        out |= {"drift angles above 5 deg": np.abs(np.arctan2(-v, u)) > np.deg2rad(5.0)}
        out |= {"speeds below 85 % of the approach speed": u < 0.85 * u[np.isfinite(u)][:1]}
    return out
