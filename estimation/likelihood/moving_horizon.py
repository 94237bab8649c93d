"""Moving-horizon estimation of states and coefficients.

A horizon of some stretches moves along every record, one stretch at a time.  Its unknowns are the coefficients and the
state at the start of every stretch.  The cost is the sum of the squared output errors, of the jumps between stretches
(the disturbances, in units of the process noise) and of the arrival cost, which stands for all that lies before the
horizon: what the earlier samples say of the coefficients and of the horizon's first state, linearised where the last
horizon ended.  It is kept as a triangular factor.  When the horizon moves, the rows of the stretch that leaves are
folded into it and the state at the start of that stretch is eliminated; a forgetting factor widens it.

As in `filters.joint`, the first arrival cost comes from least squares, the process noise from the likelihood of the
innovations, and every pass over the records starts from the last pass's coefficients with the first prior.
Sources: Rao, Rawlings & Mayne 2003, IEEE Trans. Autom. Control 48(2), 246, sec III (arrival cost); Kuehl, Diehl, Kraus,
Schloeder & Bock 2011, Comput. Chem. Eng. 35(1), 71, sec 3.2 (its update by an orthogonal decomposition).
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...models.errors import CannotFit, FitFailed
from ...models.linear_algebra import pinv
from .. import free_run
from ..filters.joint import NEAR, PROCESS, best_noise, best_start, prior_factor, sensor_variances, square_changes
from ..fit import Fit
from ..gaps import unbroken
from ..regression import factors
from ..series import Series, series_of
from ..starts import starts_of
from .minimiser import NULL, levenberg_marquardt
from .problem import Point, Problem, free_start_problem, sensor_sd_of
from .shooting import ShootingProblem, stretches_of

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model

ITERATIONS = int(os.environ.get("HZ_IT", 5))
"""Iterations in a horizon at most; most need one or two."""
ENOUGH = float(os.environ.get("HZ_ENOUGH", 0.1))
"""Predicted gain in log likelihood at which a horizon's search stops."""
FIRST_DAMPING = 1e-12
"""The first step is Gauss-Newton's: the arrival cost holds what is little known."""
UPDATE = os.environ.get("HZ_UPDATE", "1") == "1"
PROC = float(os.environ.get("HZ_PROC", 1))


class Arrival(NamedTuple):
    """The arrival cost: half the squares of rows (m, a + 1) [derivatives | residuals], linear about centre (a,).

    The a unknowns are the first ones of the horizon: the coefficients, and the state where it begins.
    """

    rows: np.ndarray
    centre: np.ndarray

    def residuals(self, z: np.ndarray) -> np.ndarray:
        """Residuals (m,) at unknowns z (>= a,)."""
        return self.rows[:, -1] - self.rows[:, :-1] @ (z[: self.centre.size] - self.centre)

    def rows_at(self, z: np.ndarray) -> np.ndarray:
        """Rows (m, width + 1) of [derivatives | residuals] at all unknowns z (width,) of a horizon."""
        a = self.centre.size
        return np.column_stack([self.rows[:, :a], np.zeros((len(self.rows), z.size - a)), self.residuals(z)])


@dataclass(frozen=True)
class HorizonProblem(ShootingProblem):
    """The stretches of one horizon, joined by process noise, with an arrival cost."""

    arrival: Arrival | None = None

    def at(self, z: np.ndarray) -> Point:
        point = super().at(z)
        if self.arrival is None:
            return point
        return point._replace(cost=point.cost + 0.5 * float(np.sum(self.arrival.residuals(z) ** 2)))

    def _folded(self, point: Point, scale: np.ndarray, weights: tuple[np.ndarray, ...] | None) -> np.ndarray:
        factor = super()._folded(point, scale, weights)
        return factor if self.arrival is None else factors.fold(factor, self.arrival.rows_at(point.z))

    def end(self, point: Point) -> Arrival:
        """The arrival cost of the coefficients alone, after the horizon's last sample."""
        p = self.n_parameters
        return Arrival(eliminated(self.factor(point), p, self.width), point.z[:p])

    def moved(self, point: Point) -> Arrival:
        """The arrival cost after the horizon's first stretch, at its minimum `point`."""
        left, right = self.series[:2]
        nothing = replace(
            right, inputs=right.inputs[:1], outputs=right.outputs[:0], index=right.index[:0], part=right.part[:0]
        )
        first = replace(self, series=(left, nothing), free=self.free[:2], joints=((0, 1),))
        p, own = self.n_parameters, len(self.free[0])
        z = point.z[: first.width]
        rows = eliminated(first.factor(point._replace(z=z)), p, p + own)
        return Arrival(rows, np.delete(z, slice(p, p + own)))


