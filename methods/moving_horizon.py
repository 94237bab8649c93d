"""Moving-horizon estimation of states and coefficients.

A horizon of some stretches moves along every record, one stretch at a time.  Its unknowns are the coefficients and the
state at the start of every stretch.  The cost is half the squares of the output errors, of the jumps between stretches
(the disturbances, in units of the process noise) and of the arrival cost.  That one stands for all samples before the
horizon: what they say of the coefficients and of the horizon's first state, linearised where the last horizon ended.
It is kept as a triangular factor.  When the horizon moves, the rows of the stretch that leaves are folded into it, the
state at the start of that stretch is eliminated, and a forgetting factor widens it.

As in `kalman`, the first arrival cost comes from least squares and the process noise from the likelihood of the
innovations, and every pass over the records starts from the last pass's coefficients with the first prior.  Sensors
have the noise that the records show in the first pass, the residuals of the last pass in the others: a horizon that
holds the whole record is the output-error problem.
Sources: Rao, Rawlings & Mayne 2003, IEEE Trans. Autom. Control 48(2), 246 (arrival cost); Kuehl, Diehl, Kraus,
Schloeder & Bock 2011, Comput. Chem. Eng. 35(1), 71 (its update by an orthogonal decomposition).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import ClassVar, NamedTuple

import numpy as np

from ..datasets.record import Record
from ..estimation.likelihood.linear_problem import NULL
from ..estimation.likelihood.minimiser import levenberg_marquardt
from ..estimation.likelihood.problem import Point, Problem, free_start_problem, sensor_sd_of
from ..estimation.likelihood.shooting import ShootingProblem, shooting_problem, stretches_of
from ..estimation.methods_only.tuning.space import Integer, Real
from ..estimation.numerics import factors
from ..estimation.records.gaps import unbroken_series
from ..estimation.records.series import Series
from ..estimation.regression.starts import Start, starts_of
from ..estimation.results.fit import Fit
from ..estimation.simulation import free_run
from ..models.errors import BadInput, FitFailed
from ..models.linear_algebra import pinv
from ..models.model import Model
from .base import Method
from .kalman import NARROWER, NEAR, PROCESS, best_noise, largest_change, prior_factor, square_changes
from .options import POSITIVE, SHARE, option, whole


class MovingHorizon(Method):
    """Output error in a horizon that moves along the records, with an arrival cost for all samples before it.

    Unknowns of a horizon are the coefficients and a state for every move; disturbances act between them.

    Records need the rudder and at least one of yaw rate, heading, surge and sway.  `trajectory` has a row for every
    horizon.
    """

    name = "moving-horizon"
    title = "moving-horizon estimation of states and coefficients with an arrival cost"
    minutes = True
    brief: ClassVar = {"passes": 2}
    order_matters = True

    horizon: int = option(120, "samples of a horizon", whole(2), Integer(30, 300, log=True))
    step: float = option(1.0 / 3.0, "share of the horizon by which it moves, 1 divided by a whole number", SHARE)
    forgetting: float = option(
        1.0,
        "factor on the information of the arrival cost at every move; at 1 nothing is forgotten, below 1 the standard "
        "errors of coefficients that a manoeuvre does not excite grow with every move",
        SHARE,
        Real(0.98, 1.0),
    )
    passes: int = option(
        6, "runs over all records at most; the last is the one after which the coefficients stand still", whole(1)
    )
    inflation: float = option(
        5.0,
        "factor on the standard deviations of the least-squares start that make the first arrival cost",
        POSITIVE,
        Real(0.1, 1000.0, log=True),
    )

    def check_options(self) -> None:
        super().check_options()
        moves = round(1.0 / self.step)
        if abs(moves * self.step - 1.0) > 1e-6:
            raise BadInput(f"step is {self.step!r}, 1 divided by a whole number is needed")

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        horizon = Horizon(self.horizon, round(1.0 / self.step), self.forgetting)
        records, series = unbroken_series(records, model, len(model.coordinates))
        problem, change = free_start_problem(series, model), square_changes(model, series)
        start = _best_start(starts_of(records, model), problem, horizon)
        prior = prior_factor(start.source, self.inflation)
        for narrower in NARROWER:
            first = Arrival.prior(start.coefficients, narrower * prior)
            done = run_passes(problem, first, horizon, change, self.passes)
            if done:
                return _as_fit(done, problem)
        raise FitFailed("the model diverges within a horizon of the first pass")


ITERATIONS = 5
"""Iterations in a horizon at most; most horizons need one."""
ENOUGH = 0.1
"""Predicted gain in log likelihood at which the search in a horizon stops."""
FIRST_DAMPING = 1e-12
"""The first step is Gauss-Newton's: where the records say little, the arrival cost limits it."""
SETTLED = 1e-3
"""Change of the coefficients over a pass, in standard deviations, after which no other pass follows."""


