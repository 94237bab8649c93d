"""The cost of output error: the negative log likelihood of records given free runs of a model."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ...models.model import Model
from ..numerics import factors
from ..records.series import Series
from ..simulation import free_run
from .linear_problem import Arrow, RecordRows
from .loss import Loss
from .unknowns import Unknowns

RELATIVE_FLOOR = 1e-13
"""Smallest residual standard deviation, relative to the channel's size."""
WIDE = 120
"""Initial states from which on the records' own unknowns are eliminated one record after the other."""
MOST_NUMBERS = 20_000_000
"""Numbers of the derivatives that are kept in memory for an accelerated step."""
VISIBLE = 1e-5
"""Smallest sensor noise that weights a channel, relative to its size: a clean channel must not outweigh all others."""


class Point(NamedTuple):
    """The cost at unknowns z (width,), and what the next step needs."""

    z: np.ndarray
    cost: float
    squares: np.ndarray
    """(n,) sum of squared residuals of each state's channel; inf where a run diverges."""
    sd: np.ndarray
    """(n,) standard deviation that each channel's residuals are divided by."""
    weights: tuple[np.ndarray, ...] | None = None
    """With a robust loss: for each series the weight (N, c) of every residual's square."""
    moments: np.ndarray | None = None
    """With a robust loss: (n, 2) means of rho'' and rho'^2 of each channel."""

    @property
    def ratio(self) -> float:
        """Factor on likelihood ratios before they are compared with chi-square."""
        if self.moments is None:
            return 1.0
        return float(np.mean(self.moments[:, 0] / self.moments[:, 1]))


class SeriesRun(NamedTuple):
    """A series, its initial state (n,), the states that are free, and the index of its first unknown."""

    series: Series
    start: np.ndarray
    free: tuple[int, ...]
    place: int


