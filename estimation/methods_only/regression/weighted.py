"""Weighted and reweighted least squares over the rows of a regression, block by block."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ....models.errors import FitFailed
from ....models.linear_algebra import lstsq
from ....models.model import Model
from ...numerics import factors
from ...regression.least_squares import equation_factors, least_squares
from ...regression.samples import RegressionSamples, n_accelerations

KEPT = 20_000_000
"""Numbers up to which an evaluated regression is kept in memory; a larger one is evaluated again in each pass."""
SMALLEST_SCALE = 1e-13
"""Smallest scale of an equation's residuals, relative to the root mean square of its left side."""


STILL, MOST_ITERATIONS = 1e-8, 100
"""Change of the coefficients, in standard errors, at which reweighting ends, and its iterations at most."""


def mad(values: np.ndarray) -> np.ndarray:
    """Standard deviation (...) of Gaussian values (N, ...) with zero mean, from the median of their sizes."""
    return 1.4826 * np.median(np.abs(values), axis=0)


class RegressionRows:
    """The rows y (N, k), phi (N, k, p) of all records; equations without unknowns are left out.

    `start` is the least-squares solution, `used` (k,) the equations kept and `left` (k,) the root mean squares of
    their left sides.

    Raises
    ------
    FitFailed : no column is finite and non-zero.
    """

    def __init__(self, parts: Sequence[RegressionSamples], model: Model) -> None:
        self.parts, self.model, self.p = parts, model, len(model.coordinates)
        self.n = sum(len(part.time_s) for part in parts)
        self.equations, self.counts = equation_factors(parts, model)
        self.start = least_squares(self.equations, self.counts)
        self.used = np.flatnonzero(np.isfinite(self.start.residual_sd))
        if not self.used.size:
            raise FitFailed("the regression's residuals are not finite")
        self.left = np.where(self.start.left_rms[self.used] > 0.0, self.start.left_rms[self.used], 1.0)
        self._kept: list[tuple[np.ndarray, np.ndarray]] | None = None
        if self.n * n_accelerations(model) * self.p <= KEPT:
            self._kept = list(self._evaluated())

    def _evaluated(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        for part in self.parts:
            for y, phi in part.blocks(self.model):
                yield y[:, self.used], phi[:, self.used]

    def blocks(self) -> Iterator[tuple[slice, np.ndarray, np.ndarray]]:
        """Pieces of the rows: their place, y (n, k) and phi (n, k, p)."""
        start = 0
        for y, phi in self._kept if self._kept is not None else self._evaluated():
            yield slice(start, start + len(y)), y, phi
            start += len(y)

    def residuals(self, coefficients: np.ndarray) -> np.ndarray:
        """y - phi c, (N, k)."""
        found = np.empty((self.n, self.used.size))
        for rows, y, phi in self.blocks():
            found[rows] = y - (phi.reshape(-1, self.p) @ coefficients).reshape(y.shape)
        return found

    def factor(self, weights: np.ndarray) -> np.ndarray:
        """Triangular factor of [phi | y] with rows multiplied by the square roots of weights (N, k) or (k,)."""
        found = factors.empty(self.p)
        root = np.broadcast_to(np.sqrt(weights), (self.n, self.used.size))
        for rows, y, phi in self.blocks():
            stacked = np.column_stack([phi.reshape(-1, self.p), y.ravel()])
            chosen = root[rows].ravel()
            if not (chosen > 0.0).all():
                stacked, chosen = stacked[chosen > 0.0], chosen[chosen > 0.0]
            stacked *= chosen[:, None]
            found = factors.fold(found, stacked)
        return found

    def scale(self, residuals: np.ndarray) -> np.ndarray:
        """Scale (k,) of residuals (N, k) by their median size, at least the rounding level of the left side."""
        return np.maximum(mad(residuals), SMALLEST_SCALE * self.left)

    def least_residual_sd(self) -> np.ndarray:
        """Residual standard deviation (k,) of each equation by least squares, at least its rounding level."""
        return np.maximum(self.start.residual_sd[self.used], SMALLEST_SCALE * self.left)


class Reweighted(NamedTuple):
    """Outcome of `reweighted`: the last solution (covariance for residuals of unit scale) and the scale (k,)."""

    solution: factors.Solution
    scale: np.ndarray
    n_iterations: int
    converged: bool


def reweighted(
    rows: RegressionRows,
    start: np.ndarray,
    weight: Callable[[np.ndarray], np.ndarray],
    scale: np.ndarray | None = None,
) -> Reweighted:
    """Iteratively reweighted least squares: weights w(e/s) of each scaled residual.

    Parameters
    ----------
    start : (p,) first coefficients.
    weight : scaled residuals (N, k) -> weights in [0, 1].
    scale : (k,) fixed scale of the residuals; None computes the MAD again in each iteration.

    Raises
    ------
    FitFailed : a solution is not finite.
    """
    c = start
    for iteration in range(1, MOST_ITERATIONS + 1):
        residuals = rows.residuals(c)
        s = rows.scale(residuals) if scale is None else scale
        solution = factors.solve(rows.factor(weight(residuals / s) / s**2))
        if not np.isfinite(solution.x).all():
            raise FitFailed("the reweighted regression has no finite solution")
        change = lstsq(solution.half, solution.x - c)
        c = solution.x
        if np.abs(change).max(initial=0.0) < STILL * max(1.0, np.abs(solution.scores).max(initial=0.0) * 1e-4):
            return Reweighted(solution, s, iteration, True)
    return Reweighted(solution, s, MOST_ITERATIONS, False)
