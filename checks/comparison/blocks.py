"""Least squares over blocks of whitened rows: sums per block, robust covariance from the blocks, explained sums; and
means of sizes that may differ between records.

Rows are whitened where their noise is white noise on a random walk (the local-level model).  Everything after the sums
is algebra with few numbers, so that forward selection is quick.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...models.linear_algebra import matrix_rank, pinv
from ..tails import f_tail, normal_quantile, student_quantile

BLOCKS = 12
"""Blocks a record is cut into: their scores tell how far the rows are from independent."""
LONGEST_GAP = 5
"""Samples that may be lost of a channel before its integral starts anew after them."""
DIFFERENT = 0.05
"""Probability of equal sizes below which records differ in a size."""


class Sums(NamedTuple):
    """Sums of one record: Gram matrices (B, m, m) and scores (B, m) by block, squares of y, number of rows."""

    gram: np.ndarray
    score: np.ndarray
    square: float
    count: int


class BlockFit(NamedTuple):
    """Estimates (m,), their covariance (m, m), the number of blocks, and robust over model variance (m,)."""

    values: np.ndarray
    covariance: np.ndarray
    blocks: int
    inflation: np.ndarray


def whitened_steps(series: np.ndarray, joined: np.ndarray, white: float, walk: np.ndarray) -> np.ndarray:
    """Steps of series (m, T) between samples, whitened: their noise has unit variance and is uncorrelated.

    The noise of a step is e[k] - e[k - 1] + w[k], e white with standard deviation `white`, w with `walk` (T - 1,): its
    covariance is tridiagonal, and its Cholesky factor bidiagonal.

    joined (T - 1,) : steps that count; where one does not, the series starts anew.

    Returns
    -------
    (m, J) for the J steps that count.
    """
    from scipy.linalg import cholesky_banded, solve_banded

    steps = np.diff(series, axis=1)[:, joined]
    place = np.flatnonzero(joined)
    if not place.size:
        return steps
    bands = np.empty((2, place.size))
    bands[0] = 2.0 * white**2 + walk[place] ** 2
    bands[1, :-1] = np.where(np.diff(place) == 1, -(white**2), 0.0)
    bands[1, -1] = 0.0
    factor = cholesky_banded(bands, lower=True)
    return solve_banded((1, 0), factor, steps.T).T


def sums_of(rows: np.ndarray, place: np.ndarray, nuisances: int = 0) -> Sums:
    """Sums over `BLOCKS` blocks of whitened rows (1 + m + d, N): departure, columns of effects, and of so many
    nuisances, which are projected out; place (N,) in 0 .. 1 says where a row stands."""
    y, x, z = rows[0], rows[1 : len(rows) - nuisances].T, rows[len(rows) - nuisances :].T
    if nuisances:
        q = np.linalg.qr(z)[0]
        y, x = y - q @ (q.T @ y), x - q @ (q.T @ x)
    block = np.minimum((place * BLOCKS).astype(int), BLOCKS - 1)
    inside = [block == b for b in range(BLOCKS)]
    gram = np.stack([x[i].T @ x[i] for i in inside])
    return Sums(gram, np.stack([x[i].T @ y[i] for i in inside]), float(y @ y), y.size)


def total(parts: Sequence[Sums], active: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
    """Gram matrix (k, k) and score (k,) of the active columns over all records."""
    act = list(active)
    gram = np.sum([p.gram.sum(axis=0) for p in parts], axis=0)[np.ix_(act, act)]
    return gram, np.sum([p.score.sum(axis=0) for p in parts], axis=0)[act]


def explained(parts: Sequence[Sums], active: Sequence[int]) -> float:
    """Sum of squares that the active columns explain together."""
    if not len(active):
        return 0.0
    gram, score = total(parts, active)
    return float(score @ pinv(gram, hermitian=True) @ score)


def fit(parts: Sequence[Sums], active: Sequence[int]) -> BlockFit:
    """Least squares of the active columns over all records.

    The covariance is the sandwich of the blocks' scores, each variance at least that of independent rows.
    """
    act = list(active)
    gram, score = total(parts, act)
    inverse = pinv(gram, hermitian=True)
    values = inverse @ score
    scores = np.concatenate([p.score[:, act] - p.gram[:, act][:, :, act] @ values for p in parts])
    blocks = len(scores)
    influence = scores @ inverse
    robust = influence.T @ influence * blocks / max(blocks - len(act), 1)
    rows = sum(p.count for p in parts)
    residual = max(sum(p.square for p in parts) - float(score @ values), 0.0)
    plain = inverse * max(residual / max(rows, 1), 1.0)
    inflation = np.diag(robust) / np.maximum(np.diag(plain), 1e-300)
    grow = np.sqrt(np.maximum(1.0 / np.maximum(inflation, 1e-12), 1.0))
    return BlockFit(values, robust * np.outer(grow, grow), blocks, np.maximum(inflation, 1.0))


def p_value(fit: BlockFit, places: Sequence[int]) -> float:
    """Probability of estimates at `places` as large as these where all are zero: an F test on the blocks' scatter."""
    at = list(places)
    k, dof = len(at), fit.blocks - fit.values.size
    spread = fit.covariance[np.ix_(at, at)]
    if dof < 1 or not np.isfinite(spread).all() or matrix_rank(spread) < k:
        return 1.0
    x = fit.values[at]
    wald = float(x @ np.linalg.solve(spread, x))
    if dof <= k:
        return 1.0
    return f_tail(wald * (dof - k + 1) / (dof * k), k, dof - k + 1)


class Mean(NamedTuple):
    """Mean over records with its interval, the standard deviation between records, and the p-value of equal sizes."""

    value: float
    low: float
    high: float
    between: float
    p_equal: float

    @property
    def of_another(self) -> float:
        """What a further record is expected to have: none, where the records differ and the interval holds zero."""
        return 0.0 if self.p_equal < DIFFERENT and self.low * self.high <= 0.0 else self.value


def random_effects_mean(values: np.ndarray, spread: np.ndarray, level: float = 0.90, dof: float = np.inf) -> Mean:
    """Mean of sizes (R,) with standard errors (R,), by DerSimonian and Laird, interval by Hartung and Knapp.

    dof : degrees of freedom of each standard error.  The interval is at least as wide as that of equal sizes
    (the modification of Roever, Knapp and Friede 2015, doi 10.1186/s12874-015-0091-1), and for one record its own.
    """
    weight = 1.0 / np.maximum(spread, 1e-300) ** 2
    n, whole = values.size, float(weight.sum())
    fixed = float(weight @ values / whole)
    own = 0.5 * (1.0 + level)
    if n == 1:
        half = float((student_quantile(own, dof) if np.isfinite(dof) else normal_quantile(own)) * spread[0])
        return Mean(fixed, fixed - half, fixed + half, 0.0, 1.0)
    q = float(weight @ (values - fixed) ** 2)
    p = f_tail(q / (n - 1), n - 1, n * dof if np.isfinite(dof) else 1e9)
    between = max(q - (n - 1), 0.0) / (whole - float(weight @ weight) / whole)
    weight = 1.0 / (np.maximum(spread, 1e-300) ** 2 + between)
    mean = float(weight @ values / weight.sum())
    scatter = float(weight @ (values - mean) ** 2) / (n - 1)
    half = float(student_quantile(own, n - 1) * np.sqrt(max(scatter, 1.0) / weight.sum()))
    return Mean(mean, mean - half, mean + half, float(np.sqrt(between)), p)