class Arrival(NamedTuple):
    """The arrival cost: half the squares of rows (m, a + 1) of [derivatives | residuals], linear about centre (a,).

    Its a unknowns are the first ones of a horizon: the coefficients and the state where it begins.
    """

    rows: np.ndarray
    centre: np.ndarray

    @classmethod
    def prior(cls, coefficients: np.ndarray, factor: np.ndarray) -> Arrival:
        """That of coefficients (p,) with the covariance factor factor', factor (p, p)."""
        return cls(np.column_stack([pinv(factor), np.zeros(factor.shape[1])]), coefficients)

    def residuals(self, z: np.ndarray) -> np.ndarray:
        """Residuals (m,) at unknowns z (width,) of a horizon."""
        return self.rows[:, -1] - self.rows[:, :-1] @ (z[: self.centre.size] - self.centre)

    def rows_at(self, z: np.ndarray) -> np.ndarray:
        """Rows (m, width + 1) of [derivatives | residuals] at unknowns z (width,) of a horizon."""
        after = np.zeros((len(self.rows), z.size - self.centre.size))
        return np.column_stack([self.rows[:, :-1], after, self.residuals(z)])

    def forgotten(self, forgetting: float) -> Arrival:
        """The same with a covariance that is 1 / forgetting times as large."""
        return self._replace(rows=np.sqrt(forgetting) * self.rows)

    def with_start(self, series: Series, free: Sequence[int]) -> Arrival:
        """That of a record's first horizon, from that of the coefficients: measured states are free, others have the
        prior of the record's initial state."""
        wide = Arrival(self.rows, np.concatenate([self.centre, series.start[list(free)]]))
        p, places = self.centre.size, [i for i, state in enumerate(free) if state not in series.columns]
        sd = series.start_sd[[free[i] for i in places]]
        states = np.zeros((len(places), wide.centre.size + 1))
        states[np.arange(len(places)), p + np.array(places, int)] = np.divide(
            1.0, sd, out=np.zeros(sd.size), where=sd > 0
        )
        shared = self._replace(centre=self.centre).rows_at(np.append(self.centre, np.zeros(len(free))))
        return wide._replace(rows=np.vstack([shared, states]))


NOTHING = Arrival(np.zeros((0, 1)), np.zeros(0))
"""The arrival cost of nothing."""


@dataclass(frozen=True)
class HorizonProblem(ShootingProblem):
    """The stretches of one horizon, joined by process noise, with an arrival cost."""

    arrival: Arrival = NOTHING

    def at(self, z: np.ndarray) -> Point:
        point = super().at(z)
        return point._replace(cost=point.cost + 0.5 * float(np.sum(self.arrival.residuals(z) ** 2)))

    def _folded(self, point: Point, scale: np.ndarray, weights: tuple[np.ndarray, ...] | None) -> np.ndarray:
        return factors.fold(super()._folded(point, scale, weights), self.arrival.rows_at(point.z))


def eliminated(factor: np.ndarray, first: int, last: int) -> np.ndarray:
    """Rows (m, w - d + 1) on the other unknowns of rows (M, w + 1), the d unknowns first .. last - 1 at their best.

    The least sum of squares over some of the unknowns is a sum of squares of the others.
    """
    order = [*range(first, last), *range(first), *range(last, factor.shape[1])]
    d = last - first
    return factors.upper_triangle(factor[:, order])[d:, d:]


