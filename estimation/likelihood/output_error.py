"""Output error: the model that, run freely from an initial state, comes closest to the measured outputs.

Maximum likelihood for white sensor noise on yaw rate, heading, surge and sway (those that a record has), with the
standard deviation of each channel estimated too: the sum of N_c log s_c is minimised by Levenberg-Marquardt steps on
generated forward sensitivities.  Every step comes from orthogonal factors, so weakly identified directions keep the
accuracy that the records allow.

The cost has many minima.  Starts come from least squares, never from the true coefficients; the best are tried as they
are and after fits over growing horizons, where the run is restarted at measured states, or by multiple shooting.
Initial states are unknowns of the fit.  If no start reduces every residual to a few times its sensor's noise, the model
does not explain the records.  Free initial states would then hide what the model lacks, and the heading, which
integrates every error, would dominate the fit.  Runs then start where the records start, and heading only counts where
no yaw rate is measured.
Source: Jategaonkar 2015, Flight Vehicle System Identification, ch 4.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...datasets.record import Record
from ...models.errors import CannotFit, FitFailed
from ...models.model import Model
from ..numerics import factors
from ..records.gaps import unbroken_series
from ..records.series import Series
from ..regression.starts import starts_of
from ..results.fit import Fit, mapped
from .linear_problem import NULL
from .loss import Loss
from .minimiser import ROUGH, STRAIGHT, Minimum, levenberg_marquardt
from .problem import Point, Problem, explains_records, fixed_start_problem, free_start_problem, sensor_sd_of
from .shooting import ITERATIONS, ShootingFit, ShootingProblem, fit_by_shooting, fit_growing_horizons, short_runs
from .unknowns import Unknowns


def identify(
    records: Sequence[Record],
    model: Model,
    unknowns: Unknowns | None = None,
    loss: Loss | None = None,
    max_iterations: int = 60,
    shooting: int = 1,
) -> Outcome:
    """Output-error fit of records from least-squares starts; arguments as in `fit_output_error`.

    Records are cut at long gaps and splices: every stretch has an initial state of its own.

    Raises
    ------
    CannotFit : a record lacks a channel, or there are no more measured values than unknowns.
    FitFailed : the model diverges from every start.
    """
    series, starts = _prepared(records, model, unknowns)
    return fit_output_error(series, model, starts, max_iterations, unknowns, loss, shooting)


def problem_of(
    records: Sequence[Record], model: Model, unknowns: Unknowns | None = None
) -> tuple[Problem, list[np.ndarray]]:
    """The problem with free initial states, and coefficients (p,) or estimated parameters (k,) to start from; raises as
    `identify`."""
    series, starts = _prepared(records, model, unknowns)
    return free_start_problem(series, model, unknowns), starts


def _prepared(
    records: Sequence[Record], model: Model, unknowns: Unknowns | None
) -> tuple[list[Series], list[np.ndarray]]:
    k = len(model.coordinates) if unknowns is None else len(unknowns.estimated)
    records, series = unbroken_series(records, model, k)
    return series, _starts(records, model, unknowns)


def _starts(records: Sequence[Record], model: Model, unknowns: Unknowns | None) -> list[np.ndarray]:
    """Coefficients (p,) or estimated parameters (k,) to start from; the means of a complete prior are among them."""
    found = starts_of(records, model)
    if unknowns is None:
        return [start.coefficients for start in found]
    starts = [unknowns.start(start.coefficients, start.source) for start in found]
    mean = unknowns.mean[unknowns.estimated]
    kept = [start for start in [*starts, mean] if start is not None and np.isfinite(start).all()]
    if not kept:
        raise CannotFit("least squares gives no start within the bounds")
    return kept


def as_fit(outcome: Outcome) -> Fit:
    """The outcome as a method's result, with the facts of the fit in `extra`."""
    problem, minimum = outcome.problem, outcome.minimum
    names, point, unknowns = problem.model.states, minimum.point, problem.unknowns
    covariance, rank = _covariance(problem, point)
    rms = np.sqrt(point.squares / np.maximum(problem.counts, 1.0))
    used = np.flatnonzero(problem.counts)
    shooting = isinstance(problem, ShootingProblem)
    extra = {
        "channels": [names[i] for i in used],
        "residual_sd": {names[i]: float(rms[i]) for i in used},
        "explains_records": outcome.adequate,
        "initial_states": "estimated" if outcome.adequate or shooting else "record",
        "attempts": outcome.n_attempts,
        "cost": minimum.cost,
    }
    if problem.loss is not None:
        extra["scale"] = {names[i]: float(point.sd[i]) for i in used}
    if isinstance(problem, ShootingProblem):
        jumps = problem.jumps(minimum.z)
        extra["jumps"] = {names[i]: float(np.abs(jumps[:, i]).max(initial=0.0)) for i in range(len(names))}
    return Fit(
        problem.coefficients(minimum.z),
        covariance if unknowns is None else mapped(unknowns.jacobian(minimum.z[: problem.n_parameters]), covariance),
        converged=minimum.converged,
        message=_message(outcome, rank),
        n_iterations=outcome.n_iterations,
        extra=extra,
        fixed=() if unknowns is None else unknowns.fixed_names,
    )


