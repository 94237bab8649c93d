"""`LSSVR` and `RWLSSVR`: least-squares support vector regressors for scikit-learn pipelines and searches."""

from __future__ import annotations

from numbers import Integral, Real
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from sklearn.base import BaseEstimator, RegressorMixin
from sklearn.utils._param_validation import Interval, StrOptions
from sklearn.utils.validation import _check_sample_weight, check_is_fitted, validate_data

from . import solve

Array = NDArray[np.float64]
PREDICTED = 4096
"""Rows predicted at a time with a kernel that is not linear."""


class LSSVR(RegressorMixin, BaseEstimator):
    """Least-squares support vector regression (Suykens & Vandewalle 1999; paper 003, eq 23-28).

    Parameters
    ----------
    C : > 0, weight of the errors relative to the size of the coefficients.
    kernel : 'linear' (solved in the primal by QR: linear in the samples), 'rbf' or 'poly' (dual, n^2 memory).
    gamma : of 'rbf' and 'poly'; > 0, or 'scale' for 1/(d var(X)).
    degree, coef0 : of 'poly', (gamma x x' + coef0)^degree.
    fit_intercept : whether there is an intercept, which is not penalised.
    standardise : divide every column by its standard deviation first; otherwise the effect of the penalty depends on
        the units.  Coefficients are given for the original columns.

    Attributes
    ----------
    coef_ (d,) for the linear kernel, intercept_, dual_coef_ (n,) = C v e; n_features_in_.
    """

    _parameter_constraints: dict[str, list] = {  # noqa: RUF012  (as scikit-learn declares it)
        "C": [Interval(Real, 0, None, closed="neither")],
        "kernel": [StrOptions({"linear", "rbf", "poly"})],
        "gamma": [StrOptions({"scale"}), Interval(Real, 0, None, closed="neither")],
        "degree": [Interval(Integral, 1, None, closed="left")],
        "coef0": [Interval(Real, None, None, closed="neither")],
        "fit_intercept": ["boolean"],
        "standardise": ["boolean"],
    }

    def __init__(
        self,
        C: float = 1.0,
        *,
        kernel: str = "linear",
        gamma: float | str = "scale",
        degree: int = 3,
        coef0: float = 1.0,
        fit_intercept: bool = True,
        standardise: bool = False,
    ) -> None:
        self.C = C
        self.kernel = kernel
        self.gamma = gamma
        self.degree = degree
        self.coef0 = coef0
        self.fit_intercept = fit_intercept
        self.standardise = standardise

    def fit(self, X: Any, y: Any, sample_weight: Any = None) -> Self:
        """Fit to X (n, d), y (n,) with weights v (n,) >= 0 on the squared errors; raises ValueError on bad input."""
        self._validate_params()
        X, y = validate_data(self, X, y, dtype=np.float64, y_numeric=True)
        if sample_weight is not None:
            sample_weight = _check_sample_weight(sample_weight, X, dtype=np.float64)
            if (sample_weight < 0.0).any():
                raise ValueError("Negative values in data passed to `sample_weight`")
        self._prepare(X, sample_weight)
        self._solve(X, np.asarray(y, np.float64), sample_weight)
        return self

    def _prepare(self, X: Array, weights: Array | None = None) -> None:
        """Column scales and kernel width, from the rows of positive weight."""
        counted = X if weights is None else X[weights > 0.0]
        share = None if weights is None else weights[weights > 0.0]
        if not len(counted):
            raise ValueError("all sample weights are zero")
        self._scale = np.ones(X.shape[1])
        if self.standardise:
            middle = np.average(counted, axis=0, weights=share) if self.fit_intercept else np.zeros(X.shape[1])
            spread = np.sqrt(np.average((counted - middle) ** 2, axis=0, weights=share))
            self._scale = np.where(spread > 0.0, spread, 1.0)
        if not isinstance(self.gamma, str):
            self._gamma = float(self.gamma)
        elif self.kernel != "linear":
            scaled = counted / self._scale
            middle = np.average(scaled, axis=0, weights=share).mean()
            square = np.average((scaled - middle) ** 2, axis=0, weights=share).mean()
            self._gamma = 1.0 / (X.shape[1] * square) if square > 0.0 else 1.0

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
            scaled = X / self._scale if self.standardise else X
            coef, self.intercept_ = solve.primal(scaled, y, self.C, weights, self.fit_intercept)
            self.coef_ = coef / self._scale
            self.dual_coef_ = self.C * (y - X @ self.coef_ - self.intercept_) * (1.0 if weights is None else weights)
            return
        self._rows = X / self._scale
        gram = solve.kernel_triangle(self.kernel, self._rows, self._gamma, self.degree, self.coef0)
        self.dual_coef_, self.intercept_ = solve.dual(gram, y, self.C, weights, self.fit_intercept)
        self._alpha = self.dual_coef_

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
            rows = X[cut] / self._scale
            gram = solve.kernel_matrix(self.kernel, rows, self._rows, self._gamma, self.degree, self.coef0)
            found[cut] = gram @ self._alpha + self.intercept_
        return found