class Horizon(NamedTuple):
    """Steps of the time grid in a horizon, the stretches that it is made of, and the forgetting factor of one move."""

    steps: int
    stretches: int
    forgetting: float


class HorizonPass(NamedTuple):
    """One pass over all records."""

    arrival: Arrival
    """The arrival cost of the coefficients (p,) after the last sample."""
    path: np.ndarray
    """(H, p) coefficients of each horizon."""
    time_s: np.ndarray
    """(H,) seconds of record up to the end of each horizon, summed over the records."""
    squares: np.ndarray
    """(n,) sum of squared residuals of each state's channel, every sample in the last horizon that holds it."""
    process: np.ndarray
    """(n,) process noise variances of a step of the time grid."""
    n_iterations: int
    change: float = np.inf
    """Largest change of a coefficient over the pass, in posterior standard deviations."""

    @property
    def coefficients(self) -> np.ndarray:
        """(p,)"""
        return self.arrival.centre

    @property
    def covariance(self) -> np.ndarray:
        """(p, p), infinite on the diagonal where neither records nor prior determine a coefficient."""
        return factors.solve(self.arrival.rows, NULL).covariance


def horizon_pass(problem: Problem, arrival: Arrival, horizon: Horizon, process: np.ndarray) -> HorizonPass:
    """All records in turn: the coefficients are carried over, the states start anew with each record.

    Parameters
    ----------
    problem : the records with free initial states, its channels weighted by `sensor`.
    arrival : of the coefficients (p,).
    process : (n,) process noise variances of a step of the time grid.
    """
    found, passed = [], 0.0
    for series, free in zip(problem.series, problem.free, strict=True):
        own = replace(problem, series=(series,), free=(free,))
        found.append(_along(own, arrival, horizon, process))
        found[-1] = found[-1]._replace(time_s=passed + found[-1].time_s)
        arrival, passed = found[-1].arrival, passed + series.dt * (len(series.inputs) - 1)
    return HorizonPass(
        arrival,
        np.concatenate([one.path for one in found]),
        np.concatenate([one.time_s for one in found]),
        np.sum([one.squares for one in found], axis=0),
        process,
        sum(one.n_iterations for one in found),
    )


def _along(problem: Problem, arrival: Arrival, horizon: Horizon, process: np.ndarray) -> HorizonPass:
    """One record, from the arrival cost of the coefficients."""
    series, free, p = problem.series[0], problem.free[0], problem.n_parameters
    steps = len(series.inputs) - 1
    stretches = stretches_of(series, problem.model, max(1, round(steps * horizon.stretches / horizon.steps)))
    jump_sd = np.sqrt(steps / len(stretches) * process)
    empty = HorizonProblem(problem.model, (), (), sensor=problem.sensor, jump_sd=np.where(jump_sd > 0.0, jump_sd, 1.0))
    c, arrival = arrival.centre, arrival.with_start(series, free)
    window, path, ends, squares, count = stretches[:1], [], [], np.zeros(len(problem.model.states)), 0
    for k, following in enumerate([*stretches[1:], None]):
        if following is not None and len(window) < horizon.stretches:
            window.append(_after(problem.model.with_coefficients(c), window[-1], following))
            continue
        over = _over(empty, window, free, arrival)
        if not np.isfinite(over.at(over.start(c)).cost):
            window[-1] = stretches[k]
            over = _over(empty, window, free, arrival)
        minimum = levenberg_marquardt(over, over.start(c), ITERATIONS, ENOUGH, first_damping=FIRST_DAMPING)
        if not np.isfinite(minimum.cost):
            raise FitFailed("the model diverges within a horizon")
        c, count = minimum.z[:p], count + minimum.n_iterations
        window = [replace(run.series, start=run.start) for run in over.unpack(minimum.z)[1]]
        path.append(c)
        ends.append(k)
        if following is not None:
            window.append(_after(problem.model.with_coefficients(c), window[-1], following))
            left = _over(empty, [window[0], window[1].stretch(0, 0, slice(0), window[1].start)], free, arrival)
            point = left.at(left.start(c))
            squares += point.squares
            rows = eliminated(left.factor(point), p, p + len(free))
            arrival = Arrival(rows, np.delete(point.z, slice(p, p + len(free)))).forgotten(horizon.forgetting)
            window = window[1:]
    last = Arrival(eliminated(over.factor(minimum.point), p, over.width), c)
    time_s = series.dt * np.cumsum([len(s.inputs) - 1 for s in stretches])[ends]
    return HorizonPass(last, np.array(path), time_s, squares + minimum.point.squares, process, count)


