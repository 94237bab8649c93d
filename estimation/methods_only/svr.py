"""Least-squares support vector regression (paper 003, eq 21-28, corrected), plain or robust, for scikit-learn.

    minimise |w|^2/2 + C/2 sum_i v_i e_i^2,   e_i = y_i - w phi(x_i) - b

With a linear kernel this is a ridge problem in d + 1 unknowns, solved here by QR: exactly the solution of the dual, at
a cost of d^2 n instead of n^3, and with all digits even where 1/C is below rounding in the dual.  Other kernels use the
dual, in the memory of one n by n matrix.
"""

from __future__ import annotations

from numbers import Integral, Real
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from sklearn.base import BaseEstimator, RegressorMixin
from sklearn.utils._param_validation import Interval, StrOptions
from sklearn.utils.validation import check_is_fitted, validate_data

from ..numerics import factors

Array = NDArray[np.float64]
ROWS = 64
"""Rows of a kernel matrix that are computed at a time; with 10,000 columns they fit in a processor's cache."""
PREDICTED = 4096
"""Rows predicted at a time with a kernel that is not linear."""
RULES = {None: None, "corrected": "residual", "as_printed": "signal"}
"""Weighting -> what the rule of outliers is applied to."""


class LSSVR(RegressorMixin, BaseEstimator):
    """Least-squares support vector regression (Suykens & Vandewalle 1999; paper 003, eq 21-28).

    With `weighting` it is the robust RW-LSSVR of paper 003: outliers are removed by the MAD rule, errors weighted
    adaptively.  'corrected': the rule is applied to residuals until the rows that it keeps no longer change, then the
    weights 2/(1 + exp(|e|/T')) are iterated to convergence.  'as_printed': the rule on the targets themselves, which
    removes no outlier from a sinusoid, and one step of weights in the signed errors, which leaves out half the rows.

    Parameters
    ----------
    C : > 0, weight of the errors relative to the size of the coefficients.
    kernel : 'linear' (solved in the primal by QR: linear in the samples) or 'rbf' (dual, n^2 memory).
    gamma : of 'rbf'; > 0, or 'scale' for 1/(d var(X)).
    fit_intercept : whether there is an intercept, which is not penalised.
    standardise : divide every column by its standard deviation first; otherwise the effect of the penalty depends on
        the units.  Coefficients are given for the original columns.
    weighting : None, 'corrected' or 'as_printed'.
    outliers : 'residual', 'signal' (on the targets) or None; 'weighting' takes the weighting's own.
    threshold : of the rule, in robust standard deviations.
    max_iter, tol : of the weights; tol on the relative change of the fitted values.

    Attributes
    ----------
    coef_ (d,) for the linear kernel, intercept_, dual_coef_ (n,) = C v e, weights_ (n,), zero for outliers, n_iter_,
    n_features_in_.
    """

    _parameter_constraints: dict[str, list] = {  # noqa: RUF012  (as scikit-learn declares it)
        "C": [Interval(Real, 0, None, closed="neither")],
        "kernel": [StrOptions({"linear", "rbf"})],
        "gamma": [StrOptions({"scale"}), Interval(Real, 0, None, closed="neither")],
        "fit_intercept": ["boolean"],
        "standardise": ["boolean"],
        "weighting": [StrOptions({"corrected", "as_printed"}), None],
        "outliers": [StrOptions({"weighting", "residual", "signal"}), None],
        "threshold": [Interval(Real, 0, None, closed="neither")],
        "max_iter": [Interval(Integral, 1, None, closed="left")],
        "tol": [Interval(Real, 0, None, closed="left")],
    }

    def __init__(
        self,
        C: float = 1.0,
        *,
        kernel: str = "linear",
        gamma: float | str = "scale",
        fit_intercept: bool = True,
        standardise: bool = False,
        weighting: str | None = None,
        outliers: str | None = "weighting",
        threshold: float = 3.0,
        max_iter: int = 100,
        tol: float = 1e-6,
    ) -> None:
        self.C, self.kernel, self.gamma = C, kernel, gamma
        self.fit_intercept, self.standardise = fit_intercept, standardise
        self.weighting, self.outliers, self.threshold = weighting, outliers, threshold
        self.max_iter, self.tol = max_iter, tol

    def fit(self, X: Any, y: Any) -> Self:
        """Fit to X (n, d), y (n,); raises ValueError on bad input."""
        self._validate_params()
        X, y = validate_data(self, X, y, dtype=np.float64, y_numeric=True)
        y = np.asarray(y, np.float64)
        self._prepare(X)
        kept = self._kept(X, y)
        weights, self.n_iter_ = np.ones(int(kept.sum())), 1
        if self.weighting is not None:
            weights = self._reweight(X[kept], y[kept])
        self.weights_, alpha = np.zeros(len(y)), np.zeros(len(y))
        self.weights_[kept], alpha[kept] = weights, self.dual_coef_
        self.dual_coef_ = alpha
        return self

    def _prepare(self, X: Array) -> None:
        """Column scales and kernel width."""
        self._scale = np.ones(X.shape[1])
        if self.standardise:
            middle = X.mean(axis=0) if self.fit_intercept else 0.0
            spread = np.sqrt(np.mean((X - middle) ** 2, axis=0))
            self._scale = np.where(spread > 0.0, spread, 1.0)
        if not isinstance(self.gamma, str):
            self._gamma = float(self.gamma)
        elif self.kernel != "linear":
            square = float(np.var(X / self._scale))
            self._gamma = 1.0 / (X.shape[1] * square) if square > 0.0 else 1.0

    def _kept(self, X: Array, y: Array) -> NDArray[np.bool_]:
        """Mask (n,) of the rows that are no outliers; the unweighted fit to them is left in the attributes."""
        rule = RULES[self.weighting] if self.outliers == "weighting" else self.outliers
        kept = within_mad(y, self.threshold) if rule == "signal" else np.ones(len(y), bool)
        self._solve(X[kept], y[kept], None)
        for _ in range(self.max_iter if rule == "residual" else 0):
            now = within_mad(y - self._predicted(X), self.threshold)
            if np.array_equal(now, kept) or now.sum() <= X.shape[1] + 1:
                break
            kept = now
            self._solve(X[kept], y[kept], None)
        return kept

    def _reweight(self, X: Array, y: Array) -> Array:
        """Weights (n,) of the last of the weighted fits, which is left in the attributes."""
        printed = self.weighting == "as_printed"
        fitted, most = self._predicted(X), 1 if printed else self.max_iter
        for self.n_iter_ in range(1, most + 1):
            weights = adaptive_weights(y - fitted, signed=printed)
            if not weights.any():
                raise ValueError("the weights as printed are zero everywhere")
            self._solve(X, y, weights)
            before, fitted = fitted, self._predicted(X)
            if np.linalg.norm(fitted - before) <= self.tol * np.linalg.norm(fitted):
                break
        return weights

    def _solve(self, X: Array, y: Array, weights: Array | None) -> None:
        """Coefficients at given weights (n,); rows of weight zero are left out."""
        if weights is not None and not (weights > 0.0).all():
            kept = weights > 0.0
            self._solve(X[kept], y[kept], weights[kept])
            alpha = np.zeros(len(y))
            alpha[kept] = self.dual_coef_
            self.dual_coef_ = alpha
            return
        if self.kernel == "linear":
            coef, self.intercept_ = primal(X / self._scale, y, self.C, weights, self.fit_intercept)
            self.coef_ = coef / self._scale
            self.dual_coef_ = self.C * (y - X @ self.coef_ - self.intercept_) * (1.0 if weights is None else weights)
            return
        self._rows = X / self._scale
        self.dual_coef_, self.intercept_ = dual(self._gram(self._rows, True), y, self.C, weights, self.fit_intercept)
        self._alpha = self.dual_coef_

    def _gram(self, rows: Array, upper: bool = False) -> Array:
        """Kernel values (m, n) of scaled rows (m, d) and the training rows."""
        return kernel_matrix(self.kernel, rows, self._rows, self._gamma, upper)

    def predict(self, X: Any) -> Array:
        """Predictions (n,) at rows X (n, d)."""
        check_is_fitted(self)
        return self._predicted(np.asarray(validate_data(self, X, dtype=np.float64, reset=False), np.float64))

    def _predicted(self, X: Array) -> Array:
        if self.kernel == "linear":
            return X @ self.coef_ + self.intercept_
        found = np.empty(len(X))
        for start in range(0, len(X), PREDICTED):
            cut = slice(start, start + PREDICTED)
            found[cut] = self._gram(X[cut] / self._scale) @ self._alpha + self.intercept_
        return found


