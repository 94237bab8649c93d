"""Least-squares support vector regression on the model's equations, and its robust weighted form (paper 003)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from ..models.errors import BadInput
from . import factors
from .base import CannotFit, Fit, FitFailed, Method
from .filtered import DENSE
from .regression import SCHEMES, differences
from .svf_ls import BLOCK_TIME, best_corner, corner_frequencies, fit_filtered
from .svr.tuning import DOMAIN, TUNERS, Tuned, Tuner
from .tuning.space import Real

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model

FILTER = "svf"
TRAINING = 0.6
"""Share of each record, from its start, that is trained on while C is chosen (and altogether, as printed)."""
TUNED_ROWS = 5_000
"""Rows above which they are thinned while C is chosen."""
DIFFERENCED = 20
"""Rows of differences whose errors may be correlated."""


@dataclass(frozen=True)
class Samples:
    """Rows of one regression problem: x (n, p), y (n,), all equations below each other.

    `training` (n,) marks the first 60 % of each record; rows of equal `block` (n,) may have correlated errors.
    """

    x: np.ndarray
    y: np.ndarray
    training: np.ndarray
    block: np.ndarray

    def of(self, rows: np.ndarray | slice) -> Samples:
        """Some of the rows."""
        return Samples(self.x[rows], self.y[rows], self.training[rows], self.block[rows])


def stacked(parts: Sequence[Any], model: Model, length: int, physical: bool = False) -> Samples:
    """Rows of all parts (with `blocks(model)`), each equation divided by the spread of its residual.

    `length` is that of a block of rows; `physical` leaves the rows as they are.

    Raises
    ------
    FitFailed : no equation has finite, non-zero rows.
    """
    pieces = [list(part.blocks(model)) for part in parts]
    lefts = [np.concatenate([y for y, _ in piece]) for piece in pieces]
    rights = [np.concatenate([phi for _, phi in piece]) for piece in pieces]
    if not all(np.isfinite(rows).all() for rows in (*lefts, *rights)):
        raise FitFailed("the regression has no finite, non-zero columns")
    scale = np.ones(lefts[0].shape[1]) if physical else equation_scales(np.concatenate(lefts), np.concatenate(rights))
    used = np.flatnonzero(np.isfinite(scale) & np.any([phi.any(axis=(0, 2)) for phi in rights], axis=0))
    if not used.size:
        raise FitFailed("the regression has no finite, non-zero columns")
    found, blocks = [], 0
    for left, right in zip(lefts, rights, strict=True):
        place = np.arange(len(left))
        training = np.repeat(place < TRAINING * len(left), used.size)
        block = np.repeat(blocks + place // length, used.size)
        blocks += len(left) // length + 1
        x = (right[:, used] / scale[used, None]).reshape(-1, right.shape[2])
        found.append((x, (left[:, used] / scale[used]).ravel(), training, block))
    return Samples(*(np.concatenate(column) for column in zip(*found, strict=True)))


def equation_scales(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Spread (k,) of each equation's residual, robust, from rows left (n, k) and right (n, k, p) by least squares.

    At least 1e-9 of the left side; inf for an equation that is zero throughout.
    """
    k, p = right.shape[1:]
    spread = np.sqrt(np.mean(left**2, axis=0))
    spread = np.where(spread > 0.0, spread, np.inf)
    if k == 1:
        return spread
    rows = np.column_stack([(right / spread[:, None]).reshape(-1, p), (left / spread).ravel()])
    solution = factors.solve(factors.fold(factors.empty(p), rows))
    error = left - right @ solution.x
    return np.maximum(1.4826 * np.median(np.abs(error), axis=0), 1e-9 * spread)


class Regression(NamedTuple):
    """A fitted regressor and what was found on the way."""

    coefficients: np.ndarray
    covariance: np.ndarray
    regressor: Any
    tuned: Tuned


Build = Callable[..., Any]
"""(C, rough=False) -> regressor; `rough` while C is chosen."""


def regress(samples: Samples, build: Build, c: float | None, tune: Tuner, whole: bool) -> Regression:
    """C by validation if it is None, then the fit to all rows, or (not `whole`) to the training rows.

    Columns are scaled to unit root mean square inside the regressor where it standardises; those that are zero, which
    no row says anything about, get zero and infinite variance.
    """
    used = np.flatnonzero(np.any(samples.x, axis=0))
    rows = Samples(samples.x[:, used], samples.y, samples.training, samples.block)
    tuned = Tuned(c, np.nan, 0) if c is not None else tune(_validation(rows, build), *DOMAIN)
    rows = rows if whole else rows.of(rows.training)
    regressor = build(tuned.value).fit(rows.x, rows.y)
    p = samples.x.shape[1]
    coefficients, covariance = np.zeros(p), np.diag(np.full(p, np.inf))
    coefficients[used] = regressor.coef_
    covariance[np.ix_(used, used)] = _sandwich(rows, regressor)
    return Regression(coefficients, covariance, regressor, tuned)


