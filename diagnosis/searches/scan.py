"""Causes whose derivative at zero says nothing: one number of the vector is scanned and then refined."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ...estimation.filters.innovations.estimator import Estimator, Innovations
from ...estimation.filters.innovations.noise_fit import fit_noise
from ...estimation.filters.innovations.settings import Setting
from ..candidate import Candidate, candidate
from ..state import State
from ..statistics.bootstrap import ONE_SIDED, independent_values
from .base import Search

if TYPE_CHECKING:
    from ..causes.base import Cause

MOST_VALUES = 24
"""Values that a scan goes on to, each in the last one's proportion to the one before, while the last one is best."""
WORTH_REFINING = 2.0
"""Nats that a scanned value must gain."""


def unlimited(est: Estimator) -> float:
    """Any value can be."""
    return float("inf")


@dataclass(frozen=True)
class ByScan(Search):
    """Log likelihood at several values of one number, alike in all records.

    entry : name of the number in the filter's vector.
    values : of a state, those to try first, the largest (or smallest) last; none where a scan is not worth its time.
    most : of an estimator, the largest value that can be.
    """

    entry: str
    values: Callable[[State], Sequence[float]]
    most: Callable[[Estimator], float] = unlimited
    counts_values = True

    @property
    def entries(self) -> tuple[str, ...]:
        return (self.entry,)

    def attempt(self, cause: Cause, state: State, before: float, rng: np.random.Generator) -> Candidate | None:
        est = state.est

        def changed(value: float) -> Setting:
            return est.with_entries(state.setting, {self.entry: value})

        def at(value: float) -> tuple[Setting, Innovations]:
            return fit_noise(est, changed(value), 2)

        values = list(self.values(state))
        if not values:
            return None
        gains = [at(value)[1].log_likelihood for value in values]
        while gains[-1] == max(gains) > before + WORTH_REFINING and len(values) < MOST_VALUES:
            values.append(values[-1] ** 2 / values[-2])
            gains.append(at(values[-1])[1].log_likelihood)
        best = int(np.argmax(gains))
        if gains[best] < before + WORTH_REFINING:
            return None
        from scipy.optimize import minimize_scalar

        ends = np.log([values[max(best - 1, 0)], values[min(best + 1, len(values) - 1)]])
        low, high = min(ends) - 0.3 * (best == 0), max(ends) + 0.3 * (best == len(values) - 1)
        best_one: Any = minimize_scalar(
            lambda x: -at(float(np.exp(x)))[1].log_likelihood,
            bounds=(low, high),
            options={"xatol": 0.01, "maxiter": 14},
        )
        (variant,) = state.bank[cause]
        value = float(np.exp(best_one.x)) if -best_one.fun > gains[best] else values[best]
        if value > self.most(est):
            return None
        setting, now = state.refit(at(value)[0], variant, 2)
        runs = est.many([changed(v) for v in values]) if variant else []
        tests = independent_values(rng, state.point, runs) if variant else ONE_SIDED
        return candidate(cause, variant, 1, tests, before, setting, now)
