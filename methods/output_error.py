"""Output error: the model that, run freely from an initial state, comes closest to the measured outputs.

Maximum likelihood for white sensor noise on yaw rate, heading, surge and sway (those that a record has), with the
standard deviation of each channel estimated along: the sum of N_c log s_c is minimised by Levenberg-Marquardt steps on
generated forward sensitivities.  Every step comes from orthogonal factors, so weakly identified directions keep the
accuracy that the records give them.

The cost has many minima.  Starts come from least squares, never from the truth; the best are tried as they are and
after fits over growing horizons, where the run is restarted at measured states (a mild form of multiple shooting).
Initial states are unknowns of the fit.  If no start brings every residual down to a few times its sensor's noise, the
model does not explain the records: free initial states would then bend to hide that, and the heading, which integrates
every error, would rule the fit.  Runs then start where the records start, and heading only counts where no yaw rate
is measured.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..models.errors import BadInput
from . import factors, freerun
from .base import CannotFit, Fit, FitFailed, Method
from .series import Series, series_of
from .starts import starts_of

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model

GOOD, ADEQUATE = 1.5, 3.0
"""Residual over sensor noise at which the search ends, and below which a model counts as explaining the records."""
ROUGH, FINE = 1.0, 1e-6
"""Promised gain in log likelihood at which the search among starts stops, and at which the last minimum does."""
SHARE = 1e-3
"""Share of the cost whose promise is not worth another step while channels are weighed by their sensors."""
STARTS = 2
"""Least-squares starts that are followed up."""
HORIZONS = (32, 8, 2)
"""Parts into which records are cut for the growing horizons."""
SHORTEST_HORIZON = 16
RELATIVE_FLOOR = 1e-13
"""Smallest residual counted, relative to the channel's size."""
NULL = 1e-12
"""Singular values (columns of unit length) below which a direction counts as not identified."""


