"""Joint state and parameter estimation by an extended Kalman filter with a Rauch-Tung-Striebel smoother.

The coefficients are constant states.  One sample is predicted by one RK4 sample step with its generated sensitivities,
each measured channel is taken in by a scalar update in Joseph form, gaps are skipped.  The filter starts from least
squares and runs over the records several times: each pass starts from the last pass's coefficients with the first
prior, and from initial states smoothed with them.  Sensor noise is read off the records, process noise chosen by the
likelihood of the innovations.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np

from ..models.errors import BadInput
from .base import CannotFit, Fit, FitFailed, Method
from .ls import LeastSquares
from .rls import LONGEST_PATH
from .series import Series, noise_floor, series_of
from .starts import Start, starts_of
from .tuning.space import Real

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model

NARROWER = (1.0, 0.1, 0.01)
"""Factors on the prior's standard deviations, tried in turn while the filter diverges."""
PROCESS = tuple(10.0**k for k in range(-8, 1))
"""Process noise variances tried, as multiples of the mean square change of a state from sample to sample."""
COARSE = PROCESS[::4]
"""The same while starts are compared."""


class Belief(NamedTuple):
    """Coefficients c = origin + factor e, the e being estimated: mean (p,) and covariance (p, p).

    With factor factor' the prior covariance, e starts at zero with unit covariance.  Coefficients that all but cancel
    each other (condition 1e9 for S175's surge force) would cost the filter all its digits otherwise.
    """

    origin: np.ndarray
    factor: np.ndarray
    mean: np.ndarray
    covariance: np.ndarray

    @classmethod
    def prior(cls, origin: np.ndarray, factor: np.ndarray) -> Belief:
        return cls(origin, factor, np.zeros(len(origin)), np.eye(len(origin)))

    @classmethod
    def certain(cls, coefficients: np.ndarray) -> Belief:
        return cls(coefficients, np.zeros((len(coefficients), 0)), np.zeros(0), np.zeros((0, 0)))

    @property
    def coefficients(self) -> np.ndarray:
        return self.origin + self.factor @ self.mean

    @property
    def coefficient_covariance(self) -> np.ndarray:
        return self.factor @ self.covariance @ self.factor.T


class Pass(NamedTuple):
    """One run over all records."""

    belief: Belief
    path: np.ndarray
    innovations: list[np.ndarray]
    cost: float
    moved: float = np.inf
    """Largest change of a coefficient over the pass, in posterior standard deviations."""


class Noise(NamedTuple):
    """Variances of process (n,) per sample, which is `level` times the mean square change, and of the sensors (n,)."""

    level: float
    process: np.ndarray
    sensor: np.ndarray


def start_vector(model: Model, series: Series, belief: Belief) -> tuple[np.ndarray, np.ndarray]:
    """Joint vector (n + e,) and covariance; the hidden state w = q - c rudder moves with its coefficient c."""
    n, e = len(model.states), len(belief.mean)
    z = np.concatenate([series.start, belief.mean])
    covariance = np.zeros((n + e, n + e))
    covariance[:n, :n] = np.diag(series.start_sd**2)
    covariance[n:, n:] = belief.covariance
    gain = model.kernels.RATE_GAIN
    if gain is not None:
        rudder, turn = series.inputs[0, 0], np.eye(n + e)
        z[0] -= belief.coefficients[gain] * rudder
        turn[0, n:] = -rudder * belief.factor[gain]
        covariance = turn @ covariance @ turn.T
    return z, covariance


class Filtered(NamedTuple):
    """One record's run; `kept` holds what the smoother needs."""

    belief: Belief
    path: np.ndarray
    innovations: np.ndarray
    cost: float
    kept: tuple[np.ndarray, ...]


def run_filter(model: Model, series: Series, belief: Belief, noise: Noise, keep: bool = False) -> Filtered:
    """One record through the filter, from its initial state and from a belief about the coefficients."""
    from ..models.simulate import substeps, tangent_tables
    from . import _ekf_kernels

    n, p, e = len(model.states), len(model.coordinates), len(belief.mean)
    source, target, sparse = tangent_tables(model, range(p if e else 0), n)
    target = target + (n if e else 0)
    z, covariance = start_vector(model, series, belief)
    theta = np.concatenate([belief.coefficients, model.constants])
    grid = len(series.inputs) if keep else 0
    path, innovations = np.empty((len(series.outputs), p)), np.empty_like(series.outputs)
    kept = tuple(np.zeros((grid, n)) if i in (0, 2) else np.zeros((grid, n, n)) for i in range(5))
    cost = _ekf_kernels.kalman(
        model.kernels.tangent, z, theta, covariance, belief.origin, np.ascontiguousarray(belief.factor),
        series.inputs, series.outputs, np.round(series.index + series.part).astype(np.int64), series.columns,
        series.dt, substeps(model, series.dt), source, target, sparse, noise.process, noise.sensor[series.columns],
        path, innovations, *kept,
    )  # fmt: skip
    if not np.isfinite(z).all():
        cost = np.inf
    return Filtered(belief._replace(mean=z[n:], covariance=covariance[n:, n:]), path, innovations, cost, kept)


