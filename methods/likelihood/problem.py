"""What output error minimises: the negative log likelihood of records given free runs of a model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .. import factors, freerun
from ..series import Series
from .loss import Loss
from .unknowns import Unknowns

if TYPE_CHECKING:
    from ...models.model import Model

RELATIVE_FLOOR = 1e-13
"""Smallest residual counted, relative to the channel's size."""
VISIBLE = 1e-5
"""Smallest sensor noise that a channel is weighed by, relative to its size: a clean channel must not outweigh all."""


class Point(NamedTuple):
    """The cost at unknowns z (width,), and what a step from there needs."""

    z: np.ndarray
    cost: float
    squares: np.ndarray
    """(n,) sum of squared residuals of each state's channel; inf where a run diverges."""
    sd: np.ndarray
    """(n,) by which residuals are divided."""
    weights: tuple[np.ndarray, ...] | None = None
    """Of a robust loss: for each series the weight (N, c) of every residual's square."""
    moments: np.ndarray | None = None
    """Of a robust loss: (n, 2) means of rho'' and rho'^2 of each channel."""

    @property
    def ratio(self) -> float:
        """What likelihood ratios are to be multiplied by before they are compared with chi-square."""
        if self.moments is None:
            return 1.0
        return float(np.mean(self.moments[:, 0] / self.moments[:, 1]))


@dataclass(frozen=True)
class Problem:
    """Runs along `series`, their initial states `free` to move, channels weighted by their residual.

    Unknowns z are the coefficients (or the `unknowns` among the published parameters) and then the free initial states
    of each series in turn.
    """

    model: Model
    series: tuple[Series, ...]
    free: tuple[tuple[int, ...], ...]
    sensor: np.ndarray | None = None
    """(n,) standard deviations to weigh the channels by; None: each by its residual, as maximum likelihood has it."""
    unknowns: Unknowns | None = None
    loss: Loss | None = None

    @property
    def own(self) -> int:
        """Unknowns that are not initial states."""
        return len(self.model.coordinates) if self.unknowns is None else len(self.unknowns.moving)

    @property
    def width(self) -> int:
        return self.own + sum(map(len, self.free))

    @cached_property
    def counts(self) -> np.ndarray:
        """Measured values (n,) of each state."""
        total = np.zeros(len(self.model.states))
        for s in self.series:
            np.add.at(total, s.columns, np.isfinite(s.outputs).sum(axis=0))
        return total

    @cached_property
    def floors(self) -> np.ndarray:
        """(n,) squared residual below which a channel's fit is not improved any more."""
        size = np.zeros(len(self.model.states))
        for s in self.series:
            np.maximum.at(size, s.columns, np.nanmax(np.abs(s.outputs), axis=0, initial=0.0))
        return (RELATIVE_FLOOR * np.maximum(size, 1e-9)) ** 2

    def start(self, own: np.ndarray) -> np.ndarray:
        """Unknowns (width,) from coefficients (or parameters) and the records' initial states."""
        states = [s.start[list(free)] for s, free in zip(self.series, self.free, strict=True)]
        return np.concatenate([own, *states])

    def coefficients(self, z: np.ndarray) -> np.ndarray:
        """Coefficients (p,) at the unknowns z."""
        return z[: self.own] if self.unknowns is None else self.unknowns.coefficients(z[: self.own])

    def unpack(self, z: np.ndarray):
        """The model, and for each series its initial state and the place of its unknowns."""
        model, place, runs = self.model.with_coefficients(self.coefficients(z)), self.own, []
        for s, free in zip(self.series, self.free, strict=True):
            state = s.start.copy()
            state[list(free)] = z[place : place + len(free)]
            runs.append((s, state, free, place))
            place += len(free)
        return model, runs

    def at(self, z: np.ndarray) -> Point:
        """The cost at z; inf where a run diverges."""
        model, runs = self.unpack(z)
        if self.loss is not None:
            return self._prior(self._robust(z, self.loss, [freerun.residuals(model, s, x) for s, x, _, _ in runs]))
        total = np.zeros(len(self.model.states))
        for s, state, _, _ in runs:
            np.add.at(total, s.columns, freerun.squares(model, s, state))
        sd = np.sqrt(total / np.maximum(self.counts, 1.0) + self.floors) if self.sensor is None else self.sensor
        return self._prior(Point(z, self._cost(total), total, sd))

    def _cost(self, squares: np.ndarray) -> float:
        """Negative log likelihood: sum of N/2 log(S/N), or of S/2 in units of the sensors' variance."""
        used = self.counts > 0
        counts, squares = self.counts[used], squares[used]
        with np.errstate(all="ignore"):
            if self.sensor is not None:
                value = 0.5 * np.sum(squares / self.sensor[used] ** 2)
            else:
                value = 0.5 * np.sum(counts * np.log(squares / counts + self.floors[used]))
        return float(value) if np.isfinite(value) else np.inf

    def _robust(self, z: np.ndarray, loss: Loss, errors: Sequence[np.ndarray]) -> Point:
        """The same with a robust loss: sum of N consistency log s + rho(e/s) over the channels."""
        known = [np.isfinite(s.outputs) for s in self.series]
        wild = any(not np.isfinite(e[k]).all() for e, k in zip(errors, known, strict=True))
        total, sd, moments = np.zeros(len(self.counts)), np.ones(len(self.counts)), np.ones((len(self.counts), 2))
        if wild:
            return Point(z, np.inf, total + np.inf, sd)
        cost = 0.0
        for channel in np.flatnonzero(self.counts).tolist():
            e = np.concatenate([e[k[:, c], c] for e, k, c in self._of(channel, errors, known)])
            total[channel] = e @ e
            floor = float(np.sqrt(self.floors[channel]))
            sd[channel] = loss.scale(e, floor) if self.sensor is None else self.sensor[channel]
            u = e / sd[channel]
            cost += float(np.sum(loss.rho(u)))
            cost += 0.0 if self.sensor is not None else e.size * loss.consistency * float(np.log(sd[channel]))
            moments[channel] = loss.moments(u)
        weights = tuple(loss.weight(e / sd[s.columns]) for e, s in zip(errors, self.series, strict=True))
        return Point(z, cost, total, sd, weights, moments)

    def _of(self, channel: int, errors: Sequence[np.ndarray], known: Sequence[np.ndarray]):
        """Errors, what is known and the column of a channel, for every series that has it."""
        for s, e, k in zip(self.series, errors, known, strict=True):
            for c in np.flatnonzero(s.columns == channel):
                yield e, k, c

    def _prior(self, point: Point) -> Point:
        if self.unknowns is None or not np.isfinite(point.cost):
            return point
        rows = self.unknowns.prior_rows(point.z[: self.own])
        return point._replace(cost=point.cost + 0.5 * float(rows[:, -1] @ rows[:, -1]) + self.unknowns.prior_cost())

    def factor(self, point: Point) -> np.ndarray:
        """Triangular factor (width + 1, width + 1) of the weighted [derivatives | residuals]."""
        return self._folded(point, 1.0 / point.sd, point.weights)

    def information(self, point: Point) -> np.ndarray:
        """The same for the covariance: with a robust loss, by what a residual tells on average."""
        told = 1.0 if point.moments is None else point.moments[:, 0] / np.sqrt(point.moments[:, 1])
        return self._folded(point, told / point.sd, None)

    def _folded(self, point: Point, scale: np.ndarray, weights: tuple[np.ndarray, ...] | None) -> np.ndarray:
        model, runs = self.unpack(point.z)
        chart = None if self.unknowns is None else self.unknowns.jacobian(point.z[: self.own])
        rows = [factors.empty(self.width), *self._prior_rows(point.z)]
        for i, (s, state, free, place) in enumerate(runs):
            found = freerun.output_factors(model, s, state, free, None if weights is None else weights[i])
            for column, own in zip(s.columns, found, strict=True):
                rows.append(scale[column] * freerun.embed(own, chart, self.own, place, self.width))
        return factors.fold(factors.empty(self.width), np.vstack(rows))

    def _prior_rows(self, z: np.ndarray) -> list[np.ndarray]:
        if self.unknowns is None:
            return []
        rows = self.unknowns.prior_rows(z[: self.own])
        wide = np.zeros((len(rows), self.width + 1))
        wide[:, : self.own], wide[:, -1] = rows[:, :-1], rows[:, -1]
        return [wide]

    def limits(self) -> tuple[np.ndarray, np.ndarray] | None:
        """Bounds (width,) of the unknowns, low and high; None if there are none."""
        if self.unknowns is None or not self.unknowns.bounded:
            return None
        open_ended = np.full(self.width - self.own, np.inf)
        low, high = (bound[self.unknowns.moving] for bound in (self.unknowns.low, self.unknowns.high))
        return np.concatenate([low, -open_ended]), np.concatenate([high, open_ended])


