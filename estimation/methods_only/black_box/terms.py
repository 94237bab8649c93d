"""Linear regression on products of features: polynomials, and the terms of manoeuvring models such as |v| r."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations_with_replacement
from typing import Any

import numpy as np
from sklearn.base import BaseEstimator, RegressorMixin
from sklearn.linear_model import Ridge

ROWS = 512
"""Rows whose terms are computed at a time."""


def monomials(d: int, degree: int) -> np.ndarray:
    """Factors (T, degree) of all products of at most `degree` of d features: 0 stands for one, i + 1 for feature i."""
    return np.array(list(combinations_with_replacement(range(d + 1), degree)), dtype=np.int64)


def manoeuvring_terms(symmetric: Sequence[bool]) -> np.ndarray:
    """Factors (T, 3) of the monomials up to degree 3 and of |a| b.

    a : a feature whose zero is that of the ship's symmetry (v, r, rudder), by `symmetric` (d,); b : any feature.
    1 + d + i stands for the absolute value of feature i.
    """
    d = len(symmetric)
    moduli = [(0, 1 + b, 1 + d + a) for a in range(d) if symmetric[a] for b in range(d)]
    return np.vstack([monomials(d, 3), np.array(moduli, dtype=np.int64).reshape(-1, 3)])


def evaluate(factors: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Terms (N, T) with factors (T, m) at features x (N, d)."""
    found = np.empty((len(factors), len(x)))
    for start in range(0, len(x), ROWS):
        own, part = found[:, start : start + ROWS], x[start : start + ROWS].T
        extended = np.vstack([np.ones((1, part.shape[1])), part, np.abs(part)])
        own[:] = extended[factors[:, 0]]
        for column in factors.T[1:]:
            own *= extended[column]
    return found.T


class TermRegression(RegressorMixin, BaseEstimator):
    """Targets linear in terms: |y - Theta c|^2 + alpha N |c|^2, for terms of unit root mean square.

    Parameters
    ----------
    factors : (T, m) of the terms, see `evaluate`.
    alpha : penalty, relative to the squared length of a term's column.
    threshold : coefficients smaller than this share of a target's spread are removed, and the rest fitted again, until
        none is (sequentially thresholded least squares: Brunton, Proctor & Kutz 2016, PNAS 113, 3932); 0: none.
    """

    def __init__(self, factors: np.ndarray, alpha: float = 1e-6, threshold: float = 0.0) -> None:
        self.factors, self.alpha, self.threshold = factors, alpha, threshold

    def fit(self, x: np.ndarray, y: np.ndarray) -> TermRegression:
        theta = evaluate(self.factors, x)
        size = np.sqrt([np.mean(column**2) for column in theta.T])
        kept = size > 0.0
        targets = y.reshape(len(y), -1)
        found = np.zeros((theta.shape[1], targets.shape[1]))
        theta = theta if kept.all() else theta[:, kept]
        theta /= size[kept]
        inner = sparse(theta, targets, self.alpha, self.threshold)
        found[kept] = inner / size[kept, None]
        used = found.any(axis=1)
        self.terms_, self.weights_ = self.factors[used], found[used]
        return self

    def predict(self, x: np.ndarray) -> np.ndarray:
        return (
            evaluate(self.terms_, x) @ self.weights_ if len(self.terms_) else np.zeros((len(x), self.weights_.shape[1]))
        )

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        tags.target_tags.multi_output = True
        return tags


def sparse(theta: np.ndarray, targets: np.ndarray, alpha: float, threshold: float) -> np.ndarray:
    """Coefficients (T, k) of `TermRegression` for terms (N, T) of unit size and targets (N, k)."""
    found = _ridge(theta, targets, alpha)
    if not threshold:
        return found
    for column, target in enumerate(targets.T):
        limit = threshold * np.sqrt(np.mean(target**2))
        used = np.ones(theta.shape[1], dtype=bool)
        while (small := used & (np.abs(found[:, column]) < limit)).any():
            used &= ~small
            found[:, column] = 0.0
            if not used.any():
                break
            found[used, column] = _ridge(theta[:, used], target[:, None], alpha)[:, 0]
    return found


def _ridge(theta: np.ndarray, targets: np.ndarray, alpha: float) -> np.ndarray:
    solved = Ridge(alpha=alpha * len(theta), fit_intercept=False, copy_X=False).fit(theta, targets)
    return solved.coef_.reshape(targets.shape[1], -1).T