@dataclass(frozen=True)
class Problem:
    """Free runs along `series`, whose initial states `free` are unknowns, channels weighted by their residual.

    Unknowns z are the coefficients (or the `unknowns` among the published parameters) and then the free initial states
    of each series in turn.
    """

    model: Model
    series: tuple[Series, ...]
    free: tuple[tuple[int, ...], ...]
    sensor: np.ndarray | None = None
    """(n,) standard deviations that weight the channels; None: each channel's residual (maximum likelihood)."""
    unknowns: Unknowns | None = None
    loss: Loss | None = None

    @property
    def n_parameters(self) -> int:
        """Number of unknowns that are not initial states."""
        return len(self.model.coordinates) if self.unknowns is None else len(self.unknowns.estimated)

    @property
    def width(self) -> int:
        """Number of unknowns."""
        return self.n_parameters + sum(map(len, self.free))

    @cached_property
    def counts(self) -> np.ndarray:
        """Measured values (n,) of each state."""
        total = np.zeros(len(self.model.states))
        for s in self.series:
            np.add.at(total, s.columns, np.isfinite(s.outputs).sum(axis=0))
        return total

    @cached_property
    def floors(self) -> np.ndarray:
        """(n,) squared residual of a channel below which a better fit no longer counts."""
        size = np.zeros(len(self.model.states))
        for s in self.series:
            np.maximum.at(size, s.columns, np.nanmax(np.abs(s.outputs), axis=0, initial=0.0))
        return (RELATIVE_FLOOR * np.maximum(size, 1e-9)) ** 2

    def start(self, parameters: np.ndarray) -> np.ndarray:
        """Unknowns (width,) from coefficients (or parameters) and the records' initial states."""
        states = [s.start[list(free)] for s, free in zip(self.series, self.free, strict=True)]
        return np.concatenate([parameters, *states])

    def coefficients(self, z: np.ndarray) -> np.ndarray:
        """Coefficients (p,) at the unknowns z."""
        return z[: self.n_parameters] if self.unknowns is None else self.unknowns.coefficients(z[: self.n_parameters])

    def unpack(self, z: np.ndarray) -> tuple[Model, list[SeriesRun]]:
        """The model with the coefficients at z, and the run of each series."""
        model, place, runs = self.model.with_coefficients(self.coefficients(z)), self.n_parameters, []
        for s, free in zip(self.series, self.free, strict=True):
            state = s.start.copy()
            state[list(free)] = z[place : place + len(free)]
            runs.append(SeriesRun(s, state, free, place))
            place += len(free)
        return model, runs

    def at(self, z: np.ndarray) -> Point:
        """The cost at z; inf where a run diverges."""
        model, runs = self.unpack(z)
        if self.loss is not None:
            errors = [free_run.residuals(model, run.series, run.start) for run in runs]
            return self._with_prior(self._robust(z, self.loss, errors))
        total = np.zeros(len(self.model.states))
        for s, state, _, _ in runs:
            np.add.at(total, s.columns, free_run.squares(model, s, state))
        sd = np.sqrt(total / np.maximum(self.counts, 1.0) + self.floors) if self.sensor is None else self.sensor
        return self._with_prior(Point(z, self._cost(total), total, sd))

    def _cost(self, squares: np.ndarray) -> float:
        """Negative log likelihood from sums of squares S (n,): sum of N/2 log(S/N), or of S/2 in sensor units."""
        used = self.counts > 0
        counts, squares = self.counts[used], squares[used]
        with np.errstate(all="ignore"):
            if self.sensor is not None:
                value = 0.5 * np.sum(squares / self.sensor[used] ** 2)
            else:
                value = 0.5 * np.sum(counts * np.log(squares / counts + self.floors[used]))
        return float(value) if np.isfinite(value) else np.inf

    def _robust(self, z: np.ndarray, loss: Loss, errors: Sequence[np.ndarray]) -> Point:
        """The cost with a robust loss: sum of N consistency log s + rho(e/s) over the channels."""
        known = [s.known for s in self.series]
        diverged = any(not np.isfinite(e[k]).all() for e, k in zip(errors, known, strict=True))
        total, sd, moments = np.zeros(len(self.counts)), np.ones(len(self.counts)), np.ones((len(self.counts), 2))
        if diverged:
            return Point(z, np.inf, total + np.inf, sd)
        cost = 0.0
        for channel in np.flatnonzero(self.counts).tolist():
            own = zip(self.series, errors, known, strict=True)
            e = np.concatenate([e[k[:, c], c] for s, e, k in own for c in np.flatnonzero(s.columns == channel)])
            total[channel] = e @ e
            floor = float(np.sqrt(self.floors[channel]))
            sd[channel] = loss.scale(e, floor) if self.sensor is None else self.sensor[channel]
            u = e / sd[channel]
            cost += float(np.sum(loss.rho(u)))
            cost += 0.0 if self.sensor is not None else e.size * loss.consistency * float(np.log(sd[channel]))
            moments[channel] = loss.moments(u)
        weights = tuple(loss.weight(e / sd[s.columns]) for e, s in zip(errors, self.series, strict=True))
        return Point(z, cost, total, sd, weights, moments)

    def _with_prior(self, point: Point) -> Point:
        if self.unknowns is None or not np.isfinite(point.cost):
            return point
        rows = self.unknowns.prior_rows(point.z[: self.n_parameters])
        return point._replace(cost=point.cost + 0.5 * float(rows[:, -1] @ rows[:, -1]) + self.unknowns.prior_cost())

    def factor(self, point: Point) -> np.ndarray:
        """Triangular factor (width + 1, width + 1) of the weighted [derivatives | residuals]."""
        return self._folded(point, 1.0 / point.sd, point.weights)

    def information(self, point: Point) -> np.ndarray:
        """The same for the covariance: with a robust loss, weighted by the average information of a residual."""
        return self._folded(point, self._informative(point), None)

    def rows(self, point: Point) -> np.ndarray | None:
        """Weighted [derivatives | residuals] (M, width + 1), of which `factor` is made; None where they are too many.

        Run by run, channel by channel, and then the prior.
        """
        if sum(s.n_outputs for s in self.series) * (self.width + 1) > MOST_NUMBERS:
            return None
        return np.vstack(self._wide(point, 1.0 / point.sd, point.weights, free_run.output_rows))

    def residuals(self, z: np.ndarray, point: Point) -> np.ndarray:
        """Residuals (M,) of `rows` at unknowns z, in the weights of a point; not finite where a run diverges."""
        model, runs = self.unpack(z)
        found = []
        for i, (s, state, _, _) in enumerate(runs):
            error = free_run.residuals(model, s, state) / point.sd[s.columns]
            error = error if point.weights is None else error * np.sqrt(point.weights[i])
            found += [error[s.known[:, c], c] for c in range(len(s.columns))]
        return np.concatenate([*found, *(rows[:, -1] for rows in self._prior_rows(z))])

    @property
    def arrow_shaped(self) -> bool:
        """Whether there are so many initial states that `arrow` takes the place of `factor`."""
        return sum(map(len, self.free)) >= WIDE

    def arrow(self, point: Point, information: bool = False) -> Arrow:
        """The factor, or that for the covariance, with the initial states of every record apart."""
        weights = None if information else point.weights
        scale = self._informative(point) if information else 1.0 / point.sd
        n, model, runs, jacobian = self.n_parameters, *self._linearised(point)
        parts = []
        for i, (s, state, free, place) in enumerate(runs):
            found = free_run.output_factors(model, s, state, free, None if weights is None else weights[i])
            rows = np.vstack([scale[c] * factor for c, factor in zip(s.columns, found, strict=True)])
            p = rows.shape[1] - 1 - len(free)
            shared = rows[:, :p] if jacobian is None else rows[:, :p] @ jacobian
            parts.append(RecordRows(place, len(free), np.hstack([rows[:, p:-1], shared, rows[:, -1:]])))
        prior = [np.hstack([rows[:, :n], rows[:, -1:]]) for rows in self._prior_rows(point.z)]
        return Arrow.of(parts, np.vstack([np.zeros((0, n + 1)), *prior]))

    @staticmethod
    def _informative(point: Point) -> np.ndarray:
        """Weight (n,) of each channel's residuals in the information."""
        weight = 1.0 if point.moments is None else point.moments[:, 0] / np.sqrt(point.moments[:, 1])
        return weight / point.sd

    def _linearised(self, point: Point) -> tuple[Model, list[SeriesRun], np.ndarray | None]:
        """The model and the runs at a point, and d coefficients / d parameters where parameters are the unknowns."""
        model, runs = self.unpack(point.z)
        jacobian = None if self.unknowns is None else self.unknowns.jacobian(point.z[: self.n_parameters])
        return model, runs, jacobian

    def _folded(self, point: Point, scale: np.ndarray, weights: tuple[np.ndarray, ...] | None) -> np.ndarray:
        rows = self._wide(point, scale, weights, free_run.output_factors)
        return factors.fold(factors.empty(self.width), np.vstack(rows))

    def _wide(
        self, point: Point, scale: np.ndarray, weights: tuple[np.ndarray, ...] | None, of_outputs: Callable[..., Any]
    ) -> list[np.ndarray]:
        """What `of_outputs` gives for each run, scaled (n,), in the columns of all unknowns; then the prior."""
        rows, (model, runs, jacobian) = [], self._linearised(point)
        for i, (s, state, free, place) in enumerate(runs):
            found = of_outputs(model, s, state, free, None if weights is None else weights[i])
            for column, part in zip(s.columns, found, strict=True):
                rows.append(free_run.embed(part, jacobian, self.n_parameters, place, self.width))
                rows[-1] *= scale[column]
        return [*rows, *self._prior_rows(point.z)]

    def _prior_rows(self, z: np.ndarray) -> list[np.ndarray]:
        if self.unknowns is None:
            return []
        rows = self.unknowns.prior_rows(z[: self.n_parameters])
        wide = np.zeros((len(rows), self.width + 1))
        wide[:, : self.n_parameters], wide[:, -1] = rows[:, :-1], rows[:, -1]
        return [wide]

    def limits(self) -> tuple[np.ndarray, np.ndarray] | None:
        """Bounds (width,) of the unknowns, low and high; None if there are none."""
        if self.unknowns is None or not self.unknowns.has_bounds:
            return None
        open_ended = np.full(self.width - self.n_parameters, np.inf)
        low, high = (bound[self.unknowns.estimated] for bound in (self.unknowns.low, self.unknowns.high))
        return np.concatenate([low, -open_ended]), np.concatenate([high, open_ended])


