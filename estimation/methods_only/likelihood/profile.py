"""Profile-likelihood confidence intervals of published parameters, the other parameters fitted again.

Source: Venzon & Moolgavkar 1988, Appl. Stat. 37, 87.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...likelihood.linear_problem import NULL
from ...likelihood.minimiser import levenberg_marquardt
from ...likelihood.problem import Problem
from ...likelihood.search import Outcome
from ...likelihood.unknowns import Unknowns
from ...numerics import factors

TRIALS = 14
"""Refits on each side at most; a limit that is not found by then is open."""
CLOSE = 0.02
"""Relative error of the likelihood ratio's root at which the search for a limit stops."""
ITERATIONS, GAIN = 60, 1e-4
"""Of a refit: iterations at most, and the predicted gain at which it stops."""
FIRST = 0.1
"""First step of a parameter without a standard error, relative to its size."""


class Interval(NamedTuple):
    """A confidence interval.

    A limit is open where the likelihood ratio stays below its threshold up to there: at a bound of the parameter, at a
    value beyond which runs diverge, or at infinity.
    """

    low: float
    high: float
    low_open: bool
    high_open: bool


def profile(outcome: Outcome, indices: Sequence[int], level: float) -> dict[str, Interval]:
    """Intervals of published parameters by name: 2 (cost - least cost) <= the chi-square quantile of `level`.

    Prior and bounds of the other parameters still apply; a parameter's own prior counts as data.  With a robust loss
    the ratio is scaled as M-estimation requires.
    """
    from scipy.special import chdtri

    problem, z = _public(outcome.problem, outcome.minimum.z)
    point = problem.at(z)
    threshold = float(np.sqrt(chdtri(1, 1.0 - level) / point.ratio))
    solution = factors.solve(problem.information(point), NULL)
    unknowns = problem.unknowns
    assert unknowns is not None
    estimated = unknowns.estimated.tolist()
    found = {}
    for index in indices:
        if index not in estimated:
            value = float(unknowns.values[index])
            found[unknowns.model.parameter_names[index]] = Interval(value, value, False, False)
            continue
        search = _Profile(problem, z, point.cost, estimated.index(index), index, threshold, solution.covariance)
        (low, low_open), (high, high_open) = search.limit(-1.0), search.limit(1.0)
        found[unknowns.model.parameter_names[index]] = Interval(low, high, low_open, high_open)
    return found


def _public(problem: Problem, z: np.ndarray) -> tuple[Problem, np.ndarray]:
    """The problem with published parameters as unknowns."""
    if problem.unknowns is not None:
        return problem, z
    public = replace(problem, unknowns=Unknowns.all_of(problem.model))
    return public, np.concatenate([problem.model.to_parameters(z[: problem.n_parameters]), z[problem.n_parameters :]])


class _Profile(NamedTuple):
    """The profile likelihood of the parameter `index`, which is the unknown `place`, about the minimum z (width,)."""

    problem: Problem
    z: np.ndarray
    least: float
    place: int
    index: int
    threshold: float
    covariance: np.ndarray

    def limit(self, sign: float) -> tuple[float, bool]:
        """The value at which the root of twice the likelihood ratio reaches the threshold, by false position, and
        whether the interval is open there."""
        centre = float(self.z[self.place])
        bound = self._bound(sign)
        step, reached = self._first_step(), 0.0
        inner, outer = (0.0, 0.0), None
        start = self.z
        for _ in range(TRIALS):
            value = centre + sign * step
            at_bound = sign * (value - bound) >= 0.0
            value = bound if at_bound else value
            step = abs(value - centre)
            root, start = self._refit(value, start)
            if abs(root / self.threshold - 1.0) < CLOSE:
                return value, False
            if root < self.threshold:
                if at_bound:
                    return bound, True
                inner, reached = (step, root), step
            else:
                outer = (step, root)
                start = self.z
            step = self._next(inner, outer, step)
        if outer is None:
            return sign * np.inf, True
        return centre + sign * reached, not outer[1] < 2.0 * self.threshold  # open where runs diverge beyond it

    def _bound(self, sign: float) -> float:
        unknowns = self.problem.unknowns
        assert unknowns is not None
        return float((unknowns.high if sign > 0.0 else unknowns.low)[self.index])

    def _first_step(self) -> float:
        variance = self.covariance[self.place, self.place]
        if np.isfinite(variance) and variance > 0.0:
            return self.threshold * float(np.sqrt(variance))
        return FIRST * (abs(float(self.z[self.place])) or 1.0)

    def _next(self, inner: tuple[float, float], outer: tuple[float, float] | None, step: float) -> float:
        if outer is None:
            growth = self.threshold / inner[1] if inner[1] > 0.0 else 4.0
            return step * min(max(1.05 * growth, 1.1), 4.0)
        if not np.isfinite(outer[1]):
            return 0.5 * (inner[0] + outer[0])
        share = (self.threshold - inner[1]) / (outer[1] - inner[1])
        return inner[0] + min(max(share, 0.1), 0.9) * (outer[0] - inner[0])

    def _refit(self, value: float, start: np.ndarray) -> tuple[float, np.ndarray]:
        """Root of twice the likelihood ratio with the parameter fixed at `value`, and the unknowns there."""
        unknowns = self.problem.unknowns
        assert unknowns is not None
        others = unknowns.with_fixed(self.index, value)
        fixed = replace(self.problem, unknowns=others)
        for guess in (self._predicted(value), start):
            z = np.delete(guess, self.place)
            z[: fixed.n_parameters] = others.clipped(z[: fixed.n_parameters])
            if np.isfinite(fixed.at(z).cost):
                found = levenberg_marquardt(fixed, z, ITERATIONS, GAIN)
                root = float(np.sqrt(2.0 * max(found.cost - self.least, 0.0)))
                return root, np.insert(found.z, self.place, value)
        return np.inf, start

    def _predicted(self, value: float) -> np.ndarray:
        """The unknowns at the minimum with the parameter at `value`, if the cost is quadratic."""
        variance = self.covariance[self.place, self.place]
        predicted = self.z.copy()
        if np.isfinite(variance) and variance > 0.0:
            column = np.where(np.isfinite(np.diag(self.covariance)), self.covariance[:, self.place], 0.0)
            predicted += column / variance * (value - self.z[self.place])
        predicted[self.place] = value
        return predicted
