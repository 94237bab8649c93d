"""Regressors of scaled features and targets, fitted and asked: what every learnt predictor here is made of."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ....models.errors import FitFailed
from .compiled import OUTSIDE, Packed, compiled, drawn, stacked
from .rows import SYMMETRIC

LARGEST = 1e100
"""Size of a feature or target above which it counts as not finite."""
CHECKED = 50
"""Training rows on which compiled forms of the regressors are compared with the regressors themselves."""
DIGITS = 9
"""Decimals of scaled rows: rounding errors of the records' units do not decide between two splits of a tree."""


@dataclass(frozen=True)
class Scaled:
    """Regressors of features (d,) and targets (k,), each less its mean and scaled; constant features are zero.

    `fast`, if set, gives the same predictions as the regressors.
    """

    mean: np.ndarray
    scale: np.ndarray
    y_mean: np.ndarray
    y_scale: np.ndarray
    regressors: tuple[Any, ...]
    fast: Packed | None

    @property
    def packed(self) -> tuple[Any, ...] | None:
        """First arguments of the compiled free runs (`_kernels`); None where no compiled form agrees."""
        if self.fast is None:
            return None
        work = np.empty(len(self.mean) + self.fast.work)
        scaling = np.ascontiguousarray([self.mean, self.scale])
        return self.fast.form, self.fast.ints, self.fast.floats, scaling, np.ascontiguousarray(self.y_scale), work

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """Targets (B, k) at features (B, d); nan where these are far from all training rows."""
        scaled = (x - self.mean) * self.scale
        near, found = _near(scaled), np.full((len(x), len(self.y_scale)), np.nan)
        if near.any():
            asked = scaled[near]
            found[near] = stacked(self.regressors, asked) if self.fast is None else self.fast(asked)
        return found * self.y_scale + self.y_mean

    def near(self, x: np.ndarray) -> np.ndarray:
        """(B,) bool: whether features (B, d) are near enough to the training rows for the function to be asked."""
        return _near((x - self.mean) * self.scale)

    def drawn(self, count: int, rng: np.random.Generator) -> list[Scaled]:
        """At most `count` functions drawn from the regressors' uncertainty; none where they state none."""
        return [replace(self, fast=one) for one in drawn(self.regressors, len(self.y_scale), count, rng)]


def _near(scaled: np.ndarray) -> np.ndarray:
    """(B,) bool: whether scaled features (B, d) are known and within OUTSIDE."""
    return np.asarray((np.abs(scaled) <= OUTSIDE).all(axis=1))


def fit_scaled(
    x: np.ndarray, y: np.ndarray, make: Callable[[int], Any], symbols: Sequence[str] | None = None
) -> Scaled:
    """Fit regressors to features x (N, d) and targets y (N, k), both scaled to unit variance.

    Parameters
    ----------
    make : number of features -> a new regressor.
    symbols : (d,) of the features; those of the ship's symmetry keep their zero, and so do all targets.  None: no zero
        is kept.

    Raises
    ------
    FitFailed : the rows are not finite, or a regressor cannot be fitted.
    """
    if not all(max(rows.max(), -rows.min()) < LARGEST for rows in (x, y)):
        raise FitFailed("states or accelerations are not finite")
    still = [symbol in SYMMETRIC for symbol in symbols or ()] or np.zeros(x.shape[1], bool)
    mean, y_mean = np.where(still, 0.0, x.mean(axis=0)), y.mean(axis=0) if symbols is None else np.zeros(y.shape[1])
    scale, y_scale = inverse_spread(x, mean), 1.0 / inverse_spread(y, y_mean, 1.0)
    scaled, target = x - mean, (y - y_mean) / y_scale
    scaled *= scale
    for rows in (scaled, target):
        np.round(rows, DIGITS, out=rows)
    regressors = fit_regressors(scaled, target, make)
    fast = compiled(regressors, scaled[evenly_spaced(len(scaled), CHECKED)])
    return Scaled(mean, scale, y_mean, y_scale, regressors, fast)


def inverse_spread(values: np.ndarray, mean: np.ndarray, constant: float = 0.0) -> np.ndarray:
    """1 / root mean square of columns (N, k) about mean (k,); `constant` for a column that does not vary."""
    spread = np.sqrt(np.mean((values - mean) ** 2, axis=0))
    varies = (values.std(axis=0) > 1e-9 * np.abs(values).max(axis=0)) & (spread > 0.0)
    return np.where(varies, 1.0 / np.where(varies, spread, 1.0), constant)


def fit_regressors(x: np.ndarray, y: np.ndarray, make: Callable[[int], Any]) -> tuple[Any, ...]:
    """One regressor for all targets (N, k) if it takes several, else one for each."""
    from sklearn.utils import get_tags

    first = make(x.shape[1])
    try:
        if y.shape[1] > 1 and get_tags(first).target_tags.multi_output:
            return (first.fit(x, y),)
        return tuple(make(x.shape[1]).fit(x, column) for column in y.T)
    except (TypeError, ValueError, ArithmeticError) as error:
        raise FitFailed(f"{type(first).__name__}: {error}") from error


def evenly_spaced(count: int, most: int | None) -> np.ndarray:
    """Indices of at most `most` of `count` rows, evenly spaced."""
    if most is None or count <= most:
        return np.arange(count)
    return np.linspace(0, count - 1, most).round().astype(np.int64)


def unchecked():
    """Context in which scikit-learn does not check arrays and options that are known to be valid."""
    from sklearn import config_context

    return config_context(assume_finite=True, skip_parameter_validation=True)