def eliminated(factor: np.ndarray, first: int, last: int) -> np.ndarray:
    """Rows (m, w - d + 1) on the other unknowns of rows (M, w + 1) whose d unknowns first .. last - 1 are at their best.

    The minimum over some unknowns of a sum of squares is a sum of squares of the others.
    """
    order = [*range(first, last), *range(first), *range(last, factor.shape[1])]
    d = last - first
    return factors.upper_triangle(factor[:, order])[d:, d:]


class HorizonSettings(NamedTuple):
    """Samples of a horizon, stretches of a horizon, forgetting factor, sensor and process noise.

    sensor (n,) standard deviations, process (n,) variances of each state over a step of the grid.
    """

    horizon: int
    stretches: int
    forgetting: float
    sensor: np.ndarray
    process: np.ndarray


class HorizonPass(NamedTuple):
    """One pass over all records."""

    arrival: Arrival
    path: np.ndarray
    """(H, p) coefficients after each horizon."""
    time_s: np.ndarray
    """(H,) seconds of all records up to the end of each horizon."""
    squares: np.ndarray
    """(n,) squared residuals of each channel, every sample in the last horizon that holds it."""
    n_iterations: int

    @property
    def parameters(self) -> np.ndarray:
        return self.arrival.centre


def horizon_pass(problem: Problem, arrival: Arrival, settings: HorizonSettings) -> HorizonPass:
    """All records in turn: coefficients with their arrival cost are carried over, states start from each record.

    Raises
    ------
    FitFailed : the model diverges within a horizon.
    """
    path, times, squares, count, passed = [], [], np.zeros(len(problem.model.states)), 0, 0.0
    for series, free in zip(problem.series, problem.free, strict=True):
        along = _Along(problem, series, free, arrival, settings)
        found = along.run()
        arrival, count = found.arrival, count + found.n_iterations
        squares += found.squares
        path.append(found.path)
        times.append(passed + found.time_s)
        passed += series.dt * (len(series.inputs) - 1)
    return HorizonPass(arrival, np.concatenate(path), np.concatenate(times), squares, count)