@dataclass(frozen=True)
class Problem:
    """What is minimised: runs along `series`, their initial states `free` to move, channels weighted by their residual.

    Unknowns z are the p coefficients and then the free initial states of each series in turn.
    """

    model: Model
    series: tuple[Series, ...]
    free: tuple[tuple[int, ...], ...]
    sensor: np.ndarray | None = None
    """(n,) standard deviations to weigh the channels by; None: each by its residual, as maximum likelihood has it."""

    @property
    def p(self) -> int:
        return len(self.model.coordinates)

    @property
    def width(self) -> int:
        return self.p + sum(map(len, self.free))

    @property
    def counts(self) -> np.ndarray:
        """Measured values (n,) of each state."""
        total = np.zeros(len(self.model.states))
        for s in self.series:
            np.add.at(total, s.columns, np.isfinite(s.outputs).sum(axis=0))
        return total

    @property
    def floors(self) -> np.ndarray:
        """(n,) squared residual below which a channel's fit is not improved any more."""
        size = np.zeros(len(self.model.states))
        for s in self.series:
            np.maximum.at(size, s.columns, np.nanmax(np.abs(s.outputs), axis=0))
        return (RELATIVE_FLOOR * np.maximum(size, 1e-9)) ** 2

    def start(self, coefficients: np.ndarray) -> np.ndarray:
        """Unknowns (width,) from coefficients and the records' initial states."""
        own = [s.start[list(free)] for s, free in zip(self.series, self.free, strict=True)]
        return np.concatenate([coefficients, *own])

    def unpack(self, z: np.ndarray):
        """The model, and for each series its initial state and the place of its unknowns."""
        model, place, runs = self.model.with_coefficients(z[: self.p]), self.p, []
        for s, free in zip(self.series, self.free, strict=True):
            state = s.start.copy()
            state[list(free)] = z[place : place + len(free)]
            runs.append((s, state, free, place))
            place += len(free)
        return model, runs

    def squares(self, z: np.ndarray) -> np.ndarray:
        """Sum of squared residuals (n,) of each state's channel; inf where a run diverges."""
        model, runs = self.unpack(z)
        total = np.zeros(len(self.model.states))
        for s, state, _, _ in runs:
            np.add.at(total, s.columns, freerun.squares(model, s, state))
        return total

    def cost(self, squares: np.ndarray) -> float:
        """Negative log likelihood: sum of N/2 log(S/N), or of S/2 in units of the sensors' variance."""
        used = self.counts > 0
        counts, squares = self.counts[used], squares[used]
        with np.errstate(all="ignore"):
            if self.sensor is not None:
                value = 0.5 * np.sum(squares / self.sensor[used] ** 2)
            else:
                value = 0.5 * np.sum(counts * np.log(squares / counts + self.floors[used]))
        return float(value) if np.isfinite(value) else np.inf

    def weights(self, squares: np.ndarray) -> np.ndarray:
        """(n,) reciprocal standard deviation of each channel."""
        if self.sensor is not None:
            return 1.0 / self.sensor
        return 1.0 / np.sqrt(squares / np.maximum(self.counts, 1.0) + self.floors)

    def factor(self, z: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """Triangular factor (width + 1, width + 1) of the weighted [derivatives | residuals]."""
        model, runs = self.unpack(z)
        rows = [factors.empty(self.width)]
        for s, state, free, place in runs:
            for column, own in zip(s.columns, freerun.output_factors(model, s, state, free), strict=True):
                rows.append(weights[column] * freerun.embed(own, self.p, place, self.width))
        return factors.fold(factors.empty(self.width), np.vstack(rows))


class Minimum(NamedTuple):
    """Where `levenberg_marquardt` stopped."""

    z: np.ndarray
    cost: float
    squares: np.ndarray
    converged: bool
    n_iterations: int


class _Linear(NamedTuple):
    """The weighted problem about one point, in columns of unit length: singular values (m,), and what they meet."""

    singular: np.ndarray
    projected: np.ndarray
    back: np.ndarray
    """(width, m): from singular coordinates to steps of the unknowns."""

    def step(self, damping: float) -> np.ndarray:
        return self.back @ (self.singular / (self.singular**2 + damping) * self.projected)

    def promise(self, damping: float) -> float:
        """Decrease of half the sum of squares that the damped step promises."""
        left = damping / (self.singular**2 + damping)
        return float(0.5 * np.sum(self.projected**2 * (1.0 - left**2)))


def _linear(factor: np.ndarray) -> _Linear:
    a, b = factor[:, :-1], factor[:, -1]
    length = np.linalg.norm(a, axis=0)
    length = np.where(length > 0.0, length, 1.0)
    u, s, vt = np.linalg.svd(a / length, full_matrices=False)
    kept = s > NULL * s[0]
    return _Linear(s[kept], (u.T @ b)[kept], vt[kept].T / length[:, None])


def levenberg_marquardt(problem: Problem, z: np.ndarray, most: int, gain: float = FINE) -> Minimum:
    """Minimise the problem's cost from z (width,); never leaves it worse.

    It has converged when the damped linear problem promises less than `gain` in log likelihood, or when no step lowers
    the cost although it promises only what rounding can hide.
    """
    squares = problem.squares(z)
    cost, damping = problem.cost(squares), 1e-3
    for iteration in range(most):
        if not np.isfinite(cost):
            return Minimum(z, np.inf, squares, False, iteration)
        enough = max(gain, SHARE * cost) if problem.sensor is not None else gain
        factor = problem.factor(z, problem.weights(squares))
        if not np.isfinite(factor).all():
            return Minimum(z, cost, squares, False, iteration)
        linear = _linear(factor)
        easier = 0.01  # less damping after a step that is taken at once, as much after one that takes several trials
        while True:
            step, promise = linear.step(damping), linear.promise(damping)
            trial = problem.squares(z + step)
            lower = problem.cost(trial)
            if lower < cost or promise < enough:
                break
            damping, easier = max(5.0 * damping, 1e-10), 1.0
        if not lower < cost:
            return Minimum(z, cost, squares, True, iteration + 1)
        good = cost - lower > 0.7 * promise
        z, squares, cost = z + step, trial, lower
        damping *= easier if good else max(easier, 0.3)
        if promise < enough:
            return Minimum(z, cost, squares, True, iteration + 1)
    return Minimum(z, cost, squares, False, most)


def held(series: Sequence[Series], model: Model) -> Problem:
    """The problem in which runs start where the records start; heading counts only where nothing else is measured."""
    heading = model.states.index("psi")
    chosen = tuple(s if set(s.columns) == {heading} else s.without(heading) for s in series)
    return Problem(model, chosen, tuple(_unmeasured(s, model) for s in chosen))


def _unmeasured(series: Series, model: Model) -> tuple[int, ...]:
    """States without a channel: surge, sway and yaw rate, but not the hidden one, which starts from a steady turn."""
    return tuple(i for i, name in enumerate(model.states) if name in ("u", "v", "r") and i not in series.columns)


def released(series: Sequence[Series], model: Model) -> Problem:
    """The problem with all channels and free initial states."""
    free = [
        tuple(i for i, name in enumerate(model.states) if name in ("w", "u", "v", "r") or i in s.columns)
        for s in series
    ]
    return Problem(model, tuple(series), tuple(free))


def sensor_sd_of(problem: Problem) -> np.ndarray:
    """(n,) sensor noise of each state's channel, pooled over the records; above the rounding level."""
    total = np.zeros(len(problem.model.states))
    for s in problem.series:
        np.add.at(total, s.columns, s.noise**2 * np.isfinite(s.outputs).sum(axis=0))
    return np.sqrt(total / np.maximum(problem.counts, 1.0) + 100.0 * problem.floors)


def adequate(problem: Problem, squares: np.ndarray, times: float) -> bool:
    """Whether every channel's residual is within `times` its sensor noise."""
    allowed = times**2 * sensor_sd_of(problem) ** 2 * problem.counts
    return bool(np.all(squares[problem.counts > 0] <= allowed[problem.counts > 0]))


class Outcome(NamedTuple):
    """A fitted problem."""

    problem: Problem
    minimum: Minimum
    adequate: bool
    n_attempts: int
    n_iterations: int


def fit_output_error(series: Sequence[Series], model: Model, starts: Sequence[np.ndarray], most: int = 60) -> Outcome:
    """Output-error fit from several starts; the first that explains the records well ends the search.

    Parameters
    ----------
    series : the records, with all the channels they have.
    starts : coefficients (p,).
    most : iterations of one minimisation.

    Raises
    ------
    FitFailed : if the model diverges from every start.
    """
    free = released(series, model)
    weighed = replace(free, sensor=sensor_sd_of(free))
    tried: list[np.ndarray] = []
    found: list[Minimum] = []
    ranked = _ranked(weighed, starts)
    for growing, start in [(growing, start) for growing in (False, True) for start in ranked]:
        coefficients, count = _grown(weighed, start) if growing else (start, 0)
        tried.append(coefficients)
        found.append(_released_fit(free, weighed, coefficients, most, count))
        if found[-1].converged and adequate(free, found[-1].squares, GOOD):
            return _finished(free, found[-1], True, found, most)
        if _agree(found) and not adequate(free, found[-1].squares, ADEQUATE):
            break
    best = min(found, key=lambda minimum: minimum.cost)
    if adequate(free, best.squares, ADEQUATE):
        return _finished(free, best, True, found, most)
    fixed = held(series, model)
    bound = [levenberg_marquardt(fixed, fixed.start(c), (most + 1) // 2, ROUGH) for c in tried]
    best = min(bound, key=lambda minimum: minimum.cost)
    if not np.isfinite(best.cost):
        raise FitFailed("the simulation diverges from every start")
    return _finished(fixed, best, False, found + bound, most)


def _agree(found: Sequence[Minimum], nats: float = 10.0) -> bool:
    """Whether the last two minima are the same one, to what a rough search can tell."""
    return len(found) > 1 and abs(found[-1].cost - found[-2].cost) < nats


def _released_fit(free: Problem, weighed: Problem, start: np.ndarray, most: int, count: int) -> Minimum:
    """A first minimum of the problem with free initial states; `count` iterations went before.

    Channels are weighed by their sensors' noise first: weights that follow the residuals would favour a channel that
    fits already over one that does not yet.
    """
    near = levenberg_marquardt(weighed, free.start(start), most, ROUGH)
    count += near.n_iterations
    if not adequate(free, near.squares, 2.0 * ADEQUATE):
        return near._replace(cost=free.cost(near.squares), n_iterations=count)
    found = levenberg_marquardt(free, near.z, most, ROUGH)
    return found._replace(n_iterations=count + found.n_iterations)


def _finished(problem: Problem, best: Minimum, explained: bool, found: Sequence[Minimum], most: int) -> Outcome:
    """The outcome, with the last digits of the best of the minima found."""
    last = levenberg_marquardt(problem, best.z, most)
    return Outcome(problem, last, explained, len(found), sum(f.n_iterations for f in [*found, last]))


def _ranked(problem: Problem, starts: Sequence[np.ndarray]) -> list[np.ndarray]:
    """The STARTS best of the starts by the error of short runs from measured states; the first, if there are none."""
    short = _short(problem, HORIZONS[1])
    if short is None:
        return list(starts[:STARTS])
    costs = [short.cost(short.squares(start)) for start in starts]
    return [starts[i] for i in np.argsort(costs, kind="stable")[:STARTS]]


def _short(problem: Problem, pieces: int) -> Problem | None:
    """The problem with every record cut into pieces that start at measured states; None where that cannot be."""
    cut = [piece for s in problem.series for piece in _cut(s, problem.model, pieces)]
    return replace(problem, series=tuple(cut), free=((),) * len(cut)) if cut else None


def _grown(problem: Problem, coefficients: np.ndarray) -> tuple[np.ndarray, int]:
    """Coefficients fitted over growing horizons, and the iterations that took.

    Every state must be measured (the hidden one is differenced); else the start comes back as it is.
    """
    count = 0
    for pieces in HORIZONS:
        short = _short(problem, pieces)
        if short is not None:
            found = levenberg_marquardt(short, coefficients, 6, ROUGH)
            coefficients, count = found.z, count + found.n_iterations
    return coefficients, count


def _cut(series: Series, model: Model, pieces: int) -> list[Series]:
    """The series in `pieces` of equal length, each restarted from what is measured there."""
    n = len(series.outputs)
    length = max(n // pieces, SHORTEST_HORIZON)
    needed = [i for i, name in enumerate(model.states) if name in ("u", "v", "r")]
    if series.part.any() or length >= n or not set(needed) <= set(series.columns.tolist()):
        return []
    edges = list(range(0, n - length + 1, length))
    return [piece for a in edges if (piece := _stretch(series, model, a, min(a + length, n - 1))) is not None]


def _stretch(series: Series, model: Model, a: int, b: int) -> Series | None:
    """Samples a..b as a series of their own; None if a state is missing about a.

    The initial state is the value at a of a straight line through the samples around it, which also gives the
    yaw acceleration that stands for the hidden state.
    """
    window = max(2, len(series.outputs) // 400)
    near = slice(max(a - window, 0), a + window + 1)
    time = (series.index[near] - series.index[a]) * series.dt
    value, slope = _line(time, series.outputs[near])
    state = np.zeros(len(model.states))
    state[series.columns] = value
    if model.states[0] == "w":
        state[0] = slope[list(series.columns).index(model.states.index("r"))]
    if not np.isfinite(state).all() or b <= a:
        return None
    first, last = series.index[a], series.index[b]
    return replace(
        series,
        inputs=np.ascontiguousarray(series.inputs[first : last + 1]),
        outputs=series.outputs[a : b + 1],
        index=series.index[a : b + 1] - first,
        part=series.part[a : b + 1],
        start=state,
    )


def _line(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Value at zero (c,) and slope (c,) of straight lines through values (m, c); nan where one is a gap."""
    middle = time.mean()
    slope = (time - middle) @ values / np.sum((time - middle) ** 2)
    return values.mean(axis=0) - slope * middle, slope


class OutputError(Method):
    """Output error by multi-start Levenberg-Marquardt on generated sensitivities; initial states are nuisances.

    Parameters
    ----------
    max_iterations : of one minimisation.

    Records need the rudder and at least one of yaw rate, heading, surge and sway.  `extra` says which channels were
    fitted, whether initial states were estimated, and the residual of each channel.
    """

    name = "output-error"
    title = "output error: free run against the record, multi-start Levenberg-Marquardt"

    def __init__(self, max_iterations: int = 60) -> None:
        self.max_iterations = max_iterations

    def check_options(self) -> None:
        super().check_options()
        if self.max_iterations < 1:
            raise BadInput(f"max_iterations is {self.max_iterations!r}, at least 1 is needed")

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        series = [series_of(record, model) for record in records]
        if (n := sum(s.n_outputs for s in series)) <= len(model.coordinates):
            raise CannotFit(f"{n} measured values for {len(model.coordinates)} coefficients")
        starts = [start.coefficients for start in starts_of(records, model)]
        outcome = fit_output_error(series, model, starts, self.max_iterations)
        return _fit(outcome)


def _fit(outcome: Outcome) -> Fit:
    problem, minimum = outcome.problem, outcome.minimum
    p, names = problem.p, problem.model.states
    solution = factors.solve(problem.factor(minimum.z, problem.weights(minimum.squares)), NULL)
    sd = np.sqrt(minimum.squares / np.maximum(problem.counts, 1.0))
    used = np.flatnonzero(problem.counts)
    return Fit(
        minimum.z[:p],
        solution.covariance[:p, :p],
        converged=minimum.converged,
        message=_message(outcome, solution.rank),
        n_iterations=outcome.n_iterations,
        extra={
            "channels": [names[i] for i in used],
            "residual_sd": {names[i]: float(sd[i]) for i in used},
            "explains_records": outcome.adequate,
            "initial_states": "estimated" if outcome.adequate else "record",
            "attempts": outcome.n_attempts,
            "cost": minimum.cost,
        },
    )


def _message(outcome: Outcome, rank: int) -> str:
    said = [] if outcome.adequate else ["residuals exceed the sensor noise: the model does not explain the records"]
    if rank < outcome.problem.width:
        said.append(f"the records determine {rank} of {outcome.problem.width} directions")
    if not outcome.minimum.converged:
        said.append("stopped before convergence")
    return "; ".join(said)