def joint_pass(model: Model, series: Sequence[Series], belief: Belief, noise: Noise) -> Pass:
    """All records in turn; what is known of the coefficients is carried over, states start anew."""
    paths, innovations, cost = [], [], 0.0
    for s in series:
        found = run_filter(model, s, belief, noise)
        belief, cost = found.belief, cost + found.cost
        paths.append(found.path)
        innovations.append(found.innovations)
    return Pass(belief, np.concatenate(paths), innovations, cost if np.isfinite(cost) else np.inf)


def smoothed_states(model: Model, series: Series, noise: Noise) -> np.ndarray:
    """States (K, n) on the record's grid given all its samples, with the model's coefficients held (RTS)."""
    from . import _ekf_kernels

    held = Belief.certain(model.coefficients)
    filtered, filtered_p, predicted, predicted_p, transitions = run_filter(model, series, held, noise, keep=True).kept
    live = [i for i, name in enumerate(model.states) if name not in ("x", "y")]
    block = np.ix_(range(len(filtered)), live, live)
    ahead = transitions[block][:-1] @ filtered_p[block][:-1]
    gains = np.linalg.solve(predicted_p[block][1:], ahead).transpose(0, 2, 1)
    smoothed = filtered.copy()
    inner = np.empty((len(filtered), len(live)))
    _ekf_kernels.smooth(
        np.ascontiguousarray(filtered[:, live]), np.ascontiguousarray(predicted[:, live]),
        np.ascontiguousarray(gains), inner,
    )  # fmt: skip
    smoothed[:, live] = inner
    return smoothed


def restarted(model: Model, series: Series, noise: Noise) -> Series:
    """The series with its initial state smoothed; unchanged if the smoother breaks down."""
    try:
        first = smoothed_states(model, series, noise)[0]
    except np.linalg.LinAlgError:
        return series
    gain = model.kernels.RATE_GAIN
    if gain is not None:
        first[0] += model.coefficients[gain] * series.inputs[0, 0]
    return replace(series, start=first) if np.isfinite(first).all() else series


def best_noise(
    model: Model,
    series: Sequence[Series],
    change: np.ndarray,
    sensor: np.ndarray,
    levels: Sequence[float] = PROCESS,
) -> tuple[float, Noise]:
    """Process noise from a grid of `levels` that makes the innovations likeliest at the model's coefficients, held.

    With the negative log likelihood (inf if the filter diverges with every one).
    """
    choices = [Noise(level, level * change, sensor) for level in levels]
    held = Belief.certain(model.coefficients)
    costs = np.array([sum(run_filter(model, s, held, noise).cost for s in series) for noise in choices])
    costs = np.where(np.isfinite(costs), costs, np.inf)
    best = int(np.argmin(costs))
    return float(costs[best]), choices[best]


def best_start(
    starts: Sequence[Start], model: Model, series: Sequence[Series], change: np.ndarray, sensor: np.ndarray
) -> Start:
    """The least-squares start whose innovations are likeliest."""
    costs = [best_noise(model.with_coefficients(s.coefficients), series, change, sensor, COARSE)[0] for s in starts]
    return starts[int(np.argmin(costs))]


def sensor_variances(series: Sequence[Series], n: int) -> np.ndarray:
    """(n,) mean variance of each state's sensor over the records, above the rounding level."""
    total, count = np.zeros(n), np.zeros(n)
    for s in series:
        floor = np.array([noise_floor(column) for column in s.outputs.T])
        np.add.at(total, s.columns, np.maximum(s.noise, floor) ** 2)
        np.add.at(count, s.columns, 1)
    return total / np.maximum(count, 1)


def changes(model: Model, series: Sequence[Series]) -> np.ndarray:
    """(n,) mean square change of each state over a sample, positions zero; unmeasured states from their prior."""
    n = len(model.states)
    total, count = np.zeros(n), np.zeros(n)
    for s in series:
        step = np.diff(s.outputs, axis=0)
        np.add.at(total, s.columns, np.nanmean(step**2, axis=0))
        np.add.at(count, s.columns, 1)
    spread = np.mean([s.start_sd**2 for s in series], axis=0)
    return np.where(count > 0, total / np.maximum(count, 1), 1e-2 * spread)


