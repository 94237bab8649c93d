"""Damped Gauss-Newton steps on the concentrated likelihood of numbers and own effects of units.

    cost = sum_c n_c / 2 log(sigma_c^2) + 1/2 sum_j (x_j / sd_j)^2 + 1/2 sum_km (z_km / S_m)^2
    sigma_c^2 = sum_k w_kc s_kc / n_c + floor_c^2,      n_c = sum_k w_kc N_kc

The sizes sigma_c of the channels follow the fit, so that a prior never outweighs errors that are gone; the floor is an
error that counts as none, and the size of a channel that is known.  The gradient of the cost is that of least squares
weighted by these sizes, so that each step solves the normal equations at them.
Source: Seber and Wild 1989, sections 2.2 and 5.1; damping as Marquardt 1963.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from .number import Number
from .quadratic import Prior, Quadratic, bounded_solve, joint, left_out_steps, own_step
from .score import jackknife

STEPS, TRIALS = 20, 6
FIRST_GROWTH, GROWTH = 1e-2, 5.0
WEIGHINGS, ALIKE = 2, 1.3
"""Most times that samples are weighed anew after a fit, and ratio of weights up to which they count as the same."""
SLACK, NEGLIGIBLE = 1.2, 0.1
"""Factor on the sensors' noise, as it is estimated, up to which errors are noise; least square of other errors, in
those that count as none."""
ENOUGH, SIZINGS = 0.02, 8
"""Fall of the cost for each number that ends the steps, or error of what a linearisation tells of it; and most times
that its least cost is looked for with other sizes of the channels."""


class UnitErrors(Protocol):
    """Units with errors: K units, C channels, m own effects each."""

    @property
    def counts(self) -> np.ndarray:
        """Samples (K, C) that are measured."""
        ...

    @property
    def weight(self) -> np.ndarray:
        """Independent values (K,) that a sample counts as."""
        ...

    @property
    def noise(self) -> np.ndarray:
        """Mean squared noise (C,) of the sensors, which is independent from sample to sample."""
        ...

    @property
    def floor(self) -> np.ndarray:
        """Error (C,) that counts as none."""
        ...

    @property
    def known(self) -> np.ndarray:
        """Channels (C,) whose errors have the size of the floor: no fit may give them up for others."""
        ...

    @property
    def own_sd(self) -> np.ndarray:
        """Prior standard deviations (m,) of the own effects."""
        ...

    def squares(self, values: Sequence[dict[str, float]], own: np.ndarray) -> np.ndarray:
        """Sums of squared errors (K, C) of each unit at its values of the numbers by name, and own effects (K, m)."""
        ...

    def quadratic(self, values: dict[str, float], own: np.ndarray, numbers: Sequence[Number]) -> Quadratic:
        """Linearisation about a point in some numbers."""
        ...


class Point(NamedTuple):
    """Values of the numbers by name, own effects (K, m), squares (K, C), sizes (C,) of the channels, the cost, and the
    independent values (K, C) that a sample counts as."""

    values: dict[str, float]
    own: np.ndarray
    squares: np.ndarray
    size: np.ndarray
    cost: float
    weight: np.ndarray


@dataclass(frozen=True)
class Fitted:
    """Where the cost is least.

    left_out : sums of squared errors (K, C) of each unit, run with the numbers of the fit without it, `without`.
    covariance (p, p) of the numbers;  sd (p,) : their standard deviations, not less than the jackknife's over units.
    """

    numbers: tuple[Number, ...]
    point: Point
    left_out: np.ndarray
    without: tuple[dict[str, float], ...]
    covariance: np.ndarray
    sd: np.ndarray

    def value(self, name: str) -> float:
        """Value of a number, 0 where it is none of the fit."""
        return self.point.values.get(name, 0.0)


def prior_of(numbers: Sequence[Number], values: dict[str, float]) -> Prior:
    """Priors of numbers at their values by name."""
    rows = [(values.get(n.name, 0.0), n.sd, n.low, n.high) for n in numbers]
    return Prior(*np.array(rows, float).reshape(-1, 4).T)


def point_at(
    problem: UnitErrors,
    numbers: Sequence[Number],
    values: dict[str, float],
    own: np.ndarray,
    weight: np.ndarray | None = None,
) -> Point:
    """The cost at values of the numbers and own effects (K, m), eq. 4 of docs/mathematics/pieces.md.

    weight (K, C) : independent values that a sample counts as; None: those of errors that are correlated.
    """
    if weight is None:
        weight = np.broadcast_to(problem.weight[:, None], problem.counts.shape)
    return _with_squares(problem, numbers, values, own, problem.squares([values] * len(own), own), weight)


def _with_squares(
    problem: UnitErrors,
    numbers: Sequence[Number],
    values: dict[str, float],
    own: np.ndarray,
    squares: np.ndarray,
    weight: np.ndarray,
) -> Point:
    """The point with squares (K, C) of its errors."""
    total = np.maximum(np.sum(weight * problem.counts, axis=0), 1e-9)
    mean = np.sum(weight * squares, axis=0) / total
    size = np.where(problem.known, problem.floor, np.sqrt(mean + problem.floor**2))
    prior = prior_of(numbers, values)
    misfit = total * np.where(problem.known, 0.5 * mean / problem.floor**2, np.log(size))
    cost = float(np.sum(misfit[problem.counts.sum(axis=0) > 0]))
    cost += 0.5 * float(np.sum((prior.values / prior.sd) ** 2) + np.sum((own / problem.own_sd) ** 2))
    return Point(values, own, squares, size, cost, weight)


def weight_at(problem: UnitErrors, here: Point) -> np.ndarray:
    """Independent values (K, C) that a sample counts as where the errors are partly the sensors' noise.

    Eq. 3 of docs/mathematics/pieces.md.
    """
    noise, correlated = problem.noise, problem.weight[:, None]
    mean = here.squares.sum(axis=0) / np.maximum(problem.counts.sum(axis=0), 1.0)
    other = np.maximum(mean - SLACK * noise, NEGLIGIBLE * problem.floor**2)
    return correlated * (other + noise) / (other + correlated * noise)


def minimise(
    problem: UnitErrors,
    numbers: Sequence[Number],
    values: dict[str, float],
    own: np.ndarray,
    steps: int = STEPS,
    weight: np.ndarray | None = None,
    weighings: int = WEIGHINGS,
    coarse: float = 0.0,
) -> Fitted:
    """The fit of some numbers from a point; other numbers keep their values there.

    weight (K, C) : of the samples at first; None: that of errors that are correlated.  weighings : most times that they
    are weighed anew by the errors that the fit leaves.  coarse : fall of the cost for each independent value that ends
    the steps, where that is more than ENOUGH for each number.
    """
    here = point_at(problem, numbers, dict(values), own, weight)
    enough = max(ENOUGH * max(len(numbers), 1), coarse * float(np.sum(here.weight * problem.counts)))
    end = _descended(problem, numbers, here, steps, enough)
    for _ in range(weighings):
        here = end.point
        weight = weight_at(problem, here)
        if are_alike(weight, here.weight):
            break
        here = _with_squares(problem, numbers, here.values, here.own, here.squares, weight)
        end = _descended(problem, numbers, here, steps, enough, end.about)
    return _concluded(problem, tuple(numbers), end)


def are_alike(weight: np.ndarray, other: np.ndarray) -> bool:
    """Whether samples of two weights (K, C) count as the same."""
    return bool(np.max(np.abs(np.log(weight / other))) < np.log(ALIKE))


class _About(NamedTuple):
    """A linearisation, and values and own effects (K, m) that it is about."""

    values: dict[str, float]
    own: np.ndarray
    quadratic: Quadratic


class _End(NamedTuple):
    """Where steps no longer gain, and the last linearisation."""

    point: Point
    about: _About


def _descended(
    problem: UnitErrors,
    numbers: Sequence[Number],
    here: Point,
    steps: int,
    enough: float,
    about: _About | None = None,
) -> _End:
    """The end of at most so many steps; about : a linearisation that may still hold at the point.

    enough : fall of the cost that ends the steps, or error of the cost of a linearisation's least point.
    """
    damping = 0.0
    for _ in range(steps):
        is_new = about is None
        about = about or _About(here.values, here.own, problem.quadratic(here.values, here.own, numbers))
        following = _stepped(problem, numbers, here, about, damping)
        if following is None and is_new:
            return _End(here, about)
        if following is not None:
            there, damping, error = following
            if min(error, here.cost - there.cost) < enough:
                return _End(there, about)
            here = there
        about = None
    return _End(here, _About(here.values, here.own, problem.quadratic(here.values, here.own, numbers)))


def _stepped(
    problem: UnitErrors, numbers: Sequence[Number], here: Point, about: _About, damping: float
) -> tuple[Point, float, float] | None:
    """The next point of lower cost, the damping after it, 0 for a free step, and by how much the linearisation errs in
    the cost of its least point, infinite where it is another one; None where there is none."""
    if not damping:
        least = _least(problem, numbers, here, about)
        there = point_at(problem, numbers, least.values, least.own, here.weight)
        if there.cost < here.cost:
            return there, 0.0, _difference(here, least, there)
    prior, normal = prior_of(numbers, about.values), about.quadratic.normal(here.size, here.weight)
    matrix, slope = joint(normal, prior)
    damping = damping or FIRST_GROWTH
    for _ in range(TRIALS):
        step = _bounded(prior, matrix + damping * np.diag(np.diag(matrix)), slope)
        own = about.own + own_step(normal, np.tile(step, (len(here.own), 1))) / (1.0 + damping)
        there = point_at(problem, numbers, _moved(numbers, about, step), own, here.weight)
        if there.cost < here.cost:
            return there, damping / GROWTH if damping > FIRST_GROWTH else 0.0, np.inf
        damping *= GROWTH
    return None


def _least(problem: UnitErrors, numbers: Sequence[Number], here: Point, about: _About) -> Point:
    """The point of least cost by a linearisation: the sizes of the channels follow its errors."""
    prior, least = prior_of(numbers, about.values), here
    for _ in range(SIZINGS):
        size, normal = least.size, about.quadratic.normal(least.size, here.weight)
        step = _bounded(prior, *joint(normal, prior))
        steps = np.tile(step, (len(here.own), 1))
        own = own_step(normal, steps)
        squares = about.quadratic.squares(steps, own, range(len(numbers)))
        least = _with_squares(problem, numbers, _moved(numbers, about, step), about.own + own, squares, here.weight)
        if are_alike(least.size, size):
            break
    return least


def _difference(here: Point, linear: Point, there: Point) -> float:
    """Cost by which the squares of the units at a point differ from those of a linearisation."""
    return 0.5 * float(np.sum(here.weight * np.abs(linear.squares - there.squares) / there.size**2))


def _bounded(prior: Prior, matrix: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """The step (p,) of normal equations within the bounds of the numbers."""
    return bounded_solve(matrix, slope, prior.low - prior.values, prior.high - prior.values)


def _moved(numbers: Sequence[Number], about: _About, step: np.ndarray) -> dict[str, float]:
    """Values by name after a step (p,) of the numbers."""
    return about.values | {
        n.name: about.values.get(n.name, 0.0) + x for n, x in zip(numbers, step.tolist(), strict=True)
    }


def _concluded(problem: UnitErrors, numbers: tuple[Number, ...], end: _End) -> Fitted:
    """The end with its left-out units, each run once with the numbers and own effects that follow without it.

    The linearisation tells by how much they differ from those of all units, eq. 7 of docs/mathematics/pieces.md.
    """
    here, about = end
    prior, normal = prior_of(numbers, about.values), about.quadratic.normal(here.size, here.weight)
    if not numbers:
        return Fitted((), here, here.squares, (here.values,) * len(here.own), np.zeros((0, 0)), np.zeros(0))
    steps, (matrix, slope) = left_out_steps(normal, prior), joint(normal, prior)
    whole = np.tile(_bounded(prior, matrix, slope), (len(steps), 1))
    final = np.array([here.values.get(n.name, 0.0) for n in numbers])
    moved = np.clip(final + steps - whole, prior.low, prior.high).tolist()
    each = [here.values | dict(zip((n.name for n in numbers), row, strict=True)) for row in moved]
    left_out = problem.squares(each, here.own + own_step(normal, steps) - own_step(normal, whole))
    covariance = np.linalg.inv(matrix)
    sd = np.maximum(np.sqrt(np.diag(covariance)), np.nan_to_num(jackknife(steps), posinf=0.0))
    return Fitted(numbers, here, left_out, tuple(each), covariance, sd)
