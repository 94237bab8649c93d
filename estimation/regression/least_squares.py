"""Least squares on a model's regression equations, weighted by each equation's own residual.

Feasible generalised least squares: a first solution with equations of equal spread gives the residual of each
equation, the second solution divides by it.  Source: Aitken 1935, Proc. R. Soc. Edinburgh 55, 42.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...datasets.record import Record
from ...models.errors import FitFailed
from ...models.model import Model
from ..numerics import factors
from .samples import RegressionSamples, n_accelerations
from .schemes import regression_samples

SMALLEST_RESIDUAL = 1e-14
"""Smallest residual standard deviation of an equation, relative to the root mean square of its left side."""


class LeastSquares(NamedTuple):
    """Outcome of `least_squares`, in the units of the p coefficients."""

    coefficients: np.ndarray
    """(p,)"""
    covariance: np.ndarray
    """(p, p); infinite on the diagonal where the rows do not determine a coefficient."""
    rank: int
    condition: float
    """Condition number of the columns scaled to unit length."""
    residual_sd: np.ndarray
    """(k,) standard deviation of each equation's residual; nan for an equation without unknowns."""
    left_rms: np.ndarray
    """(k,) root mean square of each equation's left side; nan likewise."""
    n: int
    """Rows in each equation."""
    half: np.ndarray
    """(p, rank) with half half' = covariance of the determined part, at full accuracy."""
    scores: np.ndarray
    """(rank,) with coefficients = half @ scores: the solution in standard deviations of the noise."""
    null: np.ndarray
    """(p, p - rank): directions that the rows do not determine."""

    def significant(self, least: float = 3.0) -> np.ndarray:
        """Coefficients (p,) that keep only the directions larger than `least` standard deviations of the noise."""
        if not np.any(self.half):  # a fit without any residual
            return self.coefficients
        return self.half @ np.where(np.abs(self.scores) > least, self.scores, 0.0)


def equation_factors(
    parts: Sequence[RegressionSamples], model: Model, sources: Sequence[str] = ()
) -> tuple[np.ndarray, np.ndarray]:
    """Triangular factors (e, p + 1, p + 1) of [Phi | y] for each equation and source of the yaw rate, and the number of
    rows (e,) behind each.

    Parameters
    ----------
    sources : those that get equations even where no row has them; default: the ones of the parts.
    """
    k, p = n_accelerations(model), len(model.coordinates)
    every = sources or sorted({part.source for part in parts})
    folded = {(source, e): factors.empty(p) for source in every for e in range(k)}
    counts = dict.fromkeys(folded, 0)
    for part in parts:
        for y, phi in part.blocks(model):
            for e in range(k):
                key = (part.source, e)
                folded[key] = factors.fold(folded[key], np.column_stack([phi[:, e], y[:, e]]))
                counts[key] += len(y)
    padded = [np.vstack([r, np.zeros((max(p + 1 - len(r), 0), p + 1))])[: p + 1] for r in folded.values()]
    return np.array(padded), np.maximum([*counts.values()], 1 if sources else 0)


def least_squares(equations: np.ndarray, counts: np.ndarray) -> LeastSquares:
    """Feasible generalised least squares over k equations that may share unknowns.

    Columns are scaled to unit length inside.  Undetermined directions get the solution of minimum norm and infinite
    variance.

    Parameters
    ----------
    equations : (k, p + 1, p + 1) triangular factors of [Phi | y].
    counts : (k,) rows behind each factor.

    Raises
    ------
    FitFailed : no column is finite and non-zero.
    """
    p = equations.shape[2] - 1
    used = np.array([np.any(r[:, :p]) for r in equations])
    equations, counts = equations[used], counts[used]
    if not len(equations) or not np.isfinite(equations).all():
        raise FitFailed("the regression has no finite, non-zero columns")
    rms = np.linalg.norm(equations[:, :, p], axis=1) / np.sqrt(counts)
    scale = np.where(rms > 0.0, rms, 1.0)
    weight = 1.0 / scale
    solution, sd = _weighted(equations, counts, weight)
    if len(equations) > 1:
        weight = 1.0 / np.maximum(sd, SMALLEST_RESIDUAL * scale)
        solution, sd = _weighted(equations, counts, weight)
    residual_sd, left_rms = np.full((2, used.size), np.nan)
    residual_sd[used], left_rms[used] = sd, rms
    return _in_units(solution, float(np.mean((sd * weight) ** 2)), residual_sd, left_rms, int(counts.max()))


def _weighted(equations: np.ndarray, counts: np.ndarray, weight: np.ndarray) -> tuple[factors.Solution, np.ndarray]:
    """Solution with equations multiplied by weight (k,), and the residual standard deviation (k,) of each."""
    solution = factors.solve(np.vstack([w * r for w, r in zip(weight, equations, strict=True)]))
    left = equations @ np.append(solution.x, -1.0)
    unknowns = np.array([np.any(r[:, :-1], axis=0).sum() for r in equations])
    freedom = np.maximum(counts - np.minimum(unknowns, solution.rank), 1)
    return solution, np.sqrt((left**2).sum(axis=1) / freedom)


def _in_units(
    solution: factors.Solution, noise: float, residual_sd: np.ndarray, left_rms: np.ndarray, n: int
) -> LeastSquares:
    """The solution for weighted rows of variance `noise`."""
    scores = solution.scores / np.sqrt(noise) if noise > 0.0 else solution.scores
    return LeastSquares(
        coefficients=solution.x,
        covariance=solution.covariance * noise,
        rank=solution.rank,
        condition=solution.condition,
        residual_sd=residual_sd,
        left_rms=left_rms,
        n=n,
        half=solution.half * np.sqrt(noise),
        scores=scores,
        null=solution.null,
    )


def fit_by_scheme(records: Sequence[Record], model: Model, scheme: str) -> LeastSquares:
    """Least squares on records by a scheme (see `schemes`).

    Raises
    ------
    CannotFit : a record lacks a channel, or there are no more rows than coefficients.
    FitFailed : no column is finite and non-zero.
    """
    return least_squares(*equation_factors(regression_samples(records, model, scheme), model))
