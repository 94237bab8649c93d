"""Recursive least squares over the rows of records: prior, scaling, the recursion itself and its covariance.

The coefficients theta and their covariance P are updated sample by sample.  How one sample changes them is an
`UpdateRule`; the rules of the multi-innovation and iterative-learning methods stand with these methods.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from ....models.errors import CannotFit, FitFailed
from ....models.model import Model
from ...numerics import factors
from ...regression.samples import RegressionSamples
from ...results.fit import LONGEST_PATH, Fit

PRIORS = ("scaled", "physical")


class UpdateRule:
    """How scalar rows change the coefficients and P."""

    plain_covariance: bool = False
    """Whether the rule works on P itself instead of its factors."""
    forgetting: float = 1.0
    """Forgetting factor of one sample, 1 for none."""
    repetitions: float = 1.0
    """How often a row has been used on average: P is so many times smaller than the covariance."""

    def run(
        self,
        y: np.ndarray,
        h: np.ndarray,
        per_sample: int,
        theta: np.ndarray,
        factor: np.ndarray,
        diagonal: np.ndarray,
        path: np.ndarray,
    ) -> None:
        """Go through scalar rows y (M,), h (M, p), `per_sample` of them to a sample, updating the rest in place.

        theta (p,); P = U diag(diagonal) U' with factor = U' (p, p), or P itself in `factor` if `plain_covariance`;
        path (M, p) takes theta after each row.
        """
        raise NotImplementedError(f"{type(self).__name__} does not implement run()")


class LeastSquaresRule(UpdateRule):
    """Weighted least squares with forgetting (paper 000, eq 22).

    mu is the forgetting factor of one sample and weight the constant weight L(k); with `as_printed` the equation is
    taken literally.
    """

    def __init__(self, mu: float = 1.0, weight: float = 1.0, as_printed: bool = False) -> None:
        self.forgetting, self.repetitions, self.plain_covariance = mu, weight, as_printed

    def run(self, y, h, per_sample: int, theta, factor, diagonal, path) -> None:
        from ._kernels import recursive_ls

        forget, weight = np.ones(len(y)), self.repetitions
        forget[::per_sample] = self.forgetting
        if not self.plain_covariance:
            recursive_ls(y, h, forget, weight, theta, factor, diagonal, path)
            return
        for k, (row, mu) in enumerate(zip(h, forget, strict=True)):
            moved, predicted = factor @ row, row @ theta / mu
            factor[:] = factor / mu - np.outer(moved, moved) / (mu * mu / weight + mu * (row @ moved))
            theta[:] = theta / mu + weight * (y[k] - predicted) * (factor @ row)
            path[k] = theta


def row_scales(parts: Sequence[RegressionSamples], model: Model, physical: bool) -> tuple[np.ndarray, np.ndarray, int]:
    """Root mean squares of the rows' left sides (k,), or 1 if `physical`, and of the columns (p,), and the number of
    samples.  Zeros are replaced by one; an equation without unknowns has an infinite scale.

    Raises
    ------
    FitFailed : no column is finite and non-zero.
    """
    left, columns, n = 0.0, 0.0, 0
    for y, phi in _blocks(parts, model):
        left, columns, n = left + (y**2).sum(axis=0), columns + (phi**2).sum(axis=0), n + len(y)
    equations = np.sqrt(np.asarray(left) / n)
    used = (np.asarray(columns) > 0.0).any(axis=1) & (equations > 0.0)
    if not used.any() or not np.isfinite(columns).all():
        raise FitFailed("the regression has no finite, non-zero columns")
    equations = np.where(used, np.ones_like(equations) if physical else equations, np.inf)
    total = np.sqrt((np.asarray(columns) / n / equations[:, None] ** 2).sum(axis=0))
    return equations, np.where(total > 0.0, total, 1.0), n


def _blocks(parts: Sequence[RegressionSamples], model: Model) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    for part in parts:
        yield from part.blocks(model)


def recursion(
    parts: Sequence[RegressionSamples], model: Model, rule: UpdateRule, p0: float, theta0: Any, prior: str
) -> Fit:
    """Go through all samples once, record after record; P and the coefficients are carried over.

    g = P h/(mu/L + h'P h);  theta += g (y - h'theta);  P = (P - g h'P)/mu  for each scalar row (paper 000, eq 22 with
    its erratum), or whatever the rule does instead.  Regressors are scaled inside.  Of a long trajectory every second,
    third, ... sample is kept, the last one among them.

    Parameters
    ----------
    p0, theta0 : initial P = p0 I and coefficients, one number for all or (p,) numbers.
    prior : where P is p0 I: 'scaled', where every column of the regression and every equation has unit root mean
        square, or 'physical', in the model's coordinates and the rows as they are.

    Raises
    ------
    CannotFit : theta0 has another number of values.
    FitFailed : no column is finite and non-zero.
    """
    equations, columns, n = row_scales(parts, model, prior == "physical")
    if np.shape(theta0) not in ((), columns.shape):
        raise CannotFit(f"theta0 has {np.size(theta0)} numbers for {columns.size} coefficients")
    theta, used = np.asarray(theta0, float) * columns, np.flatnonzero(np.isfinite(equations))
    diagonal = p0 * (columns**2 if prior == "physical" else np.ones(columns.size))
    factor = np.diag(diagonal) if rule.plain_covariance else np.eye(columns.size)
    residuals, paths, done = factors.empty(columns.size), [], 0
    stride = max(1, -(-n * columns.size // LONGEST_PATH))
    for y, phi in _blocks(parts, model):
        rows = np.ascontiguousarray((phi[:, used] / equations[used, None] / columns).reshape(-1, columns.size))
        left, path = np.ascontiguousarray((y / equations)[:, used].ravel()), np.empty_like(rows)
        rule.run(left, rows, used.size, theta, factor, diagonal, path)
        residuals = factors.fold(residuals, np.column_stack([rows, left]))
        paths.append(path[used.size - 1 :: used.size][(n - 1 - done) % stride :: stride] / columns)
        done += len(y)
    covariance = factor if rule.plain_covariance else (factor.T * diagonal) @ factor
    noise = _noise(residuals @ np.append(theta, -1.0), n, used.size, rule)
    return Fit(
        theta / columns,
        covariance * noise / np.outer(columns, columns),
        n_iterations=n,
        trajectory=np.concatenate(paths),
        trajectory_time_s=_clock([part.time_s for part in parts if part.time_s.size])[(n - 1) % stride :: stride],
    )


def _noise(errors: np.ndarray, n: int, per_sample: int, rule: UpdateRule) -> float:
    """By what P is multiplied to be a covariance: the residual variance, the repetitions of a row, and the loss of data
    by forgetting.  errors (p + 1,) have the squared length of the residuals of all n samples."""
    mu = rule.forgetting
    forgotten = 1.0 if mu == 1.0 else (1.0 - mu ** (2 * n)) / ((1.0 - mu**n) * (1.0 + mu))
    freedom = max(n * per_sample - errors.size + 1, 1)
    return float((errors**2).sum()) / freedom * rule.repetitions * forgotten


def _clock(times: Sequence[np.ndarray]) -> np.ndarray:
    """Seconds of record up to every sample, summed over the records with sample times (N,), s."""
    starts = np.cumsum([0.0, *(np.ptp(time) for time in times)])
    return np.concatenate([start + time - time[0] for start, time in zip(starts, times, strict=False)])
