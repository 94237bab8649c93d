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
ENOUGH = 0.02
"""Fall of the cost for each number that ends the steps."""


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
    squares = problem.squares([values] * len(own), own)
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
) -> Fitted:
    """The fit of some numbers from a point; other numbers keep their values there.

    weight (K, C) : of the samples at first; None: that of errors that are correlated.  weighings : most times that they
    are weighed anew by the errors that the fit leaves.
    """
    end = _descended(problem, numbers, point_at(problem, numbers, dict(values), own, weight), steps)
    for _ in range(weighings):
        weight = weight_at(problem, end.point)
        if are_alike(weight, end.point.weight):
            break
        end = _descended(problem, numbers, point_at(problem, numbers, end.point.values, end.point.own, weight), steps)
    return _concluded(problem, tuple(numbers), end)


def are_alike(weight: np.ndarray, other: np.ndarray) -> bool:
    """Whether samples of two weights (K, C) count as the same."""
    return bool(np.max(np.abs(np.log(weight / other))) < np.log(ALIKE))


class _End(NamedTuple):
    """Where steps no longer gain, and the last linearisation with its point: the same one, or the one before."""

    point: Point
    quadratic: Quadratic
    before: Point


def _descended(problem: UnitErrors, numbers: Sequence[Number], here: Point, steps: int) -> _End:
    """The end of at most so many steps."""
    damping = 0.0
    for _ in range(steps):
        quadratic = problem.quadratic(here.values, here.own, numbers)
        following = _stepped(problem, numbers, here, quadratic, damping)
        if following is None:
            return _End(here, quadratic, here)
        there, damping = following
        if here.cost - there.cost < ENOUGH * max(len(numbers), 1):
            return _End(there, quadratic, here)
        here = there
    return _End(here, problem.quadratic(here.values, here.own, numbers), here)


def _stepped(
    problem: UnitErrors, numbers: Sequence[Number], here: Point, quadratic: Quadratic, damping: float
) -> tuple[Point, float] | None:
    """The next point of lower cost, and the damping after it; None where there is none."""
    prior, normal = prior_of(numbers, here.values), quadratic.normal(here.size, here.weight)
    matrix, slope = joint(normal, prior)
    low, high = prior.low - prior.values, prior.high - prior.values
    for _ in range(TRIALS):
        step = bounded_solve(matrix + damping * np.diag(np.diag(matrix)), slope, low, high)
        moved = (prior.values + step).tolist()
        values = here.values | {n.name: x for n, x in zip(numbers, moved, strict=True)}
        own = here.own + own_step(normal, np.tile(step, (len(here.own), 1))) / (1.0 + damping)
        there = point_at(problem, numbers, values, own, here.weight)
        if there.cost < here.cost:
            return there, damping / GROWTH
        damping = max(GROWTH * damping, FIRST_GROWTH)
    return None


def _concluded(problem: UnitErrors, numbers: tuple[Number, ...], end: _End) -> Fitted:
    """The end with its left-out units, each run once with the numbers and own effects that follow without it."""
    here = end.before
    prior, normal = prior_of(numbers, here.values), end.quadratic.normal(here.size, here.weight)
    if not numbers:
        return Fitted((), end.point, end.point.squares, (here.values,) * len(here.own), np.zeros((0, 0)), np.zeros(0))
    steps = left_out_steps(normal, prior)
    names = [n.name for n in numbers]
    each = [here.values | dict(zip(names, (prior.values + step).tolist(), strict=True)) for step in steps]
    left_out = problem.squares(each, here.own + own_step(normal, steps))
    covariance = np.linalg.inv(joint(normal, prior)[0])
    sd = np.maximum(np.sqrt(np.diag(covariance)), np.nan_to_num(jackknife(steps), posinf=0.0))
    return Fitted(numbers, end.point, left_out, tuple(each), covariance, sd)