def _covariance(problem: Problem, point: Point) -> tuple[np.ndarray, int]:
    """Covariance (k, k) of the parameters, and how many directions of all unknowns the records determine."""
    if problem.arrow_shaped:
        arrow = problem.arrow(point, information=True)
        solution = factors.solve(arrow.shared, NULL)
        return solution.covariance, solution.rank + arrow.own_rank
    solution, n = factors.solve(problem.information(point), NULL), problem.n_parameters
    return solution.covariance[:n, :n], solution.rank


def _message(outcome: Outcome, rank: int) -> str:
    notes = [factors.rank_message(rank, outcome.problem.width)]
    if not outcome.adequate:
        notes.insert(0, "residuals exceed the sensor noise: the model does not explain the records")
    if at := _at_bounds(outcome):
        notes.append(f"at a bound: {', '.join(at)}")
    if isinstance(outcome.problem, ShootingProblem):
        notes.append("no free run follows whole records: the fit is one of stretches joined by multiple shooting")
    if not outcome.minimum.converged:
        notes.append("stopped before convergence")
    return "; ".join(filter(None, notes))


def _at_bounds(outcome: Outcome) -> list[str]:
    """Names of the parameters that are at one of their bounds."""
    problem = outcome.problem
    if problem.unknowns is None or not problem.unknowns.has_bounds:
        return []
    y, estimated = outcome.minimum.z[: problem.n_parameters], problem.unknowns.estimated
    at_bound = (y == problem.unknowns.low[estimated]) | (y == problem.unknowns.high[estimated])
    return [name for name, at in zip(problem.unknowns.names, at_bound, strict=True) if at]


GOOD, ADEQUATE = 1.5, 3.0
"""Residual, relative to the sensor noise, at which the search ends, and below which a model explains the records."""
STARTS = 2
"""Starts that are minimised from."""
STRETCHES = 8
"""Stretches of multiple shooting where it replaces growing horizons."""
SAME = 10.0
"""Difference of log likelihood below which two minima of a rough search count as the same."""


class Outcome(NamedTuple):
    """A fitted problem, whether the model explains the records, the minima searched and the iterations in total."""

    problem: Problem
    minimum: Minimum
    adequate: bool
    n_attempts: int
    n_iterations: int


def fit_output_error(
    series: Sequence[Series],
    model: Model,
    starts: Sequence[np.ndarray],
    max_iterations: int = 60,
    unknowns: Unknowns | None = None,
    loss: Loss | None = None,
    shooting: int = 1,
) -> Outcome:
    """Output-error fit from several starts; the first that explains the records well ends the search.

    Parameters
    ----------
    series : the records, with all the channels they have.
    starts : coefficients (p,), or where there are `unknowns` the estimated parameters (k,).
    max_iterations : of one minimisation.
    unknowns : the parameters that are estimated, with bounds and prior; None: all coefficients.
    loss : None: least squares.
    shooting : stretches into which records are cut by multiple shooting; 1: runs over whole records.

    Raises
    ------
    FitFailed : the model diverges from every start.
    """
    free = free_start_problem(series, model, unknowns, loss)
    weighted = replace(free, sensor=sensor_sd_of(free))
    starts, stretched = _best_starts(weighted, starts), None
    if shooting > 1:
        outcome, stretched, starts = _by_shooting(free, weighted, starts, max_iterations, shooting)
        if outcome is not None:
            return outcome
    tried: list[np.ndarray] = []
    found: list[Minimum] = []
    for growing, start in [(growing, start) for growing in (False, True) for start in starts]:
        z, count = _approach(weighted, start) if growing else (weighted.start(start), 0)
        tried.append(z[: free.n_parameters])
        found.append(_first_minimum(free, weighted, z, max_iterations, count))
        if found[-1].converged and explains_records(free, found[-1].point, GOOD):
            return _polished(free, found[-1], True, found, max_iterations)
        same = len(found) > 1 and abs(found[-1].cost - found[-2].cost) < SAME
        if same and not explains_records(free, found[-1].point, ADEQUATE):
            break
    best = min(found, key=lambda minimum: minimum.cost)
    if explains_records(free, best.point, ADEQUATE):
        return _polished(free, best, True, found, max_iterations)
    return _inadequate(free, tried, found, stretched, max_iterations)


