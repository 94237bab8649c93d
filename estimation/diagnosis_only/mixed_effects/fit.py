"""Fit of common numbers and of records' own effects: Gauss-Newton steps on normal equations without the own effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from ...likelihood.minimiser import Damping, damped_step, try_steps
from ...numerics.threads import in_threads
from .expansion import Block, Expansion, Tangent
from .problem import Problem, pooled, squares_of

FIRST_DAMPING = 1e-2
RULE = Damping(growth=5.0, least=5e-3, trials=6)
ENOUGH = 0.01
"""Fall of the criterion below which a fit ends."""
DIFFERENCE = 1e-3
"""Step of the derivatives, in prior standard deviations."""
LONGEST = 3.0
"""Longest single step, in prior standard deviations."""


@dataclass(frozen=True)
class Number:
    """One number of the model that may move: place in `Model.theta`, prior mean and standard deviation, smallest
    value."""

    name: str
    place: int
    mean: float
    sd: float
    low: float = -np.inf


def moved(theta: np.ndarray, numbers: Sequence[Number], step: np.ndarray) -> np.ndarray:
    """Theta (m,) with the numbers moved by a step (p,), not below their smallest values."""
    out, places = theta.copy(), [n.place for n in numbers]
    out[places] = np.maximum(out[places] + step, [n.low for n in numbers])
    return out


@dataclass(frozen=True, eq=False)
class Fitted:
    """A fit: theta with its free numbers, the records' own effects (R, k), error sizes (C,), criterion.

    normal, slope : normal equations (p, p), (p,) of the free numbers with all own effects eliminated, priors included;
    blocks : each record's share of them, and how its own effects follow (`Expansion.block`).
    """

    problem: Problem
    numbers: tuple[Number, ...]
    theta: np.ndarray
    own: np.ndarray
    sd: np.ndarray
    criterion: float
    normal: np.ndarray
    slope: np.ndarray
    blocks: tuple[Block, ...]

    @property
    def values(self) -> np.ndarray:
        """(p,) values of the free numbers."""
        return self.theta[[n.place for n in self.numbers]]


class _Here(NamedTuple):
    """Where a fit stands: theta, the records' own effects, their errors, sizes of these, criterion."""

    theta: np.ndarray
    own: np.ndarray
    errors: Sequence[np.ndarray]
    sd: np.ndarray
    cost: float


def fit(
    p: Problem,
    numbers: Sequence[Number],
    theta: np.ndarray,
    own: np.ndarray | None = None,
    most: int = 12,
    tangents: Sequence[Tangent] | None = None,
) -> Fitted:
    """Damped Gauss-Newton steps from theta as long as the criterion falls.

    Derivatives are taken at the start and at the end, and carried along the steps between these; of a response model,
    whose runs cost little, they are taken after every step: carried ones end where a term that is lacking is not found.

    theta (m,) : start; own (R, k) : start of the records' own effects, zero unless given.  tangents : of all records at
    the start, where they are known.
    """
    own = np.zeros((len(p.runs), p.own_sd.size)) if own is None else own
    here, damping, taken = _at(p, numbers, theta, own), FIRST_DAMPING, True
    tangents = tangents_of(p, numbers, theta, own, here.errors) if tangents is None else tangents
    for _ in range(most):
        normal, slope, blocks = equations(p, expanded(p, tangents), numbers, here.theta, here.sd)
        step, reached = partial(damped_step, normal, slope), partial(_moved, p, numbers, here, blocks)
        trial = try_steps(step, reached, here.cost, damping, 0.0, RULE)
        gained = here.cost - trial.point.cost if trial.better else 0.0
        if trial.better:
            tangents = _carried(p, numbers, tangents, here, trial.point)
            here, damping = trial.point, max(trial.damping / RULE.growth, 1e-6)
        if gained < ENOUGH and taken:
            break
        taken = gained < ENOUGH or trial.number > 0 or not p.model.is_3dof
        if taken:
            tangents = tangents_of(p, numbers, here.theta, here.own, here.errors)
    if not taken:
        tangents = tangents_of(p, numbers, here.theta, here.own, here.errors)
    normal, slope, blocks = equations(p, expanded(p, tangents), numbers, here.theta, here.sd)
    return Fitted(p, tuple(numbers), here.theta, here.own, here.sd, here.cost, normal, slope, tuple(blocks))


def _carried(
    p: Problem, numbers: Sequence[Number], tangents: Sequence[Tangent], here: _Here, there: _Here
) -> list[Tangent]:
    """The tangents of all records after a step."""
    places, scale = [n.place for n in numbers], np.array([*(n.sd for n in numbers), *p.own_sd])
    step = there.theta[places] - here.theta[places]
    return [t.carried(e, own, step, scale) for t, e, own in zip(tangents, there.errors, there.own, strict=True)]


