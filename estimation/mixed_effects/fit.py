"""Fit of common numbers and of records' own effects: Gauss-Newton steps on normal equations without the own effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from ...models.linear_algebra import finite
from ..likelihood.minimiser import Damping, try_steps
from ..threads import in_threads
from .problem import Problem, Run, pooled, squares

DIFFERENCE = 1e-3
"""Step of the derivatives, in prior standard deviations."""
FIRST_DAMPING = 1e-2
RULE = Damping(growth=5.0, least=5e-3, trials=6)
ENOUGH = 0.01
"""Fall of the criterion below which a fit ends."""
Block = tuple[np.ndarray, np.ndarray, np.ndarray]
"""One record's share of the normal equations (p, p), (p,), and how its own effects follow (k, p + 1)."""
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
    parts : each record's share of them.
    """

    problem: Problem
    numbers: tuple[Number, ...]
    theta: np.ndarray
    own: np.ndarray
    sd: np.ndarray
    criterion: float
    normal: np.ndarray
    slope: np.ndarray
    parts: tuple[tuple[np.ndarray, np.ndarray], ...]

    @property
    def values(self) -> np.ndarray:
        """(p,) values of the free numbers."""
        return self.theta[[n.place for n in self.numbers]]


class _Here(NamedTuple):
    """Where a fit stands: theta, the records' own effects, error sizes, criterion."""

    theta: np.ndarray
    own: np.ndarray
    sd: np.ndarray
    cost: float


def fit(
    p: Problem, numbers: Sequence[Number], theta: np.ndarray, own: np.ndarray | None = None, most: int = 12
) -> Fitted:
    """Damped Gauss-Newton steps from theta as long as the criterion falls.

    theta (m,) : start; own (R, k) : start of the records' own effects, zero unless given.
    """
    own = np.zeros((len(p.runs), p.own_sd.size)) if own is None else own
    here, damping = _at(p, numbers, theta, own), FIRST_DAMPING
    for _ in range(most):
        normal, slope, blocks = normal_equations(p, numbers, here.theta, here.own, here.sd)
        trial = try_steps(
            partial(_damped, normal, slope), partial(_moved, p, numbers, here, blocks), here.cost, damping, 0.0, RULE
        )
        if not trial.better:
            break
        gained, here, damping = here.cost - trial.point.cost, trial.point, max(trial.damping / RULE.growth, 1e-6)
        if gained < ENOUGH:
            break
    normal, slope, blocks = normal_equations(p, numbers, here.theta, here.own, here.sd)
    parts = tuple((a, g) for a, g, _ in blocks)
    return Fitted(p, tuple(numbers), here.theta, here.own, here.sd, here.cost, normal, slope, parts)


def _damped(normal: np.ndarray, slope: np.ndarray, damping: float) -> tuple[np.ndarray, float]:
    step = np.linalg.solve(normal + damping * np.diag(np.diag(normal)), slope)
    return step, 0.5 * float(slope @ step)


def _moved(p: Problem, numbers: Sequence[Number], here: _Here, blocks: Sequence[Block], step: np.ndarray) -> _Here:
    """Where a step of the free numbers leads; the own effects follow it."""
    theta = moved(here.theta, numbers, step)
    own = np.array([b + x[:, -1] - x[:, :-1] @ step for b, (_, _, x) in zip(here.own, blocks, strict=True)])
    return _at(p, numbers, theta, own)


def _at(p: Problem, numbers: Sequence[Number], theta: np.ndarray, own: np.ndarray) -> _Here:
    cost, sd = _criterion(p, numbers, theta, own)
    return _Here(theta, own, sd, cost)


def stepped(
    found: Fitted,
    numbers: Sequence[Number],
    pick: np.ndarray,
    equations: tuple[np.ndarray, np.ndarray, Sequence[Block]],
) -> Fitted:
    """One Gauss-Newton step of some numbers from a fit, by `equations` of more numbers, of which `pick` are these."""
    p, (normal, slope, blocks) = found.problem, equations
    block = normal[np.ix_(pick, pick)]
    step = np.linalg.lstsq(finite(block), slope[pick], rcond=None)[0]
    step *= min(1.0, LONGEST / max(float(np.max(np.abs(step) / [n.sd for n in numbers], initial=0.0)), 1e-9))
    theta = moved(found.theta, numbers, step)
    own = np.array([b + x[:, -1] - x[:, pick] @ step for b, (_, _, x) in zip(found.own, blocks, strict=True)])
    criterion, sd = _criterion(p, numbers, theta, own)
    parts = tuple((a[np.ix_(pick, pick)], g[pick] - a[np.ix_(pick, pick)] @ step) for a, g, _ in blocks)
    return Fitted(p, tuple(numbers), theta, own, sd, criterion, block, slope[pick] - block @ step, parts)


