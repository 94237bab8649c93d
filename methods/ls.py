"""Batch least squares on difference equations (papers 000, 001 and 002 in their corrected form)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np

from ..models.errors import BadInput
from . import factors
from .base import Fit, FitFailed, Method
from .regression import SCHEMES, Differences, accelerations, differences
from .replay import replayed_covariance
from .tuning.space import Choice
from .zoh import common_step, exact_with_covariance

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model


class LeastSquares(NamedTuple):
    """Outcome of `least_squares`; the covariance is in the units of the coefficients."""

    coefficients: np.ndarray
    covariance: np.ndarray
    rank: int
    condition: float
    residual_sd: np.ndarray
    """(k,) standard deviation of each equation's residual; nan for an equation without unknowns."""
    left_rms: np.ndarray
    """(k,) root mean square of each equation's left side; nan likewise."""
    n: int
    """Rows in each equation."""
    half: np.ndarray
    """(p, rank), half half' being the covariance of what is determined, at full accuracy."""
    scores: np.ndarray
    """(rank,) with coefficients = half @ scores, in units of the noise."""
    null: np.ndarray
    """(p, p - rank): directions that are not determined."""

    def significant(self, least: float = 3.0) -> np.ndarray:
        """Coefficients (p,) along the directions that stand out of the noise by `least` standard deviations only."""
        if not np.any(self.half):  # a fit without any residual
            return self.coefficients
        return self.half @ np.where(np.abs(self.scores) > least, self.scores, 0.0)


def equation_factors(parts: Sequence[Differences], model: Model) -> tuple[np.ndarray, np.ndarray]:
    """Triangular factors (k, p + 1, p + 1) of [Phi | y] of each equation, and the number of rows (k,) in each."""
    k, p = accelerations(model), len(model.coordinates)
    found = [factors.empty(p) for _ in range(k)]
    count = 0
    for part in parts:
        for y, phi in part.blocks(model):
            count += len(y)
            found = [factors.fold(found[e], np.column_stack([phi[:, e], y[:, e]])) for e in range(k)]
    padded = [np.vstack([r, np.zeros((p + 1 - len(r), p + 1))]) for r in found]
    return np.array(padded), np.full(k, count)


def least_squares(equations: np.ndarray, counts: np.ndarray) -> LeastSquares:
    """Feasible generalised least squares over k equations that may share unknowns.

    Each equation is divided by the spread of its left side, and after a first solution by its residual's.  Columns
    are scaled inside; undetermined directions take the solution of minimum norm and infinite variance.

    Parameters
    ----------
    equations : (k, p + 1, p + 1) triangular factors of [Phi | y].
    counts : (k,) rows behind each factor.
    """
    p = equations.shape[2] - 1
    used = np.array([np.any(r[:, :p]) for r in equations])
    equations, counts = equations[used], counts[used]
    if not len(equations) or not np.isfinite(equations).all():
        raise FitFailed("the regression has no finite, non-zero columns")
    spread = np.linalg.norm(equations[:, :, p], axis=1) / np.sqrt(counts)
    weight = 1.0 / np.where(spread > 0.0, spread, 1.0)
    solution = factors.solve(np.vstack([w * r for w, r in zip(weight, equations, strict=True)]))
    sd = _residual_sd(equations, counts, solution)
    floor = 1e-14 * np.where(spread > 0.0, spread, 1.0)
    if len(equations) > 1:
        weight = 1.0 / np.maximum(sd, floor)
        solution = factors.solve(np.vstack([w * r for w, r in zip(weight, equations, strict=True)]))
        sd = _residual_sd(equations, counts, solution)
    noise = np.mean((sd * weight) ** 2)
    residual, left = np.full((2, used.size), np.nan)
    residual[used], left[used] = sd, spread
    return LeastSquares(
        solution.x,
        solution.covariance * noise,
        solution.rank,
        solution.condition,
        residual,
        left,
        int(counts.max()),
        solution.half * np.sqrt(noise),
        solution.scores / np.sqrt(noise) if noise > 0.0 else solution.scores,
        solution.null,
    )


def _residual_sd(equations: np.ndarray, counts: np.ndarray, solution: factors.Solution) -> np.ndarray:
    left = equations @ np.append(solution.x, -1.0)
    unknowns = np.array([np.any(r[:, :-1], axis=0).sum() for r in equations])
    free = np.maximum(counts - np.minimum(unknowns, solution.rank), 1)
    return np.sqrt((left**2).sum(axis=1) / free)


def fit_ls(records: Sequence[Record], model: Model, scheme: str) -> LeastSquares:
    """Least squares over records by a difference scheme; raises as `Ls`."""
    return least_squares(*equation_factors(differences(records, model, scheme), model))


INTEGRATED = "triple-integral"
"""How the schemes begin whose errors are correlated over the record."""


class Ls(Method):
    """Least squares on the model's difference equations, solved by orthogonal decomposition.

    Parameters
    ----------
    scheme : 'forward' (explicit Euler), 'midpoint', 'heading-difference' or 'triple-integral'; see `regression`.  Also
        'zoh': forward differences read back by the exact map for a held rudder (`zoh`), for response models.

    3-DOF models need surge, sway and yaw rate (or heading); response models yaw rate or heading.  Standard errors take
    the equations' errors as independent, for the integrated schemes as coloured sensor noise (`replay`).
    """

    name = "ls"
    title = "batch least squares on difference equations (QR)"
    search_space: ClassVar = {"scheme": Choice("forward", "midpoint")}

    def __init__(self, scheme: str = "forward") -> None:
        self.scheme = scheme

    def check_options(self) -> None:
        super().check_options()
        check_scheme(self.scheme, ("zoh",))

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        scheme = "forward" if self.scheme == "zoh" else self.scheme
        found = fit_ls(records, model, scheme)
        coefficients, covariance, p = found.coefficients, found.covariance, len(model.coordinates)
        if scheme.startswith(INTEGRATED) and found.rank == p:
            covariance = replayed_covariance(records, lambda noisier: fit_ls(noisier, model, scheme).coefficients)
        if self.scheme == "zoh":
            coefficients, covariance = exact_with_covariance(coefficients, covariance, model, common_step(records))
        return Fit(
            coefficients,
            covariance,
            message="" if found.rank == p else f"the records determine {found.rank} of {p} directions",
            extra={"rank": found.rank, "condition": found.condition, "residual_sd": found.residual_sd.tolist()},
        )


def check_scheme(scheme: str, more: Sequence[str] = ()) -> None:
    """Refuse a difference scheme that is neither one of `regression` nor one of `more`.

    Raises
    ------
    BadInput : naming the known ones.
    """
    if scheme not in (*SCHEMES, *more):
        raise BadInput(f"unknown difference scheme {scheme!r}", hint=f"known: {', '.join((*SCHEMES, *more))}")
