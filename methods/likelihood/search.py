"""The search for the deepest of the cost's many minima, from starts that are given."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..base import FitFailed
from ..series import Series
from .horizons import grown, short
from .loss import Loss
from .minimiser import ROUGH, Minimum, levenberg_marquardt
from .problem import Problem, adequate, held, released, sensor_sd_of
from .shooting import ITERATIONS, Shot, shoot
from .unknowns import Unknowns

if TYPE_CHECKING:
    from ...models.model import Model

GOOD, ADEQUATE = 1.5, 3.0
"""Residual over sensor noise at which the search ends, and below which a model counts as explaining the records."""
STARTS = 2
"""Starts that are followed up."""
STRETCHES = 8
"""Of multiple shooting where it stands in for growing horizons."""


class Outcome(NamedTuple):
    """A fitted problem."""

    problem: Problem
    minimum: Minimum
    adequate: bool
    n_attempts: int
    n_iterations: int


def fit_output_error(
    series: Sequence[Series],
    model: Model,
    starts: Sequence[np.ndarray],
    most: int = 60,
    unknowns: Unknowns | None = None,
    loss: Loss | None = None,
    shooting: int = 1,
) -> Outcome:
    """Output-error fit from several starts; the first that explains the records well ends the search.

    Parameters
    ----------
    series : the records, with all the channels they have.
    starts : coefficients (p,), or where there are `unknowns` those (k,).
    most : iterations of one minimisation.
    unknowns : the parameters that move, with bounds and prior; None: all coefficients.
    loss : None: least squares.
    shooting : stretches into which records are cut by multiple shooting; 1: runs over whole records.

    Raises
    ------
    FitFailed : if the model diverges from every start.
    """
    free = released(series, model, unknowns, loss)
    weighed = replace(free, sensor=sensor_sd_of(free))
    ranked, left = _ranked(weighed, starts), None
    if shooting > 1:
        outcome, left, ranked = _by_shooting(free, weighed, ranked, most, shooting)
        if outcome is not None:
            return outcome
    tried: list[np.ndarray] = []
    found: list[Minimum] = []
    for growing, start in [(growing, start) for growing in (False, True) for start in ranked]:
        z, count = _approached(weighed, start) if growing else (weighed.start(start), 0)
        tried.append(z[: free.own])
        found.append(_released_fit(free, weighed, z, most, count))
        if found[-1].converged and adequate(free, found[-1].point, GOOD):
            return _finished(free, found[-1], True, found, most)
        if _agree(found) and not adequate(free, found[-1].point, ADEQUATE):
            break
    best = min(found, key=lambda minimum: minimum.cost)
    if adequate(free, best.point, ADEQUATE):
        return _finished(free, best, True, found, most)
    fixed = held(free)
    bound = [levenberg_marquardt(fixed, fixed.start(own), (most + 1) // 2, ROUGH) for own in tried]
    best = min(bound, key=lambda minimum: minimum.cost)
    if left is not None and _misfit(fixed, left.minimum) < _misfit(fixed, best):
        return _finished(replace(left.chain, sensor=None), left.minimum, False, found + bound, most)
    if not np.isfinite(best.cost):
        raise FitFailed("the simulation diverges from every start")
    return _finished(fixed, best, False, found + bound, most)


def _by_shooting(
    free: Problem, weighed: Problem, starts: Sequence[np.ndarray], most: int, stretches: int
) -> tuple[Outcome | None, Shot | None, list[np.ndarray]]:
    """The first fit by multiple shooting that explains the records; the best chain that no run follows; the ends.

    Runs over whole records close the trajectory; where they leave it (an unstable ship, a long record), the chain of
    stretches itself is the fit.  It need not explain the records: a rudder sensor's noise alone moves the heading of
    an unstable ship by more than a compass errs.
    """
    ends: list[np.ndarray] = []
    found: list[Minimum] = []
    left: list[Shot] = []
    for start in starts:
        shot = shoot(weighed, start, stretches, most)
        ends.append(shot.minimum.z[: weighed.own])
        found.append(_released_fit(free, weighed, shot.chain.first(shot.minimum.z), most, shot.n_iterations))
        if adequate(free, found[-1].point, ADEQUATE):
            return _finished(free, found[-1], True, found, most), None, ends
        if adequate(shot.chain, shot.minimum.point, ADEQUATE):
            chain = replace(shot.chain, sensor=None)
            return _finished(chain, shot.minimum, True, found, most), None, ends
        if _misfit(weighed, found[-1]) > ADEQUATE**2 * _misfit(weighed, shot.minimum):
            left.append(shot)
    return None, min(left, key=lambda shot: shot.minimum.cost, default=None), ends


def _misfit(problem: Problem, minimum: Minimum) -> float:
    """Sum of the squared residuals in the problem's channels, in units of their sensors' noise."""
    used = problem.counts > 0
    return float(np.sum(minimum.point.squares[used] / sensor_sd_of(problem)[used] ** 2))


def _approached(weighed: Problem, start: np.ndarray) -> tuple[np.ndarray, int]:
    """Unknowns after fits over growing horizons, by multiple shooting where not every state is measured."""
    if short(weighed) is not None:
        own, count = grown(weighed, start)
        return weighed.start(own), count
    shot = shoot(weighed, start, STRETCHES, ITERATIONS)
    return shot.chain.first(shot.minimum.z), shot.n_iterations


def _agree(found: Sequence[Minimum], nats: float = 10.0) -> bool:
    """Whether the last two minima are the same one, to what a rough search can tell."""
    return len(found) > 1 and abs(found[-1].cost - found[-2].cost) < nats


def _released_fit(free: Problem, weighed: Problem, start: np.ndarray, most: int, count: int) -> Minimum:
    """A first minimum of the problem with free initial states from unknowns `start`; `count` iterations went before.

    Channels are weighed by their sensors' noise first: weights that follow the residuals would favour a channel that
    fits already over one that does not yet.
    """
    near = levenberg_marquardt(weighed, start, most, ROUGH)
    count += near.n_iterations
    if not adequate(weighed, near.point, 2.0 * ADEQUATE):
        return near._replace(point=free.at(near.z), n_iterations=count)
    found = levenberg_marquardt(free, near.z, most, ROUGH)
    return found._replace(n_iterations=count + found.n_iterations)


def _finished(problem: Problem, best: Minimum, explained: bool, found: Sequence[Minimum], most: int) -> Outcome:
    """The outcome, with the last digits of the best of the minima found."""
    last = levenberg_marquardt(problem, best.z, most)
    return Outcome(problem, last, explained, len(found), sum(f.n_iterations for f in [*found, last]))


def _ranked(problem: Problem, starts: Sequence[np.ndarray]) -> list[np.ndarray]:
    """The STARTS best of the starts by the error of short runs from measured states; of whole runs, if not all are."""
    cut = short(problem) or problem
    costs = [cut.at(cut.start(start)).cost for start in starts]
    return [starts[i] for i in np.argsort(costs, kind="stable")[:STARTS]]