def fixed_start_problem(problem: Problem) -> Problem:
    """The problem in which runs start where the records start; heading counts only where nothing else is measured."""
    model, heading = problem.model, problem.model.states.index("psi")
    chosen = tuple(s if set(s.columns) == {heading} else s.without(heading) for s in problem.series)
    return replace(problem, series=chosen, free=tuple(_unmeasured(s, model) for s in chosen))


def _unmeasured(series: Series, model: Model) -> tuple[int, ...]:
    """States without a channel: surge, sway and yaw rate; not the hidden state, which starts from a steady turn."""
    return tuple(i for i, name in enumerate(model.states) if name in ("u", "v", "r") and i not in series.columns)


def free_start_problem(
    series: Sequence[Series], model: Model, unknowns: Unknowns | None = None, loss: Loss | None = None
) -> Problem:
    """The problem with all channels and with free initial states."""
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


def explains_records(problem: Problem, point: Point, times: float) -> bool:
    """Whether every channel's residual (with a robust loss: its scale) is within `times` the noise of its sensor."""
    used = problem.counts > 0
    squares = point.squares
    if problem.loss is not None and np.isfinite(point.cost):
        squares = _robust_squares(problem, point)
    allowed = times**2 * sensor_sd_of(problem) ** 2 * problem.counts
    return bool(np.all(squares[used] <= allowed[used]))


def _robust_squares(problem: Problem, point: Point) -> np.ndarray:
    """(n,) counts times the squared scale of the residuals at a point."""
    point = point if problem.sensor is None else replace(problem, sensor=None).at(point.z)
    return problem.counts * point.sd**2