class RWLSSVR(LSSVR):
    """Robust weighted LS-SVR (paper 003, eq 21-28): outliers removed by the MAD rule, errors weighted adaptively.

    Corrected: the rule is applied to residuals until the rows that it keeps no longer change, then the weights
    2/(1 + exp(|e|/T')) are iterated to convergence.  `variant='as_printed'`: the rule on the targets themselves, which
    removes no outlier from a sinusoid, and one step of weights in the signed errors, which leaves out half the rows.

    Parameters
    ----------
    C, kernel, gamma, degree, coef0, fit_intercept, standardise : as in `LSSVR`.
    outliers : 'residual', 'signal' (on the targets) or None; 'variant' takes the variant's own.
    threshold : of the rule, in robust standard deviations.
    variant : 'corrected' or 'as_printed'.
    max_iter, tol : of the weights; tol on the relative change of the fitted values.

    Attributes
    ----------
    As `LSSVR`, and weights_ (n,), zero for outliers, and n_iter_.
    """

    _parameter_constraints: dict[str, list] = {  # noqa: RUF012
        **LSSVR._parameter_constraints,
        "outliers": [StrOptions({"variant", "residual", "signal"}), None],
        "threshold": [Interval(Real, 0, None, closed="neither")],
        "variant": [StrOptions({"corrected", "as_printed"})],
        "max_iter": [Interval(Integral, 1, None, closed="left")],
        "tol": [Interval(Real, 0, None, closed="left")],
    }

    def __init__(
        self,
        C: float = 1.0,
        *,
        kernel: str = "linear",
        gamma: float | str = "scale",
        degree: int = 3,
        coef0: float = 1.0,
        fit_intercept: bool = True,
        standardise: bool = False,
        outliers: str | None = "variant",
        threshold: float = 3.0,
        variant: str = "corrected",
        max_iter: int = 100,
        tol: float = 1e-6,
    ) -> None:
        super().__init__(
            C=C,
            kernel=kernel,
            gamma=gamma,
            degree=degree,
            coef0=coef0,
            fit_intercept=fit_intercept,
            standardise=standardise,
        )
        self.outliers = outliers
        self.threshold = threshold
        self.variant = variant
        self.max_iter = max_iter
        self.tol = tol

    def fit(self, X: Any, y: Any) -> Self:  # ty: ignore[incompatible-method-override] (it weighs the samples itself)
        """Fit to X (n, d), y (n,); raises ValueError on bad input."""
        self._validate_params()
        X, y = validate_data(self, X, y, dtype=np.float64, y_numeric=True)
        y = np.asarray(y, np.float64)
        self._prepare(X)
        kept = self._kept(X, y)
        self._reweight(X[kept], y[kept])
        for name in ("weights_", "dual_coef_"):
            whole = np.zeros(len(y))
            whole[kept] = getattr(self, name)
            setattr(self, name, whole)
        return self

    def _kept(self, X: Array, y: Array) -> NDArray[np.bool_]:
        """Mask (n,) of the rows that are no outliers; the unweighted fit to them is left in the attributes."""
        printed = self.variant == "as_printed"
        rule = ("signal" if printed else "residual") if self.outliers == "variant" else self.outliers
        kept = solve.within_mad(y, self.threshold) if rule == "signal" else np.ones(len(y), bool)
        self._solve(X[kept], y[kept], None)
        for _ in range(self.max_iter if rule == "residual" else 0):
            now = solve.within_mad(y - self._predicted(X), self.threshold)
            if np.array_equal(now, kept) or now.sum() <= X.shape[1] + 1:
                break
            kept = now
            self._solve(X[kept], y[kept], None)
        return kept

    def _reweight(self, X: Array, y: Array) -> None:
        printed = self.variant == "as_printed"
        fitted, steps = self._predicted(X), 1 if printed else self.max_iter
        self.weights_ = np.ones(len(y))
        for self.n_iter_ in range(1, steps + 1):
            self.weights_ = solve.adaptive_weights(y - fitted, signed=printed)
            if not self.weights_.any():
                raise ValueError("the weights as printed are zero everywhere")
            self._solve(X, y, self.weights_)
            before, fitted = fitted, self._predicted(X)
            if np.linalg.norm(fitted - before) <= self.tol * np.linalg.norm(fitted):
                break
