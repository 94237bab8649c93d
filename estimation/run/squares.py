"""Sums of squared errors of runs, and what is told of them: root mean square error and R^2."""

from __future__ import annotations

from collections.abc import Iterable
from functools import reduce
from typing import NamedTuple

import numpy as np


class Squares(NamedTuple):
    """Number of samples, sum of squared errors, and sum of squared deviations of the observations from their mean.

    Sums of several runs are added, so that each counts from its own mean.
    """

    n: int = 0
    error: float = 0.0
    spread: float = 0.0

    def plus(self, other: Squares) -> Squares:
        """The sums of both."""
        return Squares(self.n + other.n, self.error + other.error, self.spread + other.spread)

    def scores(self) -> tuple[float, float]:
        """Root mean square error and R^2 = 1 - SSE/SST; nan where nothing was observed or a prediction is not finite.

        R^2 is nan for an observation that does not vary.
        """
        if not self.n or not np.isfinite(self.error):
            return np.nan, np.nan
        return float(np.sqrt(self.error / self.n)), 1.0 - self.error / self.spread if self.spread > 0.0 else np.nan


def squares(observed: np.ndarray, predicted: np.ndarray) -> Squares:
    """The sums over (N,) samples, gaps of `observed` (nan) left out."""
    known = np.isfinite(observed)
    if not known.all():
        observed, predicted = observed[known], predicted[known]
    if not observed.size:
        return Squares()
    with np.errstate(all="ignore"):
        error = np.sum((predicted - observed) ** 2)
        spread = np.sum((observed - observed.mean()) ** 2)
    return Squares(observed.size, float(error), float(spread))


def pooled(parts: Iterable[Squares]) -> Squares:
    """The sums over several runs."""
    return reduce(Squares.plus, parts, Squares())
