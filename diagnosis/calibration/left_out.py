"""Records that were left out: measured channels against free runs, and where the remaining error lies."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ..free_runs.problem import Lane
from ..free_runs.units import names_of_units
from ..result import Trace
from .result import Remaining
from .whole_records import columns_of_states

if TYPE_CHECKING:
    from ..free_runs.problem import FreeRuns
    from .group_fits import GroupFit


def left_out_traces(plain: FreeRuns, explained: FreeRuns, final: GroupFit) -> tuple[Trace, ...]:
    """Training records; the run after the calibration is by the fit that left the record out, with what known causes
    explain in `explained`, and told as the record's own sensors would show it."""
    names = names_of_units(plain.units)
    return tuple(_trace(plain, explained, k, names[k], values) for k, values in enumerate(final.fitted.without))


def _trace(plain: FreeRuns, explained: FreeRuns, k: int, name: str, values: Mapping[str, float]) -> Trace:
    series, columns = plain.units[k].stretch.series, columns_of_states(plain)
    measured = plain.measured[k][:, : len(columns)]
    before = measured - blind_error(plain, k, {})
    after = measured - blind_error(explained, k, values)
    time = series.dt * (series.index + series.part)
    sides = [dict(zip(columns, part.T, strict=True)) for part in (measured, before, after)]
    return Trace(name, "train", time, series.observe(series.inputs[:, 0]), *sides)


def blind_error(runs: FreeRuns, k: int, values: Mapping[str, float]) -> np.ndarray:
    """Errors (N, S) of the states of a unit at values of the numbers, without own effects; 0 where nothing is
    measured."""
    error = runs.errors([Lane(k, values, runs.no_own[k])])[0][: len(runs.symbols), 0]
    return error.T


STANDS_OUT = 1.5
"""Share of the error over share of the time from which a condition is told."""
MOST_OF_IT = 0.3
"""Share of the error from which a condition is told."""


def remaining(runs: FreeRuns, final: GroupFit) -> tuple[Remaining, ...]:
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