def _over(empty: HorizonProblem, window: Sequence[Series], free: tuple[int, ...], arrival: Arrival) -> HorizonProblem:
    """The problem over the stretches of a window, joined one to the next."""
    joints = tuple(pairwise(range(len(window))))
    return replace(empty, series=tuple(window), free=(free,) * len(window), joints=joints, arrival=arrival)


def _after(model: Model, before: Series, stretch: Series) -> Series:
    """The stretch with the predicted end of the one before as its start; with its own start where that diverges."""
    end = free_run.end_state(model, before, before.start)
    return replace(stretch, start=end) if np.isfinite(end).all() else stretch


def _best_start(starts: Sequence[Start], problem: Problem, horizon: Horizon) -> Start:
    """The start with the least error of runs over stretches from measured states."""
    steps = np.mean([len(s.inputs) - 1 for s in problem.series])
    count = max(1, round(steps * horizon.stretches / horizon.steps))
    cut = shooting_problem(replace(problem, sensor=sensor_sd_of(problem)), count)
    return starts[int(np.argmin([cut.at(cut.start(start.coefficients)).cost for start in starts]))]


def run_passes(
    problem: Problem, first: Arrival, horizon: Horizon, change: np.ndarray, passes: int
) -> list[HorizonPass]:
    """Up to `passes` passes, until the coefficients stand still or a pass diverges; none if the first one does.

    Parameters
    ----------
    first : the first arrival cost of the coefficients (p,); later passes start from it, about other coefficients.
    change : (n,) as in `kalman.best_noise`.
    """
    done: list[HorizonPass] = []
    c, sensor, levels = first.centre, sensor_sd_of(problem), PROCESS
    for _ in range(passes):
        _, noise = best_noise(problem.model.with_coefficients(c), problem.series, change, sensor**2, levels)
        weighted = replace(problem, sensor=sensor)
        try:
            found = horizon_pass(weighted, first._replace(centre=c), horizon, noise.process)
        except FitFailed:
            return [*done[:-1], done[-1]._replace(change=np.inf)] if done else []
        done.append(found._replace(change=largest_change(found.coefficients - c, found.covariance)))
        if done[-1].change < SETTLED:
            break
        c = found.coefficients
        levels = [level for level in PROCESS if 1.0 / NEAR < level / noise.level < NEAR]
        sensor = np.sqrt(found.squares / np.maximum(problem.counts, 1.0) + problem.floors)
    return done


def _as_fit(done: Sequence[HorizonPass], problem: Problem) -> Fit:
    last, names = done[-1], problem.model.states
    converged = last.change < 1.0
    failure = "the coefficients still moved in the last pass" if np.isfinite(last.change) else "a pass diverged"
    duration = sum(s.dt * (len(s.inputs) - 1) for s in problem.series)
    used, rms = np.flatnonzero(problem.counts), np.sqrt(last.squares / np.maximum(problem.counts, 1.0))
    return Fit(
        last.coefficients,
        last.covariance,
        converged=converged,
        message="" if converged else failure,
        n_iterations=sum(one.n_iterations for one in done),
        trajectory=np.concatenate([one.path for one in done]),
        trajectory_time_s=np.concatenate([i * duration + one.time_s for i, one in enumerate(done)]),
        extra={
            "channels": [names[i] for i in used],
            "residual_sd": {names[i]: float(rms[i]) for i in used},
            "process_sd": {name: float(np.sqrt(q)) for name, q in zip(names, last.process, strict=True) if q > 0.0},
            "passes": len(done),
            "horizons": len(last.path),
            "largest_change": last.change,
        },
    )
