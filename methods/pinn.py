"""A model's coefficients and networks of time found together, from the records and from the model's equations.

With the states x(t) of the networks, the measured channels y_c with the standard deviation sd_c, and the
root mean square q_i of the rate of every state,

    J = sum_c sum_k (x_c(t_k) - y_c(t_k))^2 / sd_c^2 + weight sum_i sum_j (dx_i/dt - f_i(x, u, theta))^2(t_j) / q_i^2

is minimised over the output weights of all networks and theta.  Collocation times t_j are the points of the record's
grid, where the inputs are as recorded; velocities, yaw rate and heading are states of the networks, positions, of which
no rate depends, are not.  f and its derivatives are those of the model's compiled kernels.

Raissi, Perdikaris & Karniadakis 2019 (J. Comput. Phys. 378, 686) minimise J by Adam and L-BFGS.  The residuals are
linear in the weights but for f's non-linearity, and in theta too, so that Levenberg-Marquardt steps end after about ten
iterations, also along the directions of which a record says little; the weights of each network are eliminated from a
step by orthogonal transformations (`likelihood.linear_problem`).

Networks are local.  Within a window of a record the states are

    x(t) = m + s (sum_k W_k tanh(SLOPE (t - c_k) / h) + W_0 + sum_j V_j g_j(t)),    g_j(t) = integral of u(t)^j

with units at equal distances h, so that each is the transition of one short stretch of time.  A network whose units
begin at random learns a record of many zigzag legs only in its lowest frequencies; the spread of Nguyen & Widrow 1990
(Proc. IJCNN, 3, 21) has all that the distance h allows from the beginning.  The integrals of powers of the inputs are
features of time too: the rudder is known, and where its rate jumps, so does the slope of an acceleration, which smooth
units would need many of.  The hidden layer stays as it is and the output weights W, V are trained: a physics-informed
extreme learning machine (Dwivedi & Srinivasan 2020, Neurocomputing 391, 96).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..datasets.record import Record
from ..estimation.likelihood.linear_problem import Arrow, LinearArrow, RecordRows
from ..estimation.numerics import factors
from ..estimation.observers.smoothing import smoothed_states
from ..estimation.records.gaps import unbroken_series
from ..estimation.records.series import Series
from ..estimation.regression.starts import starts_of
from ..estimation.results.fit import Fit
from ..models.errors import FitFailed
from ..models.linear_algebra import ridge
from ..models.model import Model
from .base import method
from .options import POSITIVE, number, option, whole


@method(
    "pinn",
    "inverse physics-informed neural network: states as networks of time, held to the model's equations",
    minutes=True,
    brief={"spacing": 8.0, "iterations": 4},
)
def Pinn(
    records: Sequence[Record],
    model: Model,
    weight: float = option(
        1e4,
        "of the equations: 1e4 takes an error of 1 % of a state's rate as seriously as one standard deviation of a "
        "sensor",
        POSITIVE,
    ),
    spacing: float = option(
        1.5, "samples for each hidden unit", number("a number of at least 1", lambda value: value >= 1.0)
    ),
    iterations: int = option(40, "at most", whole(1)),
) -> Fit:
    """Networks of time that follow the records and the model's equations, the coefficients found with their weights.

        min sum ((x(t_k) - y_k)/sd)^2 + weight sum ((dx/dt - f(x, u, theta))(t_j)/q)^2

    Raissi, Perdikaris & Karniadakis 2019, J. Comput. Phys. 378, 686 (inverse problem).  The networks are local, one for
    each 200 steps of a record; their hidden layer of tanh units is spread evenly over time and not trained, the
    integrals of the inputs are features beside it, and the minimum is found by Levenberg-Marquardt steps.

    Standard errors are those with the networks free, for white errors of the sensors and of the equations.  No
    network knows where the one before it ended, so records whose 200 steps are shorter than the ship's time constants
    give less than they do to a free run (`output-error`).
    """
    problem, theta = _prepared(records, model, weight, spacing)
    return _minimised(problem, theta, iterations)


SLOPE = 0.8
"""Slope of a unit per distance of units: the sum of the slopes of all is level to 1e-4."""
BEYOND = 1.5
"""Distance to which units lie outside the window, in steps."""
POWERS = 3
"""Powers of the inputs whose integrals are features."""


class Features(NamedTuple):
    """The hidden layer at T times: values (T, f) and slopes (T, f), 1/s."""

    values: np.ndarray
    slopes: np.ndarray


def features_of(window: tuple[int, int, int], dt: float, inputs: np.ndarray, place: np.ndarray) -> Features:
    """The hidden layer of a window.

    Parameters
    ----------
    window : first and last row of the series' grid, and the number of its units.
    inputs : (M + 1, nu) of the whole grid, in units of their size, dt seconds apart and linear in between.
    place : (T,) times in grid steps.
    """
    first, last, units = window
    distance = (last - first + 2.0 * BEYOND) / max(units - 1, 1)
    centre = np.linspace(first - BEYOND, last + BEYOND, units)
    bend = np.tanh(SLOPE / distance * (place[:, None] - centre))
    rise = SLOPE / (distance * dt) * (1.0 - bend**2)
    grid = np.arange(first, last + 1)
    part = inputs[first : last + 1]
    sums, powers = _integrals(part), np.hstack([part**power for power in range(1, POWERS + 1)])
    known = np.column_stack([np.interp(place, grid, column) for column in sums.T]) / distance
    slopes = np.column_stack([np.interp(place, grid, column) for column in powers.T]) / (distance * dt)
    one = np.ones((len(place), 1))
    return Features(np.hstack([bend, one, known]), np.hstack([rise, 0.0 * one, slopes]))


def _integrals(inputs: np.ndarray) -> np.ndarray:
    """Integrals of u, u^2, ... per step (M + 1, POWERS nu), exact at the grid for inputs that are linear in between."""
    a, b = inputs[:-1], inputs[1:]
    means = [sum(a**i * b ** (power - i) for i in range(power + 1)) / (power + 1) for power in range(1, POWERS + 1)]
    return np.vstack([np.zeros((1, POWERS * inputs.shape[1])), np.cumsum(np.hstack(means), axis=0)])


@dataclass(frozen=True)
class PinnEquations:
    """A model's equations with positions left out: `kept` (n,) are the places of the other states among all."""

    model: Model
    kept: tuple[int, ...]

    @classmethod
    def of(cls, model: Model) -> PinnEquations:
        """The equations of a model, whose coefficients are not used."""
        return cls(model, tuple(i for i, name in enumerate(model.states) if name not in ("x", "y")))

    @property
    def names(self) -> list[str]:
        """Symbols of the states."""
        return [self.model.states[k] for k in self.kept]

    def rates(self, states: np.ndarray, inputs: np.ndarray, theta: np.ndarray) -> np.ndarray:
        """Rates (T, n) at states (T, n), inputs (T, nu) and coefficients (p,)."""
        from ..models.simulate import accelerations

        return accelerations(self.model.with_coefficients(theta), self._whole(states), inputs)[:, self.kept]

    def derivatives(
        self, states: np.ndarray, inputs: np.ndarray, theta: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The same, with their derivatives by the states (T, n, n) and by the coefficients (T, n, p)."""
        from ..models.simulate import slopes_at

        kept, model = list(self.kept), self.model.with_coefficients(theta)
        rates, by_state, _, by_theta = slopes_at(model, self._whole(states), inputs)
        return rates[:, kept], by_state[:, kept][:, :, kept], by_theta[:, kept]

    def _whole(self, states: np.ndarray) -> np.ndarray:
        """All states (T, m), the positions zero."""
        whole = np.zeros((len(states), len(self.model.states)))
        whole[:, self.kept] = states
        return whole


STEPS = 200
"""Most collocation intervals of a window."""
MOST_POINTS = 12_000
"""Collocation times of all records, beyond which every second, third, ... point of the grid is one."""
OUTSIDE = 4
"""Units of a window beside those at every `spacing` points."""
RELATIVE_SD = 1e-3
"""Least standard deviation of a channel, relative to the spread of its state: what a network does not follow."""
RIDGE = 1e-3
"""Penalty on the weights of the networks from which the fit starts."""
DAMPING, LEAST_DAMPING, MOST_DAMPING = 1e-6, 1e-14, 1e6
"""Damping of the first step, and its limits."""
ENDS = 1e-6
"""Relative decrease of J below which the fit ends."""


class PinnPart(NamedTuple):
    """A window of a record.

    inputs (C, nu) at the C collocation times, whose hidden layer is `at`; outputs (N, n), nan where not measured, at N
    times with the hidden layer `data`; start (C, n) the states from which the network starts.
    """

    inputs: np.ndarray
    at: Features
    outputs: np.ndarray
    data: np.ndarray
    start: np.ndarray


class PinnScales(NamedTuple):
    """Of the n states: mean and size (n,), root mean square rate (n,), noise of the sensors and sd of channels (n,)."""

    mean: np.ndarray
    size: np.ndarray
    rate: np.ndarray
    noise: np.ndarray
    sd: np.ndarray


@dataclass(frozen=True)
class PinnProblem:
    """The sum of squares J over the windows of all records."""

    equations: PinnEquations
    parts: tuple[PinnPart, ...]
    scales: PinnScales
    weight: float

    @cached_property
    def widths(self) -> list[int]:
        """Number of output weights of every network."""
        return [part.at.values.shape[1] * len(self.equations.kept) for part in self.parts]

    def residuals(self, theta: np.ndarray, weights: Sequence[np.ndarray]) -> list[tuple[np.ndarray, np.ndarray]]:
        """Residuals of every window, of the data (n, N), nan where not measured, and of the equations (n, C)."""
        found = []
        for part, w in zip(self.parts, weights, strict=True):
            rates = self.equations.rates(self._states(part, w), part.inputs, theta)
            found.append((self._misfit(part, w), self._off(part, w, rates)))
        return found

    def cost(self, theta: np.ndarray, weights: Sequence[np.ndarray]) -> float:
        """J at coefficients (p,) and output weights (f, n) of every window; inf where it is not finite."""
        total = sum(np.nansum(a**2) + np.sum(b**2) for a, b in self.residuals(theta, weights))
        return float(total) if np.isfinite(total) else np.inf

    def rows(self, theta: np.ndarray, weights: Sequence[np.ndarray]) -> list[tuple[np.ndarray, np.ndarray]]:
        """Of every window, rows (R, f n + p + 1) of [derivatives | right side], and the block (R,) of each: state i of
        the data i, of the equations n + i."""
        n, p, found = len(self.equations.kept), len(theta), []
        for part, w in zip(self.parts, weights, strict=True):
            rates, by_state, by_theta = self.equations.derivatives(self._states(part, w), part.inputs, theta)
            f, blocks, rows = len(w), [], []
            misfit, off = self._misfit(part, w), self._off(part, w, rates)
            scale = np.sqrt(self.weight) / self.scales.rate
            for i in range(n):
                known = np.isfinite(misfit[i])
                own = np.zeros((int(known.sum()), f, n))
                own[:, :, i] = part.data[known] * (self.scales.size[i] / self.scales.sd[i])
                rows.append(np.column_stack([own.reshape(-1, f * n), np.zeros((len(own), p)), -misfit[i, known]]))
                blocks.append(np.full(len(own), i))
            for i in range(n):
                own = -part.at.values[:, :, None] * (by_state[:, None, i] * self.scales.size)
                own[:, :, i] += part.at.slopes * self.scales.size[i]
                rows.append(scale[i] * np.column_stack([own.reshape(-1, f * n), -by_theta[:, i], -off[i] / scale[i]]))
                blocks.append(np.full(len(own), n + i))
            found.append((np.vstack(rows), np.concatenate(blocks)))
        return found

    def _states(self, part: PinnPart, w: np.ndarray) -> np.ndarray:
        """States (C, n) of a window's network at its collocation times."""
        return self.scales.mean + self.scales.size * (part.at.values @ w)

    def _misfit(self, part: PinnPart, w: np.ndarray) -> np.ndarray:
        found = self.scales.mean + self.scales.size * (part.data @ w)
        return ((found - part.outputs) / self.scales.sd).T

    def _off(self, part: PinnPart, w: np.ndarray, rates: np.ndarray) -> np.ndarray:
        slopes = self.scales.size * (part.at.slopes @ w)
        return (np.sqrt(self.weight) * (slopes - rates) / self.scales.rate).T


def _prepared(records: Sequence[Record], model: Model, weight: float, spacing: float) -> tuple[PinnProblem, np.ndarray]:
    records, series = unbroken_series(records, model, len(model.coordinates))
    equations = PinnEquations.of(model)
    smooth = [_smooth(record, s, equations) for record, s in zip(records, series, strict=True)]
    theta, states, rate = _best_start(records, series, equations, smooth)
    parts = [
        part for s, x in zip(series, states, strict=True) for part in _parts(s, x, equations.kept, series, spacing)
    ]
    return PinnProblem(equations, tuple(parts), _scales(series, equations.kept, np.vstack(states), rate), weight), theta


def _smooth(record: Record, series: Series, equations: PinnEquations) -> np.ndarray:
    """States (M + 1, n) on the grid, smoothed from the record; q in the place of w, and the initial state where it
    measures none."""
    times = record.time_s[0] + series.dt * np.arange(len(series.inputs))
    found = smoothed_states(record, times)
    found |= {"w": found["q"]} if "q" in found else {}
    columns = zip(equations.kept, equations.names, strict=True)
    return np.column_stack([found.get(name, np.full(len(times), series.start[k])) for k, name in columns])


def _best_start(
    records: Sequence[Record], series: Sequence[Series], equations: PinnEquations, smooth: list[np.ndarray]
) -> tuple[np.ndarray, list[np.ndarray], np.ndarray]:
    """The least-squares start (p,) whose equations the smoothed states keep best, with the states (M + 1, n) of every
    record, and the root mean square of their rates (n,)."""
    gain, best = equations.model.kernels.RATE_GAIN, None
    for start in starts_of(records, equations.model):
        theta, states = start.coefficients, smooth
        if gain is not None:
            shift = np.eye(len(equations.kept))[equations.names.index("w")] * theta[gain]
            states = [x - shift * s.inputs[:, :1] for x, s in zip(smooth, series, strict=True)]
        slopes = np.vstack([np.gradient(x, s.dt, axis=0) for x, s in zip(states, series, strict=True)])
        pairs = zip(states, series, strict=True)
        rates = np.vstack([equations.rates(x, s.inputs, theta) for x, s in pairs])
        size = np.sqrt(np.mean(slopes**2, axis=0))
        size = factors.divisors(np.where(size > 0.0, size, np.sqrt(np.mean(rates**2, axis=0))))
        cost = float(np.sum(((slopes - rates) / size) ** 2))
        if np.isfinite(cost) and (best is None or cost < best[0]):
            best = cost, theta, states, size
    if best is None:
        raise FitFailed("the equations are not finite at any start")
    return best[1:]


def _scales(series: Sequence[Series], kept: Sequence[int], states: np.ndarray, rate: np.ndarray) -> PinnScales:
    size = np.maximum(states.std(axis=0), np.max([s.start_sd[list(kept)] for s in series], axis=0))
    size = np.where(size > 0.0, size, 1.0)
    squares, counts = np.zeros(len(kept)), np.zeros(len(kept))
    for s in series:
        for noise, column, known in zip(s.noise, s.columns, s.known.sum(axis=0), strict=True):
            squares[kept.index(column)] += known * noise**2
            counts[kept.index(column)] += known
    noise = np.sqrt(squares / np.maximum(counts, 1.0))
    return PinnScales(states.mean(axis=0), size, rate, noise, np.hypot(noise, RELATIVE_SD * size))


def _parts(
    series: Series, states: np.ndarray, kept: Sequence[int], every: Sequence[Series], spacing: float
) -> list[PinnPart]:
    """The windows of a record with states (M + 1, n) to start from."""
    stride = -(-sum(len(s.inputs) for s in every) // MOST_POINTS)
    largest = np.max([np.abs(s.inputs).max(axis=0) for s in every], axis=0)
    inputs = series.inputs / np.where(largest > 0.0, largest, 1.0)
    last, place, found = len(inputs) - 1, series.index + series.part, []
    edges = np.linspace(0, last, -(-last // (STEPS * stride)) + 1).round().astype(int)
    for i, (a, b) in enumerate(zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True)):
        times = np.arange(a, b + 1, stride)
        window = a, b, round((b - a) / (spacing * stride)) + OUTSIDE
        chosen = (place >= a) & ((place < b) | (i == len(edges) - 2))
        outputs = np.full((int(chosen.sum()), len(kept)), np.nan)
        outputs[:, [kept.index(column) for column in series.columns]] = series.outputs[chosen]
        at = features_of(window, series.dt, inputs, times.astype(float))
        data = features_of(window, series.dt, inputs, place[chosen]).values
        found.append(PinnPart(series.inputs[times], at, outputs, data, states[times]))
    return found


def _first_weights(problem: PinnProblem) -> list[np.ndarray]:
    """Output weights of networks that follow the states to start from."""
    scales = problem.scales
    return [ridge(part.at.values, (part.start - scales.mean) / scales.size, RIDGE) for part in problem.parts]


def _minimised(problem: PinnProblem, theta: np.ndarray, iterations: int) -> Fit:
    weights, p = _first_weights(problem), len(theta)
    places = p + np.concatenate([[0], np.cumsum(problem.widths)])
    cost, damping, converged, count = problem.cost(theta, weights), DAMPING, False, 0
    if not np.isfinite(cost):
        raise FitFailed("the networks are not finite at the start")
    while count < iterations and not converged:
        count += 1
        linear = LinearArrow(_arrow(problem, theta, weights, places))
        while True:
            step, _ = linear.step(damping)
            moved = [w + step[a:b].reshape(w.shape) for w, a, b in zip(weights, places[:-1], places[1:], strict=True)]
            ahead = problem.cost(theta + step[:p], moved)
            if ahead <= cost or damping > MOST_DAMPING:
                break
            damping *= 10.0
        converged = not ahead < (1.0 - ENDS) * cost
        if ahead <= cost:
            theta, weights, cost, damping = theta + step[:p], moved, ahead, max(damping / 10.0, LEAST_DAMPING)
    return _as_fit(problem, theta, weights, converged, count)


def _arrow(problem: PinnProblem, theta: np.ndarray, weights: Sequence[np.ndarray], places: np.ndarray) -> Arrow:
    """The factor of the residuals at a point.

    Raises
    ------
    FitFailed : it is not finite.
    """
    parts = [
        RecordRows(int(place), width, rows)
        for (rows, _), place, width in zip(problem.rows(theta, weights), places[:-1], problem.widths, strict=True)
    ]
    arrow = Arrow.of(parts, factors.empty(len(theta)))
    if not arrow.finite:
        raise FitFailed("the derivatives of the equations are not finite")
    return arrow


def _as_fit(problem: PinnProblem, theta: np.ndarray, weights: Sequence[np.ndarray], converged: bool, count: int) -> Fit:
    n, p, names = len(problem.equations.kept), len(theta), problem.equations.names
    residuals = problem.residuals(theta, weights)
    data, equations = (np.hstack(parts) for parts in zip(*residuals, strict=True))
    measured = np.flatnonzero(np.isfinite(data).any(axis=1))
    noise = np.zeros(n)
    noise[measured] = np.nanmean(data[measured] ** 2, axis=1)
    noise = np.maximum(noise, (problem.scales.noise / problem.scales.sd) ** 2)
    variances = np.concatenate([noise, np.mean(equations**2, axis=1)])
    covariance, rank = _covariance(problem.rows(theta, weights), problem.widths, variances, p)
    lasting = np.sqrt(variances[n:] / problem.weight)
    return Fit(
        theta,
        covariance,
        converged=converged,
        message=factors.rank_message(rank, p) if converged else "the iterations ended before the fit had converged",
        n_iterations=count,
        extra={
            "networks": len(problem.parts),
            "weights": sum(problem.widths),
            "residual_sd": {
                names[i]: float(np.sqrt(np.nanmean(data[i] ** 2)) * problem.scales.sd[i]) for i in measured
            },
            "equations_off": dict(zip(names, lasting.tolist(), strict=True)),
        },
    )


def _covariance(
    rows: Sequence[tuple[np.ndarray, np.ndarray]], widths: Sequence[int], variances: np.ndarray, p: int
) -> tuple[np.ndarray, int]:
    """Covariance (p, p) of theta with the networks free, and the number of directions that are determined.

    With P the rows of theta's derivatives outside the space of the networks' weights, theta moves by (P'P)^-1 P' e when
    the residuals move by e; e is taken as white with the variance of its block (channel or equation).
    """
    factor, middle = factors.empty(p), np.zeros((p, p))
    for (values, blocks), width in zip(rows, widths, strict=True):
        q = np.linalg.qr(values[:, :width])[0]
        free = values[:, width:-1] - q @ (q.T @ values[:, width:-1])
        middle += free.T @ (free * variances[blocks, None])
        factor = factors.fold(factor, np.column_stack([free, np.zeros(len(free))]))
    solution = factors.solve(factor)
    bread = solution.half @ solution.half.T
    covariance = bread @ middle @ bread
    unknown = ~np.isfinite(np.diag(solution.covariance))
    covariance[unknown, unknown] = np.inf
    return (covariance + covariance.T) / 2.0, solution.rank
