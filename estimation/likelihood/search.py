"""The search for the lowest of the many minima of the output-error cost, from given starts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...models.errors import FitFailed
from ...models.model import Model
from ..records.series import Series
from .horizons import fit_growing_horizons, short_runs
from .loss import Loss
from .minimiser import ROUGH, STRAIGHT, Minimum, levenberg_marquardt
from .problem import Problem, explains_records, fixed_start_problem, free_start_problem, sensor_sd_of
from .shooting import ITERATIONS, ShootingFit, fit_by_shooting
from .unknowns import Unknowns

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
        if _same_minimum(found) and not explains_records(free, found[-1].point, ADEQUATE):
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


def _same_minimum(found: Sequence[Minimum]) -> bool:
    """Whether the last two minima are the same one, within the accuracy of a rough search."""
    return len(found) > 1 and abs(found[-1].cost - found[-2].cost) < SAME


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