def primal(x: Array, y: Array, c: float, weights: Array | None = None, intercept: bool = True) -> tuple[Array, float]:
    """w (d,) and intercept of a linear kernel: ridge with unpenalised intercept by blocked QR.

    x (n, d), y (n,), weights (n,) >= 0.
    """
    d = x.shape[1]
    middle, level = np.zeros(d), 0.0
    if intercept:
        share = np.full(len(y), 1.0 / len(y)) if weights is None else weights / weights.sum()
        middle, level = share @ x, float(share @ y)
    factor = np.column_stack([np.eye(d) / np.sqrt(c), np.zeros(d)])
    for start in range(0, len(y), factors.BLOCK):
        cut = slice(start, start + factors.BLOCK)
        rows = np.column_stack([x[cut] - middle, y[cut] - level])
        if weights is not None:
            rows *= np.sqrt(weights[cut])[:, None]
        factor = factors.fold(factor, rows)
    coef = np.asarray(np.linalg.solve(factor[:d, :d], factor[:d, d]), float)
    return coef, level - float(middle @ coef)


def dual(gram: Array, y: Array, c: float, weights: Array | None = None, intercept: bool = True) -> tuple[Array, float]:
    """Multipliers alpha (n,) = C v e, and intercept, of any kernel: eq 25 by Cholesky with two right-hand sides.

    Of the matrix `gram` (n, n) the upper triangle counts, and is overwritten.
    """
    from scipy.linalg import cho_factor, cho_solve

    gram[np.diag_indices_from(gram)] += 1.0 / (c if weights is None else c * weights)
    lower = cho_factor(gram.T, lower=True, overwrite_a=True, check_finite=False)
    sides = np.asfortranarray(np.column_stack([np.ones(len(y)), y]))
    ones, values = np.asarray(cho_solve(lower, sides, overwrite_b=True, check_finite=False)).T
    level = float(values.sum() / ones.sum()) if intercept else 0.0
    return values - level * ones, level


