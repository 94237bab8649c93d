"""Records cut into pieces: short horizons that start at measured states, and multiple shooting.

The stretches of multiple shooting have initial states that are unknowns, and are joined step by step.

Short runs do not diverge, whatever the coefficients, so a start may be poor and the ship unstable on its course.  The
jumps between stretches are penalised by their squares, in units of a standard deviation that is reduced until the
trajectory is continuous to a millionth of its size; a run over the whole record from there removes them exactly.
Bock 1983, Recent advances in parameter identification for ODE; the penalty's homotopy as in Voss, Timmer & Kurths 2004.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...models.model import Model
from ..numerics import factors
from ..records.series import Series
from ..simulation import free_run
from .minimiser import ROUGH, Minimum, levenberg_marquardt
from .problem import Point, Problem

HORIZONS = (32, 8, 2)
"""Pieces into which records are cut, in turn."""
SHORTEST_HORIZON = 16
"""Samples of a piece at least."""
HORIZON_ITERATIONS = 6
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
            found = levenberg_marquardt(cut, parameters, HORIZON_ITERATIONS, ROUGH)
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
    return series.stretch(series.index[a], series.index[b], slice(a, b + 1), found)


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


JUMP_SD = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
"""Standard deviations of the jumps in turn, in units of the states' size."""
SHORTEST_STRETCH = 8
"""Steps of the time grid in a stretch at least."""
ITERATIONS = 12
"""Iterations of each stage but the first."""


@dataclass(frozen=True)
class ShootingProblem(Problem):
    """A problem whose series are stretches; each pair (left, right) of `joints` is to be joined without a jump."""

    joints: tuple[tuple[int, int], ...] = ()
    jump_sd: np.ndarray = field(default_factory=lambda: np.ones(0))
    """(n,) unit in which jumps are penalised."""

    def jumps(self, z: np.ndarray) -> np.ndarray:
        """Differences (joints, n) between a stretch's end and the next one's initial state; zero for fixed states."""
        model, runs = self.unpack(z)
        found = np.zeros((len(self.joints), len(model.states)))
        for row, (left, right) in zip(found, self.joints, strict=True):
            series, state, free, _ = runs[left]
            row[list(free)] = (free_run.end_state(model, series, state) - runs[right][1])[list(free)]
        return found

    def at(self, z: np.ndarray) -> Point:
        point = super().at(z)
        if not np.isfinite(point.cost):
            return point
        cost = point.cost + 0.5 * float(np.sum((self.jumps(z) / self.jump_sd) ** 2))
        return point._replace(cost=cost if np.isfinite(cost) else np.inf)

    @property
    def arrow_shaped(self) -> bool:
        return False  # joints couple the initial states

    def _folded(self, point: Point, scale: np.ndarray, weights: tuple[np.ndarray, ...] | None) -> np.ndarray:
        return factors.fold(super()._folded(point, scale, weights), self._jump_rows(point.z))

    def rows(self, point: Point) -> np.ndarray | None:
        rows = super().rows(point)
        return None if rows is None else np.vstack([rows, self._jump_rows(point.z)])

    def residuals(self, z: np.ndarray, point: Point) -> np.ndarray:
        jumps = self.jumps(z) / self.jump_sd
        free = [-row[list(self.free[left])] for row, (left, _) in zip(jumps, self.joints, strict=True)]
        return np.concatenate([super().residuals(z, point), *free])

    def _jump_rows(self, z: np.ndarray) -> np.ndarray:
        """Rows of [derivatives | -jump] in units of the jumps' standard deviation."""
        model, runs = self.unpack(z)
        jacobian = None if self.unknowns is None else self.unknowns.jacobian(z[: self.n_parameters])
        rows = [np.zeros((0, self.width + 1))]
        for left, right in self.joints:
            series, state, free, place = runs[left]
            end, columns = free_run.end_of(model, series, state, free)
            rows_of_free = np.column_stack([columns, runs[right][1] - end])[list(free)]
            wide = free_run.embed(rows_of_free, jacobian, self.n_parameters, place, self.width)
            wide[np.arange(len(free)), runs[right][3] + np.arange(len(free))] -= 1.0
            rows.append(wide / self.jump_sd[list(free), None])
        return np.vstack(rows)

    def whole_run_unknowns(self, z: np.ndarray) -> np.ndarray:
        """The unknowns of runs over whole records: those of each record's first stretch."""
        joined = {right for _, right in self.joints}
        _, runs = self.unpack(z)
        states = [z[place : place + len(free)] for i, (_, _, free, place) in enumerate(runs) if i not in joined]
        return np.concatenate([z[: self.n_parameters], *states])


class ShootingFit(NamedTuple):
    """Stretches joined by penalties: the problem with its last penalty, its minimum and all iterations."""

    problem: ShootingProblem
    minimum: Minimum
    n_iterations: int


def fit_by_shooting(problem: Problem, parameters: np.ndarray, stretches: int, max_iterations: int) -> ShootingFit:
    """The problem (channels weighted by their sensors) from coefficients or parameters, joined in stages."""
    chain = shooting_problem(problem, stretches)
    z, count = chain.start(parameters), 0
    size = chain.jump_sd
    for stage, share in enumerate(JUMP_SD):
        chain = replace(chain, jump_sd=share * size)
        found = levenberg_marquardt(chain, z, ITERATIONS if stage else max_iterations, ROUGH)
        z, count = found.z, count + found.n_iterations
    return ShootingFit(chain, found, count)


def shooting_problem(problem: Problem, stretches: int) -> ShootingProblem:
    """The problem with every record cut into that many stretches; jumps are in units of the states' size."""
    cut, free, joints = [], [], []
    for series, own_free in zip(problem.series, problem.free, strict=True):
        pieces = stretches_of(series, problem.model, stretches)
        joints += [(len(cut) + i, len(cut) + i + 1) for i in range(len(pieces) - 1)]
        cut += pieces
        free += [own_free] * len(pieces)
    starts = np.array([s.start for s in cut])
    size = starts.std(axis=0) + np.mean([s.start_sd for s in cut], axis=0)
    shared = {"unknowns": problem.unknowns, "loss": problem.loss, "sensor": problem.sensor}
    size = np.where(size > 0.0, size, 1.0)
    return ShootingProblem(problem.model, tuple(cut), tuple(free), joints=tuple(joints), jump_sd=size, **shared)


def stretches_of(series: Series, model: Model, count: int) -> list[Series]:
    """The series cut at points of its time grid; each stretch but the first starts at the measured state there."""
    steps = len(series.inputs) - 1
    edges = np.round(np.linspace(0, steps, max(1, min(count, steps // SHORTEST_STRETCH)) + 1)).astype(int)
    found = []
    for a, b in pairwise(edges.tolist()):
        within = (series.index >= a) & ((series.index < b) | (b == steps))
        start = series.start
        if a and within.any():
            start = measured_state(series, model, int(np.flatnonzero(within)[0]), start)
        found.append(series.stretch(a, b, within, start))
    return found
