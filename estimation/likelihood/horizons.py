"""Output error over short horizons: records cut into pieces that start at measured states."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...models.model import Model
from ..records.series import Series
from .minimiser import ROUGH, levenberg_marquardt
from .problem import Problem

HORIZONS = (32, 8, 2)
"""Pieces into which records are cut, in turn."""
SHORTEST_HORIZON = 16
"""Samples of a piece at least."""
ITERATIONS = 6
"""Of the minimisation at each horizon."""


def short_runs(problem: Problem, pieces: int = HORIZONS[1]) -> Problem | None:
    """The problem with every record cut into pieces that start at measured states; None where that is impossible."""
    cut = [piece for s in problem.series for piece in _cut(s, problem.model, pieces)]
    return replace(problem, series=tuple(cut), free=((),) * len(cut)) if cut else None


def fit_growing_horizons(problem: Problem, parameters: np.ndarray) -> tuple[np.ndarray, int]:
    """Coefficients (or parameters) fitted over growing horizons, and the number of iterations.

    Every state must be measured (the hidden one is differenced); else the start is returned unchanged.
    """
    count = 0
    for pieces in HORIZONS:
        cut = short_runs(problem, pieces)
        if cut is not None:
            found = levenberg_marquardt(cut, parameters, ITERATIONS, ROUGH)
            parameters, count = found.z, count + found.n_iterations
    return parameters, count


def _cut(series: Series, model: Model, pieces: int) -> list[Series]:
    """The series in `pieces` of equal length, each started at the measured state there."""
    n = len(series.outputs)
    length = max(n // pieces, SHORTEST_HORIZON)
    needed = [i for i, name in enumerate(model.states) if name in ("u", "v", "r")]
    if series.part.any() or length >= n or not set(needed) <= set(series.columns.tolist()):
        return []
    edges = list(range(0, n - length + 1, length))
    return [piece for a in edges if (piece := _stretch(series, model, a, min(a + length, n - 1))) is not None]


def _stretch(series: Series, model: Model, a: int, b: int) -> Series | None:
    """Samples a..b as a series of their own; None if a state cannot be determined at a."""
    state = np.where(np.isin(np.arange(len(model.states)), series.columns), np.nan, 0.0)
    found = measured_state(series, model, a, state)
    if not np.isfinite(found).all() or b <= a:
        return None
    first, last = series.index[a], series.index[b]
    return replace(
        series,
        inputs=np.ascontiguousarray(series.inputs[first : last + 1]),
        outputs=series.outputs[a : b + 1],
        index=series.index[a : b + 1] - first,
        part=series.part[a : b + 1],
        start=found,
    )


def measured_state(series: Series, model: Model, a: int, otherwise: np.ndarray) -> np.ndarray:
    """State (n,) at sample a: the value there of a straight line through the samples around it.

    The slopes give the yaw acceleration, which takes the place of the hidden state, and the yaw rate where only the
    heading is measured.  States that cannot be determined so are taken from `otherwise` (n,).
    """
    window = max(2, len(series.outputs) // 400)
    near = slice(max(a - window, 0), a + window + 1)
    time = (series.index[near] + series.part[near] - series.index[a] - series.part[a]) * series.dt
    value, slope = _line(time, series.outputs[near])
    columns, states = series.columns.tolist(), list(model.states)
    found = otherwise.copy()
    found[columns] = np.where(np.isfinite(value), value, otherwise[columns])
    rate, heading = states.index("r"), states.index("psi")
    if rate not in columns and heading in columns and np.isfinite(slope[columns.index(heading)]):
        found[rate] = slope[columns.index(heading)]
    if states[0] == "w" and rate in columns and np.isfinite(slope[columns.index(rate)]):
        found[0] = slope[columns.index(rate)]
    return found


def _line(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Value at zero (c,) and slope (c,) of straight lines through values (m, c); nan where one is a gap."""
    middle = time.mean()
    slope = (time - middle) @ values / np.sum((time - middle) ** 2)
    return values.mean(axis=0) - slope * middle, slope
