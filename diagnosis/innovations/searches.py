"""How a cause is looked for: screened by a score and then refitted, or tried directly.

ByScore       refitted from the present setting or the best of a few starts
ByProfile     scored over values of a second parameter that means nothing while the first is zero
ByRings       (north, east) pairs, one a record
ByChangePoint sets in at an unknown time: scored over a grid of times, in all records or one
ByScan        the derivative at zero says nothing: one number of the vector is scanned and then refined
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ...checks.tails import log_tail
from ...estimation.filters.innovations.derivatives import columns
from ...estimation.filters.innovations.estimator import Estimator, Innovations
from ...estimation.filters.innovations.noise_fit import fit_noise
from ...estimation.filters.innovations.settings import Setting
from .score_tests import ONE_SIDED, independent_values, largest_score
from .state import Candidate, Screened, State, Variant, candidate

if TYPE_CHECKING:
    from ..causes.base import Cause
    from .state import Point


FIRST_STEPS = 2
"""Steps of every leader's refit; those near the best go on."""


class Search:
    """How a cause is looked for.

    scored : the variants are scored together with those of other causes (`screen` is then not called).
    steady : what belongs to a record holds all through it, so that other records have their own.
    counts_values : the level counts how many independent tests the tried values amount to.
    of_first : the first parameter alone measures the effect's strength, else all do.
    entries : numbers of the filter's vector that hold a cause without parameters.
    """

    scored = False
    steady = True
    counts_values = False
    of_first = False

    @property
    def entries(self) -> tuple[str, ...]:
        return ()

    def screen(self, cause: Cause, state: State, here: Point, rng: np.random.Generator) -> Screened | None:
        """The cause's best variant by its score; None for a cause that is tried directly."""
        return None

    def refit(self, cause: Cause, state: State, item: Screened, before: float, rng: np.random.Generator) -> Candidate:
        """The screened cause with parameters and noise refitted; before: the log likelihood without it."""
        raise TypeError(f"{type(self).__name__} does not screen")

    def attempt(self, cause: Cause, state: State, before: float, rng: np.random.Generator) -> Candidate | None:
        """The cause tried without a screen; None where it gains nothing, or was screened."""
        return None

    def starts(self, est: Estimator, s: Setting, variant: Variant) -> Sequence[Setting]:
        """Settings that a refit may start from, the given one first."""
        return [s]


def refitted(
    cause: Cause, state: State, variant: Variant, start: Setting, k: int, tests: float, before: float
) -> Candidate:
    """A candidate after the first steps of a refit."""
    return candidate(cause, variant, k, tests, before, *state.refit(start, variant, FIRST_STEPS))


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
    counts_values = of_first = True

    def screen(self, cause: Cause, state: State, here: Point, rng: np.random.Generator) -> Screened:
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


@dataclass(frozen=True)
class ByChangePoint(Search):
    """Score of the size at several times; variants are pairs (size, time).

    grid : number of times over the longest record.
    """

    grid: int = 12
    steady = False
    counts_values = of_first = True

    def screen(self, cause: Cause, state: State, here: Point, rng: np.random.Generator) -> Screened:
        est = state.est
        ((size, time),) = state.bank[cause]
        times = np.linspace(0.0, longest(est), self.grid + 2)[1:-1].tolist()
        owners: list[int | None] = [None, *range(est.n_records)] if est.n_records > 1 else [0]
        rows, places = [], []

        def setting_in(t: float) -> np.ndarray:
            return columns(est, est.at(here.setting, time, t), (size,))[0].reshape(-1, 6)

        for t, column in zip(times, state.in_threads(setting_in, times), strict=True):
            for record in owners:
                part = column if record is None else np.where((est.owner == record)[:, None], column, 0.0)
                rows.append(part.ravel())
                places.append((record, t))
        best, score, tests = largest_score(rng, here.projector, np.stack(rows))
        record, t = places[best]
        variant = (replace(size, record=record), replace(time, record=record))
        log_p = log_tail(score.statistic, 1) + np.log(tests)
        return Screened(cause, variant, log_p, score, (float(score.step[0]), t), tests)

    def refit(self, cause: Cause, state: State, item: Screened, before: float, rng: np.random.Generator) -> Candidate:
        est, (size, time) = state.est, item.variant
        s = est.at(est.at(state.setting, time, item.start[1]), size, float(np.clip(item.start[0], -0.8, 0.8)))
        s, _ = state.refit(s, (size,), 2)
        times = np.linspace(0.0, longest(est), 2 * self.grid + 2)[1:-1]
        s = self._best(state, s, time, [float(t) for t in times])  # under gusts that the change no longer hides in
        width, middle = float(times[1] - times[0]), est.value(s, time)
        s = self._best(state, s, time, [middle + share * width for share in (-0.6, -0.4, -0.2, 0.2, 0.4, 0.6)])
        return refitted(cause, state, item.variant, s, 2, item.tests, before)

    def _best(self, state: State, s: Setting, time, values: list[float]) -> Setting:
        settings = [s, *(state.est.at(s, time, value) for value in values)]
        return settings[int(np.argmax([now.log_likelihood for now in state.est.many(settings)]))]


def longest(est: Estimator) -> float:
    """Duration of the longest record, s."""
    return max(float(d.offset_s + d.time[-1]) for d in est.segments)


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