def prior_factor(found: LeastSquares, inflation: float) -> np.ndarray:
    """Factor (p, p) of the prior covariance about a least-squares start.

    The least-squares covariance widened by `inflation`, or further until it stands for accelerations wrong by a tenth
    of their size (Zellner's g-prior), which covers the bias of differences.  Along undetermined directions, a tenth of
    the coefficients.
    """
    ratio = found.left_rms / np.maximum(found.residual_sd, 1e-12 * found.left_rms)
    per_coefficient = found.n / len(found.coefficients)
    smallest = float(np.min(ratio, where=np.isfinite(ratio), initial=1e12))
    widened = max(inflation**2, 0.01 * per_coefficient * smallest**2)
    length = np.linalg.norm(found.null, axis=0)
    free = found.null / np.where(length > 0.0, length, 1.0) * (0.1 * np.linalg.norm(found.coefficients))
    return np.hstack([np.sqrt(widened) * found.half, free])


class Ekf(Method):
    """Joint extended Kalman filter with smoother, iterated.

    Parameters
    ----------
    passes : runs over all records.
    inflation : factor on the standard deviations of the least-squares start that make the prior.

    Records need the rudder and at least one of yaw rate, heading, surge and sway.  `extra` holds the innovations of
    the last pass (per record (N, c), in the order of `channels`) for one-step scores.
    """

    name = "ekf"
    title = "joint state and parameter extended Kalman filter with RTS smoother"
    search_space: ClassVar = {"inflation": Real(0.1, 1000.0, log=True)}
    order_matters = True

    def __init__(self, passes: int = 4, inflation: float = 5.0) -> None:
        self.passes, self.inflation = passes, inflation

    def check_options(self) -> None:
        super().check_options()
        if self.passes < 1:
            raise BadInput(f"passes is {self.passes!r}, at least 1 is needed")
        if not self.inflation > 0.0:
            raise BadInput(f"inflation is {self.inflation!r}, a positive number is needed")

    def joint_pass(self, model: Model, series: Sequence[Series], belief: Belief, noise: Noise) -> Pass:
        """One run of the joint filter over all records; relatives of the filter have their own."""
        return joint_pass(model, series, belief, noise)

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        series = [series_of(record, model) for record in records]
        if (n := sum(s.n_outputs for s in series)) <= len(model.coordinates):
            raise CannotFit(f"{n} measured values for {len(model.coordinates)} coefficients")
        sensor, change = sensor_variances(series, len(model.states)), changes(model, series)
        start = best_start(starts_of(records, model), model, series, change, sensor)
        model = model.with_coefficients(start.coefficients)
        prior = prior_factor(start.source, self.inflation)
        for narrower in NARROWER:
            done, model_then, series_then = run_passes(
                model, series, narrower * prior, change, sensor, self.passes, self.joint_pass
            )
            if done:
                return _fit(done, series_then, model_then, self.passes)
        raise FitFailed("the filter diverges in its first pass")


def run_passes(
    model: Model,
    series: Sequence[Series],
    prior: np.ndarray,
    change: np.ndarray,
    sensor: np.ndarray,
    passes: int,
    joint: Callable[[Model, Sequence[Series], Belief, Noise], Pass] = joint_pass,
) -> tuple[list[Pass], Model, list[Series]]:
    """Up to `passes` passes, as many as do not diverge; the model and the restarted series after the last."""
    done: list[Pass] = []
    series, levels = list(series), PROCESS
    for _ in range(passes):
        _, noise = best_noise(model, series, change, sensor, levels)
        levels = [level for level in PROCESS if 0.05 < level / noise.level < 20.0]
        found = joint(model, series, Belief.prior(model.coefficients, prior), noise)
        if not np.isfinite(found.cost):
            break
        done.append(found._replace(moved=_moved(found, model.coefficients)))
        model = model.with_coefficients(found.belief.coefficients)
        series = [restarted(model, s, noise) for s in series]
    return done, model, series


def _moved(found: Pass, before: np.ndarray) -> float:
    sd = np.sqrt(np.maximum(np.diag(found.belief.coefficient_covariance), 0.0))
    return float(np.max(np.abs(found.belief.coefficients - before) / np.where(sd > 0.0, sd, np.inf), initial=0.0))


def _fit(done: list[Pass], series: Sequence[Series], model: Model, passes: int) -> Fit:
    complete, moved = len(done) == passes, done[-1].moved
    path = np.concatenate([found.path for found in done])
    clock, passed = [], 0.0
    for s in list(series) * len(done):
        clock.append(passed + s.dt * (s.index + s.part))
        passed = clock[-1][-1]
    stride = max(1, -(-path.size // LONGEST_PATH))
    settled = complete and moved < 1.0
    return Fit(
        done[-1].belief.coefficients,
        done[-1].belief.coefficient_covariance,
        converged=settled,
        message="" if settled else "the coefficients still moved in the last pass" if complete else "a pass diverged",
        n_iterations=len(done),
        trajectory=path[::-stride][::-1],
        trajectory_time_s=np.concatenate(clock)[::-stride][::-1],
        extra={
            "channels": [[model.states[i] for i in s.columns] for s in series],
            "innovations": done[-1].innovations,
            "moved": moved,
            "cost": [found.cost for found in done],
        },
    )
