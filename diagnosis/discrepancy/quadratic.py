"""The log likelihood as a quadratic in all parameters, kept by blocks of the records.

After one linearisation everything else (scales of the discrepancy, tests, sizes by record, records left out) is algebra
with about a hundred numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...estimation.filters.innovations.noise_fit import CLIP
from ...estimation.likelihood.minimiser import damped_step
from ...models.linear_algebra import finite, lstsq, pinv
from .terms import NUMBERS, SIDE

AXES = 3
START = np.array([0.25**2, 0.01, *[1e-10] * AXES])
LEAST = np.array([0.005**2, 1e-4, *[1e-16] * AXES])
MOST = np.array([5.0**2, 1.0, *[1e-4] * AXES])
"""Variances of the groups: where estimation starts, and bounds."""
CLOSE = 0.02
"""Change of a log variance at which the fixed point counts as reached."""
NOTHING = 1e-100
"""Diagonal element of the Gram matrix of a parameter that changes nothing in the records: it stays at zero."""


@dataclass(frozen=True)
class Quadratic:
    """Gram matrices (B, m, m) and slopes (B, m) by block, in parameters (m,); `const` is the value at zero.

    group (m,) : group of a term of the discrepancy, -1 for a parameter without prior.  record (B,) : of each block.
    least_side : see `Terms`.
    """

    gram: np.ndarray
    slope: np.ndarray
    record: np.ndarray
    group: np.ndarray
    const: float
    least_side: float
    total: tuple[np.ndarray, np.ndarray]


class Mode(NamedTuple):
    """Estimates (m,) with the discrepancy's prior, places (a,) of the active parameters, their covariance (a, a), and
    the marginal log likelihood."""

    x: np.ndarray
    active: np.ndarray
    covariance: np.ndarray
    evidence: float


def quadratic(
    columns: np.ndarray, e: np.ndarray, x: np.ndarray, blocks: Sequence[tuple[int, int, int]], group: np.ndarray,
    log_likelihood: float, least_side: float,
) -> Quadratic:  # fmt: skip
    """The quadratic at parameters x (m,) where the innovations are e (N, 6) and their derivatives columns (m, N*6).

    Eq. 5 of docs/mathematics/default-route.md.

    blocks : (record, first sample, end) of each.
    """
    residual, gram, slope = np.clip(e, -CLIP, CLIP).ravel(), [], []
    for _, a, b in blocks:
        own = columns[:, 6 * a : 6 * b]
        g = own @ own.T
        gram.append(g)
        slope.append(g @ x - own @ residual[6 * a : 6 * b])
    grams, slopes = np.array(gram), np.array(slope)
    whole, pull = grams.sum(axis=0), slopes.sum(axis=0)
    const = log_likelihood - float(pull @ x) + 0.5 * float(x @ whole @ x)
    record = np.array([r for r, _, _ in blocks])
    return Quadratic(grams, slopes, record, group, const, least_side, (whole, pull))


def mode(
    q: Quadratic, variances: np.ndarray, free: Sequence[int] | np.ndarray, blocks: np.ndarray | None = None
) -> Mode:
    """Estimates at variances of the groups with parameters `free` unrestricted; all others without prior are zero.

    Eqs. 6, 7 of docs/mathematics/default-route.md.

    blocks : (B,) which count, all unless given.
    """
    matrix, pull, active, scale, held = _normal(q, variances, free, blocks)
    inverse = np.linalg.inv(matrix)
    z = inverse @ pull
    determinant = np.linalg.slogdet(matrix[:held, :held])[1]
    evidence = q.const + 0.5 * float(z @ pull) - 0.5 * float(determinant)
    x = np.zeros(q.group.size)
    x[active] = z * scale
    return Mode(x, active, inverse * np.outer(scale, scale), evidence)


def towards_mode(
    q: Quadratic, variances: np.ndarray, free: Sequence[int] | np.ndarray, x: np.ndarray, damping: float
) -> tuple[np.ndarray, float]:
    """Change (m,) of parameters x (m,) towards the mode, with a share of the normal matrix' diagonal added to it, and
    the rise of the penalised log likelihood that the quadratic predicts."""
    matrix, pull, active, scale, _ = _normal(q, variances, free)
    slope = pull - matrix @ np.divide(x[active], scale, out=np.zeros(active.size), where=scale > 0.0)
    z, rise = damped_step(matrix, slope, damping)
    change = -x
    change[active] = z * scale
    return change, rise


def _normal(
    q: Quadratic, variances: np.ndarray, free: Sequence[int] | np.ndarray, blocks: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, int]:
    """Normal matrix and right side of the active parameters in units of a scale, their places, the scale, and how many
    of them, from the first, have a prior."""
    whole, pull = q.total if blocks is None else (q.gram[blocks].sum(axis=0), q.slope[blocks].sum(axis=0))
    held = np.flatnonzero((q.group >= 0) & (variances[np.maximum(q.group, 0)] > 0.0))
    active = np.concatenate([held, np.asarray(free, int)])
    diagonal = np.diag(whole)[active]
    scale = np.where(diagonal > NOTHING, 1.0 / np.sqrt(np.maximum(diagonal, NOTHING)), 0.0)
    scale[: held.size] = np.sqrt(variances[q.group[held]])
    matrix = finite(whole[np.ix_(active, active)] * np.outer(scale, scale))
    prior = np.concatenate([np.ones(held.size), np.full(active.size - held.size, 1e-9)])
    return matrix + np.diag(prior), pull[active] * scale, active, scale, held.size


def scales(
    q: Quadratic, free: Sequence[int] | np.ndarray, starts: Sequence[np.ndarray], most: int = 40
) -> tuple[np.ndarray, float]:
    """Variances of the groups of largest marginal likelihood (MacKay's fixed point), and that likelihood.

    Eq. 8 of docs/mathematics/default-route.md.
    """
    best: tuple[np.ndarray, float] | None = None
    for start in starts:
        variances = start.copy()
        for _ in range(most):
            new = _updated(q, mode(q, variances, free), variances)
            moved = float(np.max(np.abs(np.log(new / variances))))
            variances = new
            if moved < CLOSE:
                break
        evidence = mode(q, variances, free).evidence
        if best is None or evidence > best[1] + 1e-6:
            best = variances, evidence
    assert best is not None
    return best


def _updated(q: Quadratic, at: Mode, variances: np.ndarray) -> np.ndarray:
    """One step of MacKay's fixed point (eq. 8 of docs/mathematics/default-route.md)."""
    new, group = variances.copy(), q.group[at.active]
    spread = np.diag(at.covariance)
    for k in range(variances.size):
        here = np.flatnonzero(group == k)
        if here.size:
            well = max(here.size - float(spread[here].sum()) / variances[k], 1e-3)
            new[k] = np.clip(float(np.sum(at.x[at.active[here]] ** 2)) / well, LEAST[k], MOST[k])
    new[SIDE] = max(new[SIDE], q.least_side * new[NUMBERS])
    return new


def influence(q: Quadratic, at: Mode, places: np.ndarray) -> np.ndarray:
    """(B, k) what each block moves the estimates at `places` (positions among the active ones) by.

    Eq. 11 of docs/mathematics/default-route.md.
    """
    left = q.slope[:, at.active] - q.gram[:, at.active][:, :, at.active] @ at.x[at.active]
    return left @ at.covariance[:, places]


def robust_covariance(q: Quadratic, at: Mode, places: np.ndarray) -> np.ndarray:
    """Sandwich covariance (k, k) of the estimates at `places` from the blocks' scores.

    Eq. 11 of docs/mathematics/default-route.md.
    """
    own = influence(q, at, places)
    return own.T @ own * len(own) / (len(own) - 1)


def inflation(q: Quadratic, at: Mode, places: np.ndarray) -> float:
    """How much more the estimates scatter between blocks than the likelihood says, at least one.

    Eq. 11 of docs/mathematics/default-route.md.
    """
    model = at.covariance[np.ix_(places, places)]
    ratio = lstsq(model, finite(robust_covariance(q, at, places)))
    return float(max(1.0, np.trace(ratio) / places.size))


def by_record(q: Quadratic, variances: np.ndarray, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sizes (R, k) and standard errors of parameters that each record has of its own; the discrepancy is shared.

    Both are zero of a parameter that no record shows.
    """
    count, k = int(q.record.max()) + 1, len(places)
    whole, pull = q.total
    held = np.flatnonzero(q.group >= 0)
    n = held.size + count * k
    matrix, slope = np.zeros((n, n)), np.zeros(n)
    matrix[: held.size, : held.size] = whole[np.ix_(held, held)] + np.diag(1.0 / variances[q.group[held]])
    slope[: held.size] = pull[held]
    for r in range(count):
        own, at = q.record == r, slice(held.size + r * k, held.size + (r + 1) * k)
        gram, part = q.gram[own].sum(axis=0), q.slope[own].sum(axis=0)
        matrix[at, at] = gram[np.ix_(places, places)] + 1e-12 * np.diag(np.diag(whole)[places])
        matrix[: held.size, at] = gram[np.ix_(held, places)]
        matrix[at, : held.size] = matrix[: held.size, at].T
        slope[at] = part[places]
    diagonal = np.diag(matrix)
    scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    outer = np.outer(scale, scale)
    covariance = pinv(matrix * outer, hermitian=True, rcond=1e-13) * outer
    z = covariance @ slope
    return z[held.size :].reshape(count, k), np.sqrt(np.diag(covariance)[held.size :]).reshape(count, k)
