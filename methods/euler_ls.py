"""Euler-difference least squares of paper 001: A1, the improved transformation, and A2, the traditional one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..datasets.record import Record
from ..estimation.numerics import factors
from ..estimation.regression.integrated import mass_matrices
from ..estimation.regression.least_squares import least_squares
from ..estimation.regression.samples import RegressionSamples, n_accelerations
from ..estimation.regression.schemes import regression_samples
from ..estimation.results.fit import Fit
from ..models.errors import CannotFit, FitFailed
from ..models.linear_algebra import condition_number
from ..models.model import Model
from .base import method
from .options import option, words

ALGORITHMS = ("A1", "A2")


@method("euler-ls", "Euler-difference least squares of paper 001 (A1, A2)", variants=("corrected", "as_printed"))
def EulerLs(
    records: Sequence[Record],
    model: Model,
    algorithm: str = option(
        "A1",
        "'A1' divides the equations by the square of the speed and keeps the known inertia on the left side (eq "
        "20-26): one row per equation with the coefficients themselves.  'A2' regresses u(t+1), v(t+1), r(t+1) on "
        "u(t), v(t), r(t) and all terms (eq 9-19), whose coefficients mix sway and yaw and are separated by the "
        "inertia matrix afterwards",
        words("algorithm", ALGORITHMS),
    ),
    variant: str = option(
        "corrected",
        "'corrected' (orthogonal decomposition with scaled columns), or 'as_printed': (H'H)^-1 H'Y of eq 19 and 26 on "
        "unscaled columns, which squares a condition number of 1e7",
    ),
) -> Fit:
    """Least squares on explicit Euler differences of a 3-DOF model.

    Exact on records made by explicit Euler; on others the bias is that of a forward difference.
    """
    if not model.is_3dof:
        raise CannotFit(f"euler-ls is for 3-DOF models, and {model.id} is a response model")
    parts = regression_samples(records, model, "forward")
    printed = variant == "as_printed"
    solve = _improved if algorithm == "A1" else _traditional
    c, covariance, condition = solve(parts, model, printed)
    return Fit(c, covariance, extra={"condition": condition})


def _speed_squared(part: RegressionSamples, model: Model) -> np.ndarray:
    u, v = (part.states[:, model.regression_states.index(s)] for s in ("u", "v"))
    return np.maximum(u**2 + v**2, 1e-12)


def _solved(factor: np.ndarray, n: int, printed: bool) -> tuple[np.ndarray, np.ndarray, float]:
    """Solution x (m,), its covariance (m, m), and the condition number of the unscaled columns."""
    used = np.flatnonzero(np.any(factor[:, :-1] != 0.0, axis=0))
    if not used.size or not np.isfinite(factor).all():
        raise FitFailed("the regression has no finite, non-zero columns")
    a, b = factor[:, used], factor[:, -1]
    x, covariance = np.zeros(factor.shape[1] - 1), np.diag(np.full(factor.shape[1] - 1, np.inf))
    condition = condition_number(a)
    if printed:
        inverse = np.linalg.inv(a.T @ a)
        x[used] = inverse @ (a.T @ b)
        unit = inverse
    else:
        solution = factors.solve(np.column_stack([a, b]))
        x[used], unit = solution.x, solution.covariance
    variance = float(np.sum((a @ x[used] - b) ** 2)) / max(n - used.size, 1)
    covariance[np.ix_(used, used)] = unit * variance
    return x, covariance, condition


def _improved(parts: Sequence[RegressionSamples], model: Model, printed: bool) -> tuple[np.ndarray, np.ndarray, float]:
    """A1: rows divided by the square of the speed; coefficients (p,), covariance (p, p) and condition number."""
    k, p, n = n_accelerations(model), len(model.coordinates), sum(len(part.time_s) for part in parts)
    found = [factors.empty(p) for _ in range(k)]
    for part in parts:
        weight, start = 1.0 / _speed_squared(part, model), 0
        for y, phi in part.blocks(model):
            w = weight[start : start + len(y), None]
            start += len(y)
            found = [factors.fold(found[e], w * np.column_stack([phi[:, e], y[:, e]])) for e in range(k)]
    stacked = np.array([np.vstack([r, np.zeros((p + 1 - len(r), p + 1))]) for r in found])
    if printed:
        return _solved(stacked.reshape(-1, p + 1), n * k, True)
    solution = least_squares(stacked, np.full(k, n))
    return solution.coefficients, solution.covariance, solution.condition


def inertia(model: Model, part: RegressionSamples) -> tuple[np.ndarray, np.ndarray]:
    """Inertia matrix (k, k) and its inverse, of a 3-DOF model whose left side is proportional to the accelerations.

    Raises
    ------
    CannotFit : it changes with the state, or the regressors hold accelerations.
    """
    mass = mass_matrices(model, part.states[:2], part.inputs[:2])
    if not np.allclose(mass[0], mass[1], rtol=1e-12, atol=0.0):
        raise CannotFit(f"the inertia of model {model.id} changes with the state")
    return mass[0], np.linalg.inv(mass[0])


def _traditional(
    parts: Sequence[RegressionSamples], model: Model, printed: bool
) -> tuple[np.ndarray, np.ndarray, float]:
    """A2: x_j(t+1) on x_j(t) and the terms of every equation that changes x_j, one problem for each j.

    A known part of the left side, if there is one, is moved to the terms.  Terms that two equations share (as sway and
    yaw do) enter once; their coefficients are those of the accelerations, M^-1 times those of the forces.
    """
    k, p, n = n_accelerations(model), len(model.coordinates), sum(len(part.time_s) for part in parts)
    mass, inverse = inertia(model, parts[0])
    uses, same = _terms(parts, model)
    changed_by = [np.flatnonzero(np.abs(inverse[j]) > 0.0) for j in range(k)]
    columns = [sorted({int(same[i]) for e in changed_by[j] for i in uses[e]}) for j in range(k)]
    x, covariance, conditions = np.zeros((k, p)), np.zeros((k, p, p)), []
    for j, factor in enumerate(_state_factors(parts, model, inverse, columns)):
        solved, spread, condition = _solved(factor, n, printed)
        x[j, columns[j]] = solved[1:]
        covariance[j][np.ix_(columns[j], columns[j])] = spread[1:, 1:]
        conditions.append(condition)
    c, total, mixing = np.zeros(p), np.zeros((p, p)), np.zeros((k, p, p))
    for e in range(k):
        for i in uses[e]:
            c[i] = mass[e] @ x[:, same[i]]
            mixing[:, i, same[i]] = mass[e]
    for j in range(k):
        finite = np.where(np.isfinite(covariance[j]), covariance[j], 0.0)
        total += mixing[j] @ finite @ mixing[j].T
    return c, total, max(conditions)


def _state_factors(
    parts: Sequence[RegressionSamples], model: Model, inverse: np.ndarray, columns: Sequence[Sequence[int]]
) -> list[np.ndarray]:
    """Triangular factors of [x_j(t), h terms of `columns[j]` | x_j(t+1)] for each state j."""
    found = [factors.empty(1 + len(own)) for own in columns]
    for part in parts:
        h, start = float(np.median(np.diff(part.time_s))), 0
        for y, phi in part.blocks(model):
            cut = slice(start, start + len(y))
            start += len(y)
            known = part.accelerations[cut] - y @ inverse.T  # the part of the left side that is not M a
            terms = phi.sum(axis=1)  # every coefficient stands in one equation
            for j, own in enumerate(columns):
                state = part.states[cut, j]
                right = state + h * (part.accelerations[cut, j] - known[:, j])
                found[j] = factors.fold(found[j], np.column_stack([state, h * terms[:, own], right]))
    return found


def _terms(parts: Sequence[RegressionSamples], model: Model) -> tuple[list[list[int]], np.ndarray]:
    """Coefficients in each equation, and for each the first coefficient (p,) that multiplies the same function.

    Raises
    ------
    CannotFit : a coefficient stands in two equations.
    """
    _, phi = next(parts[0].blocks(model))
    nonzero = np.any(phi != 0.0, axis=0)
    if (nonzero.sum(axis=0) > 1).any():
        raise CannotFit(f"model {model.id} has a coefficient in two equations")
    uses = [np.flatnonzero(row).tolist() for row in nonzero]
    values = phi.sum(axis=1)
    same = np.arange(values.shape[1])
    for i in range(values.shape[1]):
        for j in range(i):
            if np.any(values[:, j]) and np.allclose(values[:, i], values[:, j], rtol=1e-12, atol=0.0):
                same[i] = j
                break
    return uses, same
