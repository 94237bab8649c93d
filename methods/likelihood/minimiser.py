"""Levenberg-Marquardt on triangular factors, within bounds if there are any."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .problem import Point, Problem

ROUGH, FINE = 1.0, 1e-6
"""Promised gain in log likelihood at which the search among starts stops, and at which the last minimum does."""
SHARE = 1e-3
"""Share of the cost whose promise is not worth another step while channels are weighed by their sensors."""
NULL = 1e-12
"""Singular values (columns of unit length) below which a direction counts as not identified."""


class Minimum(NamedTuple):
    """Where `levenberg_marquardt` stopped."""

    point: Point
    converged: bool
    n_iterations: int

    @property
    def z(self) -> np.ndarray:
        return self.point.z

    @property
    def cost(self) -> float:
        return self.point.cost


class _Linear:
    """The weighted problem about one point, in columns of unit length."""

    def __init__(self, factor: np.ndarray) -> None:
        self.a, self.b = factor[:, :-1], factor[:, -1]
        length = np.linalg.norm(self.a, axis=0)
        self.length = np.where(length > 0.0, length, 1.0)
        u, s, vt = np.linalg.svd(self.a / self.length, full_matrices=False)
        kept = s > NULL * s[0]
        self.singular, self.projected = s[kept], (u.T @ self.b)[kept]
        self.back = vt[kept].T / self.length[:, None]

    def step(self, damping: float) -> tuple[np.ndarray, float]:
        """The damped step (width,), and the decrease of half the sum of squares that it promises."""
        left = damping / (self.singular**2 + damping)
        step = self.back @ (self.singular / (self.singular**2 + damping) * self.projected)
        return step, float(0.5 * np.sum(self.projected**2 * (1.0 - left**2)))

    def step_within(self, damping: float, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, float]:
        """The same for a step between `low` and `high`: what would leave is put on its bound, the rest solved anew."""
        inside = np.ones(self.length.size, bool)
        step = np.zeros(self.length.size)
        while inside.any():
            a = self.a[:, inside] / self.length[inside]
            rest = self.b - self.a[:, ~inside] @ step[~inside]
            damped = np.vstack([a, np.sqrt(damping) * np.eye(a.shape[1])])
            right = np.concatenate([rest, np.zeros(a.shape[1])])
            step[inside] = np.linalg.lstsq(damped, right, rcond=NULL)[0] / self.length[inside]
            leaving = inside & ((step < low) | (step > high))
            if not leaving.any():
                break
            step[leaving] = np.clip(step, low, high)[leaving]
            inside &= ~leaving
        return step, float(0.5 * (self.b @ self.b - np.sum((self.b - self.a @ step) ** 2)))


def levenberg_marquardt(problem: Problem, z: np.ndarray, most: int, gain: float = FINE) -> Minimum:
    """Minimise the problem's cost from z (width,), which lies within its bounds; never leaves it worse.

    It has converged when the damped linear problem promises less than `gain` in log likelihood, or when no step lowers
    the cost although it promises only what rounding can hide.
    """
    here, damping, limits = problem.at(z), 1e-3, problem.limits()
    for iteration in range(most):
        if not np.isfinite(here.cost):
            return Minimum(here, False, iteration)
        enough = max(gain, SHARE * here.cost) if problem.sensor is not None else gain
        factor = problem.factor(here)
        if not np.isfinite(factor).all():
            return Minimum(here, False, iteration)
        linear = _Linear(factor)
        easier = 0.01  # less damping after a step that is taken at once, as much after one that takes several trials
        while True:
            if limits is None:
                step, promise = linear.step(damping)
            else:
                step, promise = linear.step_within(damping, limits[0] - here.z, limits[1] - here.z)
            there = problem.at(here.z + step)
            if there.cost < here.cost or promise < enough:
                break
            damping, easier = max(5.0 * damping, 1e-10), 1.0
        if not there.cost < here.cost:
            return Minimum(here, True, iteration + 1)
        good = here.cost - there.cost > 0.7 * promise
        here = there
        damping *= easier if good else max(easier, 0.3)
        if promise < enough:
            return Minimum(here, True, iteration + 1)
    return Minimum(here, False, most)