def _validation(samples: Samples, build: Build) -> Callable[[float], float]:
    """Objective for a tuner: root mean square error on the rows that are not trained on."""
    stride = max(1, -(-len(samples.y) // TUNED_ROWS))
    thin = samples.of(slice(None, None, stride))
    train, test = thin.of(thin.training), thin.of(~thin.training)

    def error(c: float) -> float:
        try:
            fitted = build(c, rough=True).fit(train.x, train.y)
        except (ValueError, np.linalg.LinAlgError):
            return np.inf
        return float(np.sqrt(np.mean((test.y - fitted.predict(test.x)) ** 2)))

    return error


def _sandwich(rows: Samples, regressor: Any) -> np.ndarray:
    """Covariance (p, p) of the coefficients from scores summed over blocks of rows."""
    weights = getattr(regressor, "weights_", None)
    weights = np.ones(len(rows.y)) if weights is None else weights
    middle = weights @ rows.x / weights.sum() if regressor.fit_intercept else 0.0
    x = rows.x - middle
    error = rows.y - rows.x @ regressor.coef_ - regressor.intercept_
    scale = np.maximum(np.sqrt(np.mean(x**2, axis=0)), 1e-300)
    x = x / scale
    # d(w e)/d e of the adaptive weights is left at w: a standard error that is somewhat large for them
    bread = np.linalg.pinv((x * weights[:, None]).T @ x, rcond=1e-14, hermitian=True)
    labels, place = np.unique(rows.block, return_inverse=True)
    scores = np.zeros((len(labels), x.shape[1]))
    np.add.at(scores, place, x * (weights * error)[:, None])
    few = len(labels) / max(len(labels) - x.shape[1], 1)
    return bread @ (scores.T @ scores * few) @ bread / np.outer(scale, scale)


class LsSvr(Method):
    """Least-squares support vector regression with a linear kernel on the model's equations.

    Parameters
    ----------
    C : regularisation constant; None chooses it from 1e-2 .. 1e10 by the error on the last 40 % of each record.
    scheme : 'svf' (state-variable filter, its corner frequency chosen as in `svf-ls`), or a difference scheme of
        `regression` ('forward', 'midpoint', 'heading-difference').
    tuner : 'grid' (25 values), or a function of (objective, low, high) that returns `svr.tuning.Tuned`.
    variant : 'corrected' standardises the regressors, has no intercept (eq 29 has none) and fits all rows once C is
        chosen; 'as_printed' regularises in SI units, with intercept, and fits the first 60 % only.
    """

    name = "ls-svr"
    title = "least-squares support vector regression, linear kernel (paper 003)"
    variants = ("corrected", "as_printed")
    search_space: ClassVar = {"C": Real(1e-2, 1e10, log=True)}

    def __init__(
        self, C: float | None = None, scheme: str = FILTER, tuner: str | Tuner = "grid", variant: str = "corrected"
    ) -> None:
        self.C, self.scheme, self.tuner, self.variant = C, scheme, tuner, variant

    def check_options(self) -> None:
        super().check_options()
        check_svr_options(self.C, self.tuner)
        if self.scheme != FILTER and self.scheme not in SCHEMES:
            raise BadInput(f"unknown scheme {self.scheme!r}", hint=f"known: {FILTER}, {', '.join(SCHEMES)}")

    def regressor(self, c: float, rough: bool = False) -> Any:
        """The scikit-learn regressor at a value of C; `rough` while C is chosen."""
        from .svr.estimators import LSSVR

        corrected = self.variant == "corrected"
        return LSSVR(C=c, standardise=corrected, fit_intercept=not corrected)

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        samples, extra = self._samples(records, model)
        return fit_of(samples, self.regressor, self.C, self.tuner, self.variant == "corrected", extra)

    def _samples(self, records: Sequence[Record], model: Model) -> tuple[Samples, dict[str, Any]]:
        physical = self.variant == "as_printed"
        if self.scheme != FILTER:
            return stacked(differences(records, model, self.scheme), model, DIFFERENCED, physical), {}
        omega = best_corner(records, model, corner_frequencies(records).tolist()).omega
        rows, _ = fit_filtered(records, model, omega)
        return stacked(rows, model, int(BLOCK_TIME / DENSE), physical), {"omega_rad_s": omega}


def check_svr_options(c: float | None, tuner: str | Tuner) -> None:
    """Refuse an impossible C or an unknown tuner.

    Raises
    ------
    BadInput : naming the option.
    """
    if c is not None and not c > 0.0:
        raise BadInput(f"C is {c!r}, a positive number is needed")
    if not callable(tuner) and tuner not in TUNERS:
        raise BadInput(f"unknown tuner {tuner!r}", hint=f"known: {', '.join(TUNERS)}")


def fit_of(
    samples: Samples,
    build: Build,
    c: float | None,
    tuner: str | Tuner,
    whole: bool,
    extra: dict[str, Any],
) -> Fit:
    """The regression of `samples` as a method's result."""
    if len(samples.y) <= samples.x.shape[1] or samples.training.all() or not samples.training.any():
        raise CannotFit(f"{len(samples.y)} usable regression rows for {samples.x.shape[1]} coefficients")
    tune = tuner if callable(tuner) else TUNERS[tuner]
    found = regress(samples, build, c, tune, whole)
    weights = getattr(found.regressor, "weights_", None)
    dropped = {} if weights is None else {"outliers": float(np.mean(weights == 0.0))}
    limit = getattr(found.regressor, "max_iter", None)
    settled = limit is None or not whole or found.regressor.n_iter_ < limit
    return Fit(
        found.coefficients,
        found.covariance,
        converged=bool(settled),
        message="" if settled else "the weights have not settled",
        n_iterations=int(getattr(found.regressor, "n_iter_", 1)),
        extra={**extra, "C": found.tuned.value, "evaluations": found.tuned.evaluations, **dropped},
    )
