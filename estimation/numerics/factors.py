"""Least squares by triangular factors, which rows are folded into block by block: memory does not grow with a record.

A factor is the upper triangle R (m + 1, m + 1) of the QR decomposition of [A | b].  It holds all that the problem
A c = b needs, at the accuracy of an orthogonal decomposition (normal equations would square the condition number).
Source: Lawson & Hanson 1974, Solving Least Squares Problems, ch 27 (sequential processing of rows).
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ...models.linear_algebra import svd

BLOCK = 8192
"""Rows folded at a time."""


def fold(factor: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Factor (<= m, m) of the rows already in `factor` and of `rows` (N, m)."""
    for start in range(0, rows.shape[0], BLOCK):
        block = rows[start : start + BLOCK]
        factor = upper_triangle(np.concatenate([factor, block]) if len(factor) else block)
    return factor


def upper_triangle(rows: np.ndarray) -> np.ndarray:
    """R (min(N, m), m) of the QR decomposition of rows (N, m), as `numpy.linalg.qr` with mode 'r' gives it.

    numpy takes a third of its time to build the mask of the triangle.
    """
    reflectors, _ = np.linalg.qr(rows, mode="raw")
    height = min(rows.shape)
    return np.where(_below(height, rows.shape[1]), 0.0, reflectors.T[:height])


@lru_cache(maxsize=256)
def _below(height: int, width: int) -> np.ndarray:
    """(height, width) whether an element is below the diagonal."""
    return np.tri(height, width, k=-1, dtype=bool)


def of_all_others(each: np.ndarray) -> np.ndarray:
    """For each of W factors (W, ..., m, m) the factor of the rows of all others, in about 3 W decompositions.

    Pairs are joined, the factors of all other pairs are found by the same rule, and each half of a pair joins its other
    half to them.
    """
    if len(each) < 2:
        return np.zeros_like(each)
    odd = len(each) % 2
    padded = np.concatenate([each, np.zeros_like(each[:odd])])
    first, second = padded[0::2], padded[1::2]
    outside = of_all_others(_of_both(first, second))
    others = np.stack([_of_both(outside, second), _of_both(outside, first)], axis=1).reshape(padded.shape)
    return others[: len(each)]


def _of_both(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Factors (..., m, m) of the rows of both."""
    return np.asarray(np.linalg.qr(np.concatenate([one, other], axis=-2), mode="r"))


def divisors(sizes: np.ndarray) -> np.ndarray:
    """Sizes (...) to divide by: 1 in the place of those that are not above zero."""
    return np.where(sizes > 0.0, sizes, 1.0)


def column_lengths(rows: np.ndarray) -> np.ndarray:
    """Euclidean lengths (m,) of columns (N, m), 1 of those that are zero."""
    return divisors(np.linalg.norm(rows, axis=0))


def empty(columns: int) -> np.ndarray:
    """Factor of no rows for `columns` unknowns and one right-hand side."""
    return np.zeros((0, columns + 1))


class Solution(NamedTuple):
    """A least-squares solution of m unknowns."""

    x: np.ndarray
    """(m,)"""
    covariance: np.ndarray
    """(m, m) for unit noise variance; infinite on the diagonal of undetermined unknowns."""
    rank: int
    condition: float
    half: np.ndarray
    """(m, rank) with half half' = covariance of the determined part."""
    scores: np.ndarray
    """(rank,) with x = half @ scores: the solution along each column of `half`, in units of the noise."""
    null: np.ndarray
    """(m, m - rank): directions that the rows do not determine."""
    residual: float
    """Sum of the squared residuals."""


def solve(factor: np.ndarray, tolerance: float | None = None) -> Solution:
    """Minimum-norm solution (in columns scaled to unit length) of the rows in `factor` (rows, m + 1).

    Directions whose singular value is below `tolerance` times the largest count as undetermined; the default
    tolerance is the rounding level of the factor.
    """
    a, b = factor[:, :-1], factor[:, -1]
    scale = column_lengths(a)
    u, s, vt = svd(a / scale, full_matrices=True)
    m = a.shape[1]
    limit = (np.finfo(float).eps * max(m, 10) if tolerance is None else tolerance) * (s[0] if s.size else 0.0)
    rank = int((s > limit).sum())
    v = vt[:rank].T / scale[:, None]
    scores = (u.T @ b)[:rank]
    half = v / s[:rank]
    x = half @ scores
    covariance = half @ half.T
    null = vt[rank:].T / scale[:, None]
    mark_undetermined(covariance, vt[rank:].T)
    residual = float(np.sum((a @ x - b) ** 2))
    condition = float(s[0] / s[rank - 1]) if rank else np.inf
    return Solution(x, covariance, rank, condition, half, scores, null, residual)


def rank_message(rank: int, unknowns: int) -> str:
    """Message about the rank of a solution of that many unknowns; empty where all directions are determined."""
    return "" if rank == unknowns else f"the records determine {rank} of {unknowns} directions"


def mark_undetermined(covariance: np.ndarray, null: np.ndarray) -> None:
    """Set the variance of every unknown that has a part in a direction of `null` (m, d) to infinity, in place."""
    if null.shape[1]:
        unknown = np.flatnonzero(np.linalg.norm(null, axis=1) > 1e-6)
        covariance[unknown, unknown] = np.inf