def kernel_matrix(kind: str, a: Array, b: Array, gamma: float, upper: bool = False) -> Array:
    """Kernel values (n, m) of rows a (n, d) and b (m, d): 'linear' or 'rbf' exp(-gamma |a-b|^2).

    Needs no more memory than the matrix itself.  With `upper` what lies below the diagonal is not set, as `dual` takes
    it.
    """
    gram, squares = np.empty((len(a), len(b))), np.einsum("ij,ij->i", b, b)
    for start in range(0, len(a), ROWS):
        rows, columns = a[start : start + ROWS], slice(start if upper else 0, None)
        block = gram[start : start + ROWS, columns]
        np.matmul(rows, b[columns].T, out=block)
        if kind == "rbf":
            block *= -2.0
            block += np.einsum("ij,ij->i", rows, rows)[:, None]
            block += squares[columns]
            np.maximum(block, 0.0, out=block)
            block *= -gamma
            np.exp(block, out=block)
    return gram


def within_mad(values: Array, threshold: float = 3.0) -> NDArray[np.bool_]:
    """True (n,) where a value lies within `threshold` robust standard deviations (1.4826 MAD) of the median (eq 21)."""
    middle = np.median(values)
    distance = np.abs(values - middle)
    return distance <= threshold * 1.4826 * np.median(distance)


def pseudo_median(values: Array) -> float:
    """T' of eq 27: the mean of the medians of the second and the third quarter of the sorted values (n,)."""
    ordered = np.sort(values)
    n = len(ordered)
    second, third = ordered[n // 4 : n // 2], ordered[n // 2 : 3 * n // 4]
    if not len(second) or not len(third):
        return float(np.median(ordered))
    return float(np.mean([np.median(second), np.median(third)]))


def adaptive_weights(errors: Array, signed: bool = False) -> Array:
    """w = 2/(1 + exp(|e|/T')), in (0, 1], T' from the sorted |e|; `signed` as printed in eq 26-27, in [0, 2].

    Errors that are practically zero have weight 1.
    """
    from scipy.special import expit

    used = errors if signed else np.abs(errors)
    scale = pseudo_median(used)
    if abs(scale) <= 1e-300:
        return np.ones(len(errors))
    with np.errstate(over="ignore"):
        return 2.0 * expit(-used / scale)