class _Along:
    def __init__(self, problem, series, free, arrival, settings):
        self.problem, self.series, self.free, self.settings = problem, series, free, settings
        steps = len(series.inputs) - 1
        length = settings.horizon / settings.stretches
        self.stretches = stretches_of(series, problem.model, max(1, round(steps / length)))
        self.arrival = arrival

    def horizon(self, window, arrival):
        steps = np.mean([len(s.inputs) - 1 for s in window])
        sd = np.sqrt(steps * self.settings.process * PROC)
        return HorizonProblem(
            self.problem.model, tuple(window), (self.free,) * len(window), sensor=self.settings.sensor,
            joints=tuple(pairwise(range(len(window)))), jump_sd=np.where(sd > 0.0, sd, 1.0), arrival=arrival,
        )

    def run(self):
        n, m = len(self.stretches), min(self.settings.stretches, len(self.stretches))
        arrival, y = self.with_start(self.arrival), self.arrival.centre
        window: list[Series] = []
        path, times, total, count, passed = [], [], np.zeros(len(self.problem.model.states)), 0, 0.0
        for k in range(n):
            window.append(self.begun(window, self.stretches[k], y))
            passed += self.series.dt * (len(self.stretches[k].inputs) - 1)
            if len(window) < m:
                continue
            horizon = self.horizon(window, arrival)
            minimum = levenberg_marquardt(horizon, horizon.start(y), ITERATIONS, ENOUGH, first_damping=FIRST_DAMPING)
            if not np.isfinite(minimum.cost):
                raise FitFailed("the model diverges within a horizon")
            count += minimum.n_iterations
            model, runs = horizon.unpack(minimum.z)
            y = minimum.z[: horizon.n_parameters]
            window = [replace(s, start=run.start) for s, run in zip(window, runs, strict=True)]
            path.append(model.coefficients)
            times.append(passed)
            if k < n - 1:
                np.add.at(total, window[0].columns, free_run.squares(model, window[0], window[0].start))
                arrival = horizon.moved(minimum.point) if m > 1 else horizon.end(minimum.point)
                arrival = arrival._replace(rows=np.sqrt(self.settings.forgetting) * arrival.rows)
                window = window[1:] if m > 1 else [window[0]]
                if m == 1:
                    window = []
        total += minimum.point.squares
        return HorizonPass(horizon.end(minimum.point), np.array(path), np.array(times), total, count)

    def begun(self, window, stretch, y):
        if not window:
            return stretch
        model = self.problem.model.with_coefficients(self.problem.coefficients(y))
        found = free_run.end_state(model, window[-1], window[-1].start)
        return replace(stretch, start=found) if np.isfinite(found).all() else stretch

    def with_start(self, arrival):
        """The arrival cost with the prior of the initial states that have no channel."""
        open_ = [i for i, s in enumerate(self.free) if s not in self.series.columns]
        p, f = arrival.centre.size, len(self.free)
        states = np.zeros((len(open_), p + f + 1))
        states[np.arange(len(open_)), p + np.array(open_, int)] = 1.0 / self.series.start_sd[[self.free[i] for i in open_]]
        shared = np.column_stack([arrival.rows[:, :p], np.zeros((len(arrival.rows), f)), arrival.rows[:, -1]])
        return Arrival(np.vstack([shared, states]), np.concatenate([arrival.centre, self.series.start[list(self.free)]]))


def fit_moving_horizon(records, model, horizon, stretches, forgetting, passes, inflation):
    records = unbroken(records, model)
    series = [series_of(record, model) for record in records]
    if (n := sum(s.n_outputs for s in series)) <= len(model.coordinates):
        raise CannotFit(f"{n} measured values for {len(model.coordinates)} coefficients")
    sensor2, change = sensor_variances(series, len(model.states)), square_changes(model, series)
    start = best_start(starts_of(records, model), model, series, change, sensor2)
    model = model.with_coefficients(start.coefficients)
    prior = pinv(prior_factor(start.source, inflation))
    problem = free_start_problem(series, model)
    first = sensor = sensor_sd_of(problem)
    y = start.coefficients
    levels = PROCESS
    done = []
    for _ in range(passes):
        _, noise = best_noise(model.with_coefficients(y), series, change, sensor**2, levels)
        levels = [level for level in PROCESS if 1.0 / NEAR < level / noise.level < NEAR]
        arrival = Arrival(np.column_stack([prior, np.zeros(len(prior))]), y)
        settings = HorizonSettings(horizon, stretches, forgetting, sensor, noise.process)
        found = horizon_pass(problem, arrival, settings)
        if os.environ.get("HZ_V"):
            print(noise.level, sensor[problem.counts>0]/first[problem.counts>0], len(found.path), found.n_iterations, np.abs(found.parameters-y).max())
        done.append(found)
        y = found.parameters
        if UPDATE:
            rms = np.sqrt(found.squares / np.maximum(problem.counts, 1.0))
            floor = 1e8 * np.sqrt(problem.floors)
            sensor = np.sqrt(rms**2 + floor**2)
    solution = factors.solve(done[-1].arrival.rows, NULL)
    return Fit(y, solution.covariance, n_iterations=sum(d.n_iterations for d in done))