def held(problem: Problem) -> Problem:
    """The problem in which runs start where the records start; heading counts only where nothing else is measured."""
    model, heading = problem.model, problem.model.states.index("psi")
    chosen = tuple(s if set(s.columns) == {heading} else s.without(heading) for s in problem.series)
    return replace(problem, series=chosen, free=tuple(_unmeasured(s, model) for s in chosen))


def _unmeasured(series: Series, model: Model) -> tuple[int, ...]:
    """States without a channel: surge, sway and yaw rate, but not the hidden one, which starts from a steady turn."""
    return tuple(i for i, name in enumerate(model.states) if name in ("u", "v", "r") and i not in series.columns)


def released(
    series: Sequence[Series], model: Model, unknowns: Unknowns | None = None, loss: Loss | None = None
) -> Problem:
    """The problem with all channels and free initial states."""
    free = [
        tuple(i for i, name in enumerate(model.states) if name in ("w", "u", "v", "r") or i in s.columns)
        for s in series
    ]
    return Problem(model, tuple(series), tuple(free), unknowns=unknowns, loss=loss)


def sensor_sd_of(problem: Problem) -> np.ndarray:
    """(n,) sensor noise of each state's channel, pooled over the records; at least VISIBLE."""
    total = np.zeros(len(problem.model.states))
    for s in problem.series:
        np.add.at(total, s.columns, s.noise**2 * np.isfinite(s.outputs).sum(axis=0))
    return np.sqrt(total / np.maximum(problem.counts, 1.0) + (VISIBLE / RELATIVE_FLOOR) ** 2 * problem.floors)


def adequate(problem: Problem, point: Point, times: float) -> bool:
    """Whether every channel's residual is within `times` its sensor noise; with a robust loss, its scale."""
    used = problem.counts > 0
    squares = point.squares
    if problem.loss is not None and np.isfinite(point.cost):
        squares = _robust_squares(problem, point)
    allowed = times**2 * sensor_sd_of(problem) ** 2 * problem.counts
    return bool(np.all(squares[used] <= allowed[used]))


def _robust_squares(problem: Problem, point: Point) -> np.ndarray:
    """(n,) counts times the squared scale of the residuals at a point, whatever they were divided by there."""
    point = point if problem.sensor is None else replace(problem, sensor=None).at(point.z)
    return problem.counts * point.sd**2
