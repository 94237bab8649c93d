"""Causes found by their score: refitted from the present setting or the best of a few starts; scored over values of a
second parameter that means nothing while the first is zero."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...checks.tails import log_tail
from ...estimation.filters.innovations.derivatives import columns
from ...estimation.filters.innovations.estimator import Estimator, Innovations
from ...estimation.filters.innovations.settings import Setting
from ..candidate import Candidate, Screened, Variant
from ..state import State
from ..statistics.bootstrap import independent_values, largest_score
from .base import Here, Search, refitted

if TYPE_CHECKING:
    from ..causes.base import Cause


@dataclass(frozen=True)
class ByScore(Search):
    """Score test at zero.

    values : values of the first parameter that a refit tries as starts beside zero (seconds: of a 160 m ship), for
    parameters that cannot be negative.
    """

    values: tuple[float, ...] = ()
    scored = True

    @property
    def counts_values(self) -> bool:
        return bool(self.values)

    def starts(self, est: Estimator, s: Setting, variant: Variant) -> Sequence[Setting]:
        factor = est.clock if variant[0].unit == "s" else 1.0
        return [s, *(est.at(s, variant[0], value * factor) for value in self.values)]

    def refit(self, cause: Cause, state: State, item: Screened, before: float, rng: np.random.Generator) -> Candidate:
        tests, start = float(len(state.bank[cause])), state.setting
        if self.values:
            options = self.starts(state.est, state.setting, item.variant)
            runs = state.est.many(options)
            start = options[int(np.argmax([now.log_likelihood for now in runs]))]
            tests *= independent_values(rng, state.point, runs[1:])
        return refitted(cause, state, item.variant, start, len(item.variant), tests, before)


@dataclass(frozen=True)
class ByProfile(Search):
    """Score of the first parameter at several values of the second.

    values : of the second parameter, s, for a 160 m ship.
    """

    values: tuple[float, ...]
    counts_values = True

    def screen(self, cause: Cause, state: State, here: Here, rng: np.random.Generator) -> Screened:
        est, (variant,) = state.est, state.bank[cause]
        first, second = variant
        values = [x * est.clock - second.origin for x in self.values]
        rows = np.vstack([columns(est, est.at(here.setting, second, value), (first,)) for value in values])
        best, score, tests = largest_score(rng, here.projector, rows)
        log_p = log_tail(score.statistic, 1) + np.log(tests)
        return Screened(cause, variant, log_p, score, (float(score.step[0]), values[best]), tests)

    def refit(self, cause: Cause, state: State, item: Screened, before: float, rng: np.random.Generator) -> Candidate:
        est, (first, second) = state.est, item.variant
        s = est.at(est.at(state.setting, second, item.start[1]), first, item.start[0])
        s, _ = state.refit(s, (first,), 2)
        return refitted(cause, state, item.variant, s, 2, float(len(state.bank[cause])), before)

    def n_sizes(self, variant: Variant) -> int:
        return 1


@dataclass(frozen=True)
class ByRings(Search):
    """Score test of (north, east) pairs at zero, one pair a record.

    sizes : three sizes of a pair that a refit tries in eight directions, record by record; by_clock: they are speeds
    of a 160 m ship, else shares of the force unit.
    """

    sizes: tuple[float, float, float]
    by_clock: bool = True
    scored = True

    def refit(self, cause: Cause, state: State, item: Screened, before: float, rng: np.random.Generator) -> Candidate:
        start = self._start(state, item.variant)
        tests = float(len(state.bank[cause]))
        return refitted(cause, state, item.variant, start, len(item.variant), tests, before)

    def _start(self, state: State, variant: Variant) -> Setting:
        """Each record's pair: none or the best of eight directions on the middle ring, or about it on the others."""
        est, s = state.est, state.setting
        inner, middle, outer = np.multiply(self.sizes, est.clock if self.by_clock else est.unit[0])
        records = range(est.n_records)

        def tried(rings: Sequence[tuple[float, np.ndarray]]) -> np.ndarray:
            """Log likelihoods (R, M) of each record at M sizes and octants (R,)."""
            runs = est.many([_at_ring(est, s, variant, np.full(len(records), size), octant) for size, octant in rings])
            return np.nan_to_num([[_of_record(est, now, i) for now in runs] for i in records], nan=-np.inf)

        first = [(0.0, np.zeros(len(records))), *((middle, np.full(len(records), octant)) for octant in range(8))]
        gains = tried(first)
        octant = np.argmax(gains[:, 1:], axis=1)
        rings = [*first, *((size, octant + turn) for size in (inner, outer) for turn in (-1, 0, 1))]
        best = np.argmax(np.hstack([gains, tried(rings[9:])]), axis=1)
        size = np.array([rings[k][0] for k in best])
        return _at_ring(est, s, variant, size, np.array([rings[k][1][i] for i, k in enumerate(best)]))


def _at_ring(est: Estimator, s: Setting, variant: Variant, size: np.ndarray, octant: np.ndarray) -> Setting:
    """The setting with each record's (north, east) pair of a size (R,) in a direction (R,), in eighths of a turn."""
    pairs = size * np.array([np.cos(np.pi / 4.0 * octant), np.sin(np.pi / 4.0 * octant)])
    for j, p in enumerate(variant):
        s = est.at(s, p, float(pairs[j % 2, p.record]))
    return s


def _of_record(est: Estimator, now: Innovations, record: int) -> float:
    """Log likelihood of one record, short of a constant."""
    rows = est.owner == record
    return float(-np.sum(now.log_s[rows]) - 0.5 * np.sum(now.e[rows] ** 2))
