"""Levenberg-Marquardt steps on triangular factors, and the minimisation of a `Problem` by them, within bounds if any.

Where many steps have not been enough, and one fails or gains much less than predicted, the following ones are bent by
geodesic acceleration: the cost of a model with poorly identified parameters has narrow curved valleys, and straight
steps along them are short.
Sources: Levenberg 1944; Marquardt 1963, J. Soc. Indust. Appl. Math. 11, 431; Transtrum and Sethna 2012,
arXiv:1201.5885.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Generic, NamedTuple, Protocol, TypeVar

import numpy as np

from ..numerics import factors
from .linear_problem import LinearArrow, LinearProblem
from .problem import Point, Problem

ROUGH, FINE = 1.0, 1e-6
"""Predicted gain in log likelihood at which the search among starts stops, and at which the last minimum does."""
SHARE = 1e-3
"""Predicted gain, relative to the cost, at which a search stops while channels are weighted by their sensors."""
FIRST_DAMPING = 1e-3
REDUCED, KEPT = 0.01, 1.0
"""Factors on the damping after a step that succeeds at the first trial, and after one that needs several."""
POOR = 0.3
"""Factor after a step that succeeds at the first trial but gains less than GOOD times the predicted gain."""
GOOD = 0.7
BENT_GROWTH, BENT_REDUCED, BENT_POOR = 3.0, 0.1, 0.5
"""Growth of the damping, REDUCED and POOR of accelerated steps."""
STRAIGHT = 15
"""Iterations without acceleration: longer steps far from the records' own minimum lead to other minima."""
PROBE = 0.1
"""Share of a step at which the second derivative of the residuals along it is taken."""
MOST_BENT = 0.75
"""Largest acceleration, relative to the step, in columns of unit length."""


class Damping(NamedTuple):
    """Growth of the damping from trial to trial, its smallest value after growth, and the most trials of one step."""

    growth: float = 5.0
    least: float = 1e-10
    trials: int = 1000


Stepper = Callable[[float], tuple[np.ndarray, float]]
"""A linearised problem: damping -> the step (width,) and the gain that it predicts."""


class HasCost(Protocol):
    """Anything with a cost that is to be made small."""

    @property
    def cost(self) -> float: ...


T = TypeVar("T", bound=HasCost)


class LastStep(NamedTuple, Generic[T]):
    """The last step tried: the point reached, whether it is better, the predicted gain, the damping, and its number."""

    point: T
    better: bool
    predicted: float
    damping: float
    number: int


def try_steps(
    step: Stepper, evaluate: Callable[[np.ndarray], T], cost: float, damping: float, enough: float, rule: Damping
) -> LastStep[T]:
    """Steps of growing damping until one leads below `cost`, or predicts a gain below `enough`.

    Parameters
    ----------
    step : the linearised problem.
    evaluate : step (width,) -> the point that it leads to.
    """
    for number in range(rule.trials):
        move, predicted = step(damping)
        point = evaluate(move)
        trial = LastStep(point, point.cost < cost, predicted, damping, number)
        if trial.better or predicted < enough:
            break
        damping = max(rule.growth * damping, rule.least)
    return trial


class Minimum(NamedTuple):
    """Where `levenberg_marquardt` stopped."""

    point: Point
    converged: bool
    n_iterations: int

    @property
    def z(self) -> np.ndarray:
        """Unknowns (width,)."""
        return self.point.z

    @property
    def cost(self) -> float:
        """Negative log likelihood."""
        return self.point.cost


def levenberg_marquardt(
    problem: Problem,
    z: np.ndarray,
    max_iterations: int,
    gain: float = FINE,
    straight: int = STRAIGHT,
    first_damping: float = FIRST_DAMPING,
) -> Minimum:
    """Minimise the problem's cost from z (width,), which lies within its bounds; the cost never increases.

    The first `straight` iterations are not accelerated.

    The search has converged when the damped linear problem predicts less than `gain` in log likelihood, or when no
    step lowers the cost although only a gain within rounding is predicted.
    """
    here, damping, limits, curved = problem.at(z), first_damping, problem.limits(), False
    for iteration in range(max_iterations):
        if not np.isfinite(here.cost):
            return Minimum(here, False, iteration)
        enough = max(gain, SHARE * here.cost) if problem.sensor is not None else gain
        step = _stepper(problem, here, limits, curved)
        if step is None:
            return Minimum(here, False, iteration)
        rule = Damping(BENT_GROWTH) if curved else Damping()
        trial = try_steps(step, partial(_moved, problem, here), here.cost, damping, enough, rule)
        if not trial.better:
            return Minimum(here, True, iteration + 1)
        good = here.cost - trial.point.cost > GOOD * trial.predicted
        curved = curved or (iteration >= straight and (trial.number > 0 or not good))
        damping = trial.damping * _factor(trial, good, curved)
        here = trial.point
        if trial.predicted < enough:
            return Minimum(here, True, iteration + 1)
    return Minimum(here, False, max_iterations)


def _factor(trial: LastStep[Point], good: bool, curved: bool) -> float:
    """The factor on the damping after a step that succeeded."""
    reduced, poor = (BENT_REDUCED, BENT_POOR) if curved else (REDUCED, POOR)
    reduction = reduced if trial.number == 0 else KEPT
    return reduction if good else max(reduction, poor)


def _stepper(
    problem: Problem, here: Point, limits: tuple[np.ndarray, np.ndarray] | None, curved: bool
) -> Stepper | None:
    """Steps from `here`, within the limits of the unknowns if there are any; None where derivatives are not finite."""
    if problem.arrow_shaped:
        arrow = problem.arrow(here)
        linear = LinearArrow(arrow) if arrow.finite else None
    else:
        rows = problem.rows(here) if curved and limits is None else None
        factor = problem.factor(here) if rows is None else factors.fold(factors.empty(problem.width), rows)
        linear = LinearProblem(factor) if np.isfinite(factor).all() else None
        if linear is not None and rows is not None:
            return partial(_accelerated, problem, here, rows, linear)
    if linear is None or limits is None:
        return None if linear is None else linear.step
    low, high = limits[0] - here.z, limits[1] - here.z
    return lambda damping: linear.step_within(damping, low, high)


def _accelerated(
    problem: Problem, here: Point, rows: np.ndarray, linear: LinearProblem, damping: float
) -> tuple[np.ndarray, float]:
    """The damped step, bent by half its geodesic acceleration where that is no longer than MOST_BENT of the step.

    The second derivative of the residuals along the step comes from one more run (Transtrum and Sethna 2012, eq. 15).
    """
    step, predicted = linear.step(damping)
    slopes, residuals = rows[:, :-1], rows[:, -1]
    with np.errstate(all="ignore"):
        change = (residuals - problem.residuals(here.z + PROBE * step, here)) / PROBE
        bent = -linear.solved(slopes.T @ (2.0 / PROBE * (change - slopes @ step)), damping)
        small = np.linalg.norm(bent * linear.length) <= MOST_BENT * np.linalg.norm(step * linear.length)
    return (step + 0.5 * bent if small else step), predicted


def _moved(problem: Problem, here: Point, step: np.ndarray) -> Point:
    return problem.at(here.z + step)