def _inadequate(
    free: Problem,
    tried: Sequence[np.ndarray],
    found: Sequence[Minimum],
    stretched: ShootingFit | None,
    max_iterations: int,
) -> Outcome:
    """The best fit of a model that does not explain the records: runs start where the records start.

    Free initial states would hide what the model lacks.  So would numbers far along a valley of the cost: steps are
    straight.  The fit of joined stretches is taken where it is better.
    """
    fixed, most = fixed_start_problem(free), (max_iterations + 1) // 2
    minima = [levenberg_marquardt(fixed, fixed.start(start), most, ROUGH, most) for start in tried]
    best = min(minima, key=lambda minimum: minimum.cost)
    searched = [*found, *minima]
    if stretched is not None and _misfit(fixed, stretched.minimum) < _misfit(fixed, best):
        problem = replace(stretched.problem, sensor=None)
        return _polished(problem, stretched.minimum, False, searched, max_iterations)
    if not np.isfinite(best.cost):
        raise FitFailed("the simulation diverges from every start")
    return _polished(fixed, best, False, searched, max_iterations)


def _by_shooting(
    free: Problem, weighted: Problem, starts: Sequence[np.ndarray], max_iterations: int, stretches: int
) -> tuple[Outcome | None, ShootingFit | None, list[np.ndarray]]:
    """The first fit by multiple shooting that explains the records; the best that no run follows; the end points.

    Runs over whole records join the stretches.  Where such a run leaves the trajectory (an unstable ship, a long
    record), the joined stretches themselves are the fit.  It need not explain the records: the noise of a rudder sensor
    alone moves the heading of an unstable ship by more than the error of a compass.
    """
    ends: list[np.ndarray] = []
    found: list[Minimum] = []
    stretched: list[ShootingFit] = []
    for start in starts:
        fit = fit_by_shooting(weighted, start, stretches, max_iterations)
        z = fit.minimum.z
        ends.append(z[: weighted.n_parameters])
        whole = fit.problem.whole_run_unknowns(z)
        found.append(_first_minimum(free, weighted, whole, max_iterations, fit.n_iterations))
        if explains_records(free, found[-1].point, ADEQUATE):
            return _polished(free, found[-1], True, found, max_iterations), None, ends
        if explains_records(fit.problem, fit.minimum.point, ADEQUATE):
            problem = replace(fit.problem, sensor=None)
            return _polished(problem, fit.minimum, True, found, max_iterations), None, ends
        if _misfit(weighted, found[-1]) > ADEQUATE**2 * _misfit(weighted, fit.minimum):
            stretched.append(fit)
    return None, min(stretched, key=lambda fit: fit.minimum.cost, default=None), ends


def _misfit(problem: Problem, minimum: Minimum) -> float:
    """Sum of the squared residuals in the problem's channels, in units of the noise of their sensors."""
    used = problem.counts > 0
    return float(np.sum(minimum.point.squares[used] / sensor_sd_of(problem)[used] ** 2))


def _approach(weighted: Problem, start: np.ndarray) -> tuple[np.ndarray, int]:
    """Unknowns after fits over growing horizons, by multiple shooting where not every state is measured."""
    if short_runs(weighted) is not None:
        parameters, count = fit_growing_horizons(weighted, start)
        return weighted.start(parameters), count
    fit = fit_by_shooting(weighted, start, STRETCHES, ITERATIONS)
    return fit.problem.whole_run_unknowns(fit.minimum.z), fit.n_iterations


def _first_minimum(free: Problem, weighted: Problem, start: np.ndarray, max_iterations: int, count: int) -> Minimum:
    """A first minimum of the problem with free initial states, from unknowns `start` after `count` iterations.

    Channels are weighted by the noise of their sensors first: weights that follow the residuals would favour a channel
    that fits already over one that does not fit yet.
    """
    near = levenberg_marquardt(weighted, start, max_iterations, ROUGH)
    count += near.n_iterations
    if not explains_records(weighted, near.point, 2.0 * ADEQUATE):
        return near._replace(point=free.at(near.z), n_iterations=count)
    found = levenberg_marquardt(free, near.z, max_iterations, ROUGH)
    return found._replace(n_iterations=count + found.n_iterations)


def _polished(
    problem: Problem, best: Minimum, adequate: bool, found: Sequence[Minimum], max_iterations: int
) -> Outcome:
    """The outcome: the best of the minima found, iterated to full accuracy."""
    last = levenberg_marquardt(problem, best.z, max_iterations, straight=STRAIGHT if adequate else max_iterations)
    return Outcome(problem, last, adequate, len(found), sum(f.n_iterations for f in [*found, last]))


def _best_starts(problem: Problem, starts: Sequence[np.ndarray]) -> list[np.ndarray]:
    """The STARTS best starts, by the error of short runs from measured states; of whole runs if a state is missing."""
    cut = short_runs(problem) or problem
    costs = [cut.at(cut.start(start)).cost for start in starts]
    return [starts[i] for i in np.argsort(costs, kind="stable")[:STARTS]]
