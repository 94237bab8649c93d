"""Least-squares support vector regression on the model's equations, plain and robust (paper 003)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ..datasets.record import Record
from ..estimation.methods_only.regression.weighted import mad
from ..estimation.methods_only.tuning.space import Real
from ..estimation.numerics import factors
from ..estimation.regression.filtered import BLOCK_TIME, DENSE, best_corner
from ..estimation.regression.samples import RegressionSamples
from ..estimation.regression.schemes import SCHEMES, regression_samples
from ..estimation.results.fit import Fit
from ..models.errors import CannotFit, FitFailed
from ..models.linear_algebra import pinv
from ..models.model import Model
from .base import Method
from .options import POSITIVE, option, words

DOMAIN = (1e-2, 1e10)
"""Search domain of C (paper 003, Table 3)."""
POINTS = 25
CYCLES = 30
"""Of the colony of paper 003, Table 3."""

Objective = Callable[[float], float]
"""C -> validation error, to be minimised; inf where the fit fails."""


class TunedConstant(NamedTuple):
    """The best value found, its error, and how often the objective was called."""

    value: float
    error: float
    evaluations: int


Tuner = Callable[[Objective, float, float], TunedConstant]
"""Searches [low, high] on a logarithmic scale."""


def grid(objective: Objective, low: float = DOMAIN[0], high: float = DOMAIN[1]) -> TunedConstant:
    """The best of POINTS values in geometric progression; among equal ones the smallest."""
    values = np.geomspace(low, high, POINTS)
    errors = np.array([objective(float(value)) for value in values])
    errors = np.where(np.isfinite(errors), errors, np.inf)
    best = int(np.argmin(errors))
    return TunedConstant(float(values[best]), float(errors[best]), POINTS)


def colony(
    objective: Objective, low: float = DOMAIN[0], high: float = DOMAIN[1], cycles: int = CYCLES
) -> TunedConstant:
    """The best that the artificial bee colony of paper 003 finds (Table 3): 30 sources, and 60 moves in every cycle."""
    import optuna

    from ..estimation.methods_only.tuning.abc import PAPER_003, ABCSampler
    from ..estimation.methods_only.tuning.tune import quiet

    most = PAPER_003["n_sources"] + cycles * (PAPER_003["n_sources"] + PAPER_003["n_onlookers"])
    with quiet():
        study = optuna.create_study(sampler=ABCSampler(**PAPER_003, seed=0))
        study.optimize(lambda trial: objective(trial.suggest_float("C", low, high, log=True)), n_trials=most)
    return TunedConstant(float(study.best_params["C"]), float(study.best_value), most)


TUNERS: dict[str, Tuner] = {"grid": grid, "abc": colony}


FILTER = "svf"
"""Name of the scheme that takes state-variable filtered rows."""
TRAINING = 0.6
"""Share of each record, from its start, that is trained on while C is chosen (and for the whole fit, as printed)."""
TUNED_ROWS = 5_000
"""Rows above which they are thinned while C is chosen."""
DIFFERENCED = 20
"""Rows of differences whose errors may be correlated."""


@dataclass(frozen=True)
class TrainingRows:
    """Rows of one regression problem: x (n, p), y (n,), all equations below each other.

    `training` (n,) marks the first 60 % of each record; rows of equal `block` (n,) may have correlated errors.
    """

    x: np.ndarray
    y: np.ndarray
    training: np.ndarray
    block: np.ndarray

    def of(self, rows: np.ndarray | slice) -> TrainingRows:
        """Some of the rows."""
        return TrainingRows(self.x[rows], self.y[rows], self.training[rows], self.block[rows])


def stacked_rows(
    parts: Sequence[RegressionSamples], model: Model, block_length: int, physical: bool = False
) -> TrainingRows:
    """Rows of all parts, each equation divided by the scale of its residual.

    `block_length` is the number of rows in a block of correlated errors; `physical` leaves the rows as they are.
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
        block = np.repeat(blocks + place // block_length, used.size)
        blocks += len(left) // block_length + 1
        x = (right[:, used] / scale[used, None]).reshape(-1, right.shape[2])
        found.append((x, (left[:, used] / scale[used]).ravel(), training, block))
    return TrainingRows(*(np.concatenate(column) for column in zip(*found, strict=True)))


def equation_scales(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Robust scale (k,) of each equation's least-squares residual, from rows left (n, k) and right (n, k, p).

    At least 1e-9 of the left side; inf for an equation that is zero throughout.
    """
    k, p = right.shape[1:]
    rms = np.sqrt(np.mean(left**2, axis=0))
    rms = np.where(rms > 0.0, rms, np.inf)
    if k == 1:
        return rms
    rows = np.column_stack([(right / rms[:, None]).reshape(-1, p), (left / rms).ravel()])
    solution = factors.solve(factors.fold(factors.empty(p), rows))
    return np.maximum(mad(left - right @ solution.x), 1e-9 * rms)


def fit_svr(
    rows: TrainingRows, weighted: bool, printed: bool, c: float | None, tuner: str | Tuner, extra: dict[str, Any]
) -> Fit:
    """The regression of the rows as a method's result.

    Coefficients of columns that are zero, about which the rows have no information, get zero and infinite variance.

    Parameters
    ----------
    weighted : whether outliers are removed and errors weighted adaptively.
    printed : with intercept, columns as they are, and the training rows alone once C is chosen; else standardised
        columns without intercept and all rows.
    c : regularisation constant; None chooses it by validation with `tuner`.
    extra : facts to add to `Fit.extra`.
    """
    from ..estimation.methods_only.svr import LSSVR

    weighting = ("as_printed" if printed else "corrected") if weighted else None
    build = partial(LSSVR, standardise=not printed, fit_intercept=printed, weighting=weighting)
    p, used = rows.x.shape[1], np.flatnonzero(np.any(rows.x, axis=0))
    if len(rows.y) <= p or rows.training.all() or not rows.training.any():
        raise CannotFit(f"{len(rows.y)} usable regression rows for {p} coefficients")
    rows = TrainingRows(rows.x[:, used], rows.y, rows.training, rows.block)
    tune = TUNERS[tuner] if isinstance(tuner, str) else tuner
    tuned = TunedConstant(c, np.nan, 0) if c is not None else tune(_validation(rows, build), *DOMAIN)
    rows = rows.of(rows.training) if printed else rows
    regressor = build(C=tuned.value).fit(rows.x, rows.y)
    coefficients, covariance = np.zeros(p), np.diag(np.full(p, np.inf))
    coefficients[used] = regressor.coef_
    covariance[np.ix_(used, used)] = _sandwich(rows, regressor)
    outliers = {} if regressor.weighting is None else {"outliers": float(np.mean(regressor.weights_ == 0.0))}
    converged = regressor.weighting is None or printed or regressor.n_iter_ < regressor.max_iter
    return Fit(
        coefficients,
        covariance,
        converged=converged,
        message="" if converged else "the weights have not converged",
        n_iterations=regressor.n_iter_,
        extra={**extra, "C": tuned.value, "evaluations": tuned.evaluations, **outliers},
    )


def _validation(rows: TrainingRows, build: Callable[..., Any]) -> Objective:
    """Objective for a tuner: root mean square error on the rows that are not trained on, weights iterated roughly."""
    stride = max(1, -(-len(rows.y) // TUNED_ROWS))
    thin = rows.of(slice(None, None, stride))
    train, test = thin.of(thin.training), thin.of(~thin.training)

    def error(c: float) -> float:
        try:
            fitted = build(C=c, max_iter=10, tol=1e-3).fit(train.x, train.y)
        except (ValueError, np.linalg.LinAlgError):
            return np.inf
        return float(np.sqrt(np.mean((test.y - fitted.predict(test.x)) ** 2)))

    return error


def _sandwich(rows: TrainingRows, regressor: Any) -> np.ndarray:
    """Covariance (p, p) of the coefficients from scores summed over blocks of rows."""
    weights = regressor.weights_
    middle = weights @ rows.x / weights.sum() if regressor.fit_intercept else 0.0
    x = rows.x - middle
    error = rows.y - rows.x @ regressor.coef_ - regressor.intercept_
    scale = np.maximum(np.sqrt(np.mean(x**2, axis=0)), 1e-300)
    x = x / scale
    # d(w e)/d e of the adaptive weights is replaced by w: their standard errors are somewhat too large
    bread = pinv((x * weights[:, None]).T @ x, rcond=1e-14, hermitian=True)
    labels, place = np.unique(rows.block, return_inverse=True)
    scores = np.zeros((len(labels), x.shape[1]))
    np.add.at(scores, place, x * (weights * error)[:, None])
    small_sample = len(labels) / max(len(labels) - x.shape[1], 1)
    return bread @ (scores.T @ scores * small_sample) @ bread / np.outer(scale, scale)


def _check_tuner(name: str, value: Any) -> None:
    if not callable(value):
        words("tuner", TUNERS)(name, value)


CONSTANT: Any = option(
    None,
    "regularisation constant; None chooses it from 1e-2 .. 1e10 by the error on the last 40 % of each record",
    POSITIVE,
    Real(1e-2, 1e10, log=True),
)
TUNER: Any = option(
    "grid",
    "'grid' (25 values), or a function of (objective, low, high) that returns `helmbench.methods.ls_svr.TunedConstant`",
    _check_tuner,
)


class SvrMethod(Method):
    """Base of both regressions on the model's equations; `weighted` ones remove outliers and weight errors."""

    variants = ("corrected", "as_printed")
    weighted: ClassVar[bool]
    C: float | None = CONSTANT
    scheme: str = option(
        FILTER,
        "'svf' (state-variable filter, its corner frequency chosen as in `svf-ls`), or a scheme of "
        "`helmbench.estimation.regression.schemes`",
        words("difference scheme", (FILTER, *SCHEMES)),
    )
    tuner: str | Tuner = TUNER

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        if self.scheme == FILTER:
            found = best_corner(records, model)
            parts, block, extra = found.rows, int(BLOCK_TIME / DENSE), {"omega_rad_s": found.omega}
        else:
            parts, block, extra = regression_samples(records, model, self.scheme), DIFFERENCED, {}
        printed = self.variant == "as_printed"
        rows = stacked_rows(parts, model, block, physical=printed)
        return fit_svr(rows, self.weighted, printed, self.C, self.tuner, extra)


class LsSvr(SvrMethod):
    """Least-squares support vector regression with a linear kernel on the model's equations."""

    name = "ls-svr"
    title = "least-squares support vector regression, linear kernel (paper 003)"
    weighted = False
    variant: str = option(
        "corrected",
        "'corrected' standardises the regressors, has no intercept (eq 29 has none) and fits all rows once C is "
        "chosen; 'as_printed' regularises in SI units, with intercept, and fits the first 60 % only",
    )


class RwLsSvr(SvrMethod):
    """As `ls-svr`, with outliers removed by the MAD rule and adaptive weights on the errors."""

    name = "rw-ls-svr"
    title = "robust weighted LS-SVR: MAD rule and adaptive weights (paper 003)"
    weighted = True
    variant: str = option(
        "corrected",
        "'corrected' applies the rule to residuals and iterates weights in |e| to convergence; 'as_printed' applies it "
        "to the highest derivative itself and weights once by signed errors.  Otherwise as in `ls-svr`",
    )