def _moved(p: Problem, numbers: Sequence[Number], here: _Here, blocks: Sequence[Block], step: np.ndarray) -> _Here:
    """Where a step of the free numbers leads; the own effects follow it."""
    theta = moved(here.theta, numbers, step)
    own = np.array([b + x[:, -1] - x[:, :-1] @ step for b, (_, _, x) in zip(here.own, blocks, strict=True)])
    return _at(p, numbers, theta, own)


def _at(p: Problem, numbers: Sequence[Number], theta: np.ndarray, own: np.ndarray) -> _Here:
    """The point with its criterion and error sizes, floors included (eq. 2 of docs/mathematics/calibration.md)."""
    errors = _errors(p, theta, own)
    rms = pooled([squares_of(error) for error in errors])
    sd = np.where(p.known, p.floor, np.sqrt(rms**2 + p.floor**2))
    misfit = np.where(p.known, 0.5 * (rms / p.floor) ** 2, np.log(sd))
    prior = sum(((theta[n.place] - n.mean) / n.sd) ** 2 for n in numbers) + float(np.sum((own / p.own_sd) ** 2))
    return _Here(theta, own, errors, sd, float(p.weight.sum() * np.sum(misfit) + 0.5 * prior))


def _errors(p: Problem, theta: np.ndarray, own: np.ndarray) -> list[np.ndarray]:
    """The errors (N, C) of every record; own (R, k)."""
    return in_threads(p.threads, lambda i: p.residuals(theta, p.runs[i], own[i]), range(len(p.runs)))


def tangents_of(
    p: Problem,
    numbers: Sequence[Number],
    theta: np.ndarray,
    own: np.ndarray,
    errors: Sequence[np.ndarray] | None = None,
) -> list[Tangent]:
    """The tangent of every record; own (R, k).  errors : of the records there, where they are known."""
    errors = _errors(p, theta, own) if errors is None else errors
    return in_threads(p.threads, lambda i: _tangent_of(p, i, numbers, theta, own[i], errors[i]), range(len(p.runs)))


def _tangent_of(
    p: Problem, i: int, numbers: Sequence[Number], theta: np.ndarray, own: np.ndarray, error: np.ndarray
) -> Tangent:
    """The tangent of one record about common numbers theta (m,) and own effects (k,), by differences."""
    run = p.runs[i]
    slopes = np.empty((*error.shape, len(numbers) + own.size))
    for j, n in enumerate(numbers):
        h, moved = DIFFERENCE * n.sd, theta.copy()
        moved[n.place] += h
        slopes[:, :, j] = (p.residuals(moved, run, own) - error) / h
    for j, h in enumerate((10.0 * DIFFERENCE * p.own_sd).tolist()):
        step = h * (np.arange(own.size) == j)
        slopes[:, :, len(numbers) + j] = (p.residuals(theta, run, own + step) - error) / h
    return Tangent(error, slopes, own)


def expanded(p: Problem, tangents: Sequence[Tangent]) -> list[Expansion]:
    """The expansion of every record."""
    precision = p.own_sd**-2.0
    return in_threads(p.threads, lambda tangent: tangent.expansion(precision), tangents)


def expansions_of(p: Problem, numbers: Sequence[Number], theta: np.ndarray, own: np.ndarray) -> list[Expansion]:
    """The expansion of every record about common numbers theta (m,) and own effects (R, k)."""
    return expanded(p, tangents_of(p, numbers, theta, own))


def normal_equations(
    p: Problem, numbers: Sequence[Number], theta: np.ndarray, own: np.ndarray, sd: np.ndarray
) -> tuple[np.ndarray, np.ndarray, list[Block]]:
    """Normal equations (p, p), (p,) of the free numbers, priors included, with all own effects eliminated.

    Also for each record its share of both, and (k, p + 1) how its own effects follow: constant part last, minus slopes.
    """
    return equations(p, expansions_of(p, numbers, theta, own), numbers, theta, sd)


def equations(
    p: Problem, expansions: Sequence[Expansion], numbers: Sequence[Number], theta: np.ndarray, sd: np.ndarray
) -> tuple[np.ndarray, np.ndarray, list[Block]]:
    """As `normal_equations`, from expansions that were made at theta (eq. 4 of docs/mathematics/calibration.md)."""
    blocks = [e.block(weight, sd) for e, weight in zip(expansions, p.weight.tolist(), strict=True)]
    precision = np.array([n.sd**-2.0 for n in numbers])
    mean, values = np.array([n.mean for n in numbers]), theta[[n.place for n in numbers]] if numbers else np.zeros(0)
    normal = np.diag(precision) + sum(a for a, _, _ in blocks)
    return normal, sum(g for _, g, _ in blocks) - precision * (values - mean), blocks