def _criterion(p: Problem, numbers: Sequence[Number], theta: np.ndarray, own: np.ndarray) -> tuple[float, np.ndarray]:
    """The criterion and the error sizes (C,), floors included."""
    errors = pooled(in_threads(p.threads, lambda i: squares(p, theta, p.runs[i], own[i]), range(len(p.runs))))
    sd = np.where(p.known, p.floor, np.sqrt(errors**2 + p.floor**2))
    misfit = np.where(p.known, 0.5 * (errors / p.floor) ** 2, np.log(sd))
    prior = sum(((theta[n.place] - n.mean) / n.sd) ** 2 for n in numbers) + float(np.sum((own / p.own_sd) ** 2))
    return float(p.weight.sum() * np.sum(misfit) + 0.5 * prior), sd


def normal_equations(
    p: Problem, numbers: Sequence[Number], theta: np.ndarray, own: np.ndarray, sd: np.ndarray
) -> tuple[np.ndarray, np.ndarray, list[Block]]:
    """Normal equations (p, p), (p,) of the free numbers, priors included, with all own effects eliminated.

    Also for each record its share of both, and (k, p + 1) how its own effects follow: constant part last, minus slopes.
    """

    def block(i: int) -> Block:
        return block_of(p, i, numbers, theta, own[i], sd)

    blocks = in_threads(p.threads, block, range(len(p.runs)))
    precision = np.array([n.sd**-2.0 for n in numbers])
    mean, values = np.array([n.mean for n in numbers]), theta[[n.place for n in numbers]] if numbers else np.zeros(0)
    normal = np.diag(precision) + sum(a for a, _, _ in blocks)
    return normal, sum(g for _, g, _ in blocks) - precision * (values - mean), blocks


def block_of(
    p: Problem, i: int, numbers: Sequence[Number], theta: np.ndarray, own: np.ndarray, sd: np.ndarray
) -> Block:
    """One record's normal equations with its own effects eliminated: (p, p), (p,), (k, p + 1)."""
    run, q = p.runs[i], len(numbers)
    error, slopes = _jacobian(p, run, numbers, theta, own)
    counted = np.maximum(np.isfinite(error).sum(axis=0), 1)
    weight = np.sqrt(p.weight[i] / counted) / sd
    rows = np.where(np.isfinite(slopes), slopes, 0.0) * weight[None, :, None]
    target = np.where(np.isfinite(error), error, 0.0) * weight
    rows, target = rows.reshape(-1, rows.shape[2]), target.ravel()
    matrix, slope = rows.T @ rows, -(rows.T @ target)
    inner = matrix[q:, q:] + np.diag(p.own_sd**-2.0)
    pull = slope[q:] - own / p.own_sd**2
    follow = np.linalg.solve(inner, np.column_stack([matrix[q:, :q], pull]))
    return matrix[:q, :q] - matrix[:q, q:] @ follow[:, :q], slope[:q] - matrix[:q, q:] @ follow[:, q], follow


def _jacobian(
    p: Problem, run: Run, numbers: Sequence[Number], theta: np.ndarray, own: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Errors (N, C) and their central differences (N, C, p + k) by the free numbers and the record's own effects."""
    error = p.residuals(theta, run, own)
    out = np.empty((*error.shape, len(numbers) + own.size))
    for j, n in enumerate(numbers):
        h, ahead, behind = DIFFERENCE * n.sd, theta.copy(), theta.copy()
        ahead[n.place] += h
        behind[n.place] -= h
        out[:, :, j] = (p.residuals(ahead, run, own) - p.residuals(behind, run, own)) / (2.0 * h)
    for j, sd in enumerate(p.own_sd):
        h = 10.0 * DIFFERENCE * sd
        step = h * (np.arange(own.size) == j)
        ahead, behind = p.residuals(theta, run, own + step), p.residuals(theta, run, own - step)
        out[:, :, len(numbers) + j] = (ahead - behind) / (2.0 * h)
    return error, out
