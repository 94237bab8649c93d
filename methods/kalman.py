"""Joint state and parameter estimation by a Kalman filter, iterated, with a smoother of the initial states.

The coefficients are constant states.  The filter starts from least squares and runs over the records several times:
each pass starts from the last pass's coefficients with the first prior, and from initial states smoothed with them.
Sensor noise is estimated from the records, process noise by the likelihood of the innovations.  One record is filtered
by the extended filter, or by the unscented one (Julier & Uhlmann 1997; Wan & van der Merwe 2000, scaled form).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..datasets.record import Record
from ..estimation.methods_only.tuning.space import Real
from ..estimation.numerics import factors
from ..estimation.records.gaps import unbroken_series
from ..estimation.records.series import Series, noise_floor
from ..estimation.regression.least_squares import LeastSquares
from ..estimation.regression.starts import Start, starts_of
from ..estimation.results.fit import LONGEST_PATH, Fit
from ..models.errors import FitFailed
from ..models.model import Model
from .base import method
from .options import POSITIVE, SHARE, number, option, whole

PASSES: Any = option(4, "runs over all records", whole(1))
INFLATION: Any = option(
    5.0,
    "factor on the standard deviations of the least-squares start that make the prior",
    POSITIVE,
    Real(0.1, 1000.0, log=True),
)


@method("ekf", "joint state and parameter extended Kalman filter", order_matters=True)
def Ekf(records: Sequence[Record], model: Model, passes: int = PASSES, inflation: float = INFLATION) -> Fit:
    """Joint extended Kalman filter, iterated, with a smoother of the initial states.

    Each sample is predicted by one RK4 sample step with its generated sensitivities; each measured channel is a scalar
    update in Joseph form, gaps are skipped.

    Records need the rudder and at least one of yaw rate, heading, surge and sway.  `extra` holds the innovations of
    the last pass (per record (N, c), in the order of `channels`) for one-step scores.
    """
    return joint_fit(records, model, passes, inflation)


@method("ukf", "joint state and parameter unscented Kalman filter", order_matters=True)
def Ukf(
    records: Sequence[Record],
    model: Model,
    passes: int = PASSES,
    inflation: float = INFLATION,
    alpha: float = option(
        0.1,
        "distance of the sigma points in units of sqrt(m) standard deviations, m being the size of the joint vector",
        SHARE,
        Real(1e-3, 1.0, log=True),
    ),
    beta: float = option(
        2.0,
        "weight of the mean's shift in the covariance; 2 for Gaussian densities",
        number("a number of at least 1", lambda value: value >= 1.0),
    ),
) -> Fit:
    """Joint unscented Kalman filter, iterated as `ekf` is.

    Starting values, sensor and process noise, and the initial states between passes are those of `ekf`.
    """
    return joint_fit(records, model, passes, inflation, (alpha, beta))


NARROWER = (1.0, 0.1, 0.01)
"""Factors on the prior's standard deviations, tried in turn while the filter diverges."""
PROCESS = tuple(10.0**k for k in range(-8, 1))
"""Process noise variances tried, as multiples of the mean square change of a state from sample to sample."""
COARSE = PROCESS[::4]
"""The same while starts are compared."""
NEAR = 20.0
"""Factor within which process noise levels are tried again in the next pass."""


class CoefficientDensity(NamedTuple):
    """Gaussian density of the coefficients c = origin + factor e: e has mean (m,) and covariance (m, m).

    With factor factor' the prior covariance, e starts at zero with unit covariance.  Without this scaling, coefficients
    that nearly cancel each other (condition 1e9 for S175's surge force) would cost the filter all its digits.
    """

    origin: np.ndarray
    factor: np.ndarray
    mean: np.ndarray
    covariance: np.ndarray

    @classmethod
    def prior(cls, origin: np.ndarray, factor: np.ndarray) -> CoefficientDensity:
        """The density before any measurement: coefficients origin (p,), covariance factor factor'."""
        return cls(origin, factor, np.zeros(len(origin)), np.eye(len(origin)))

    @classmethod
    def fixed(cls, coefficients: np.ndarray) -> CoefficientDensity:
        """Coefficients (p,) that are known exactly."""
        return cls(coefficients, np.zeros((len(coefficients), 0)), np.zeros(0), np.zeros((0, 0)))

    @property
    def coefficients(self) -> np.ndarray:
        """Mean coefficients (p,)."""
        return self.origin + self.factor @ self.mean

    @property
    def coefficient_covariance(self) -> np.ndarray:
        """Covariance (p, p) of the coefficients."""
        return self.factor @ self.covariance @ self.factor.T


class NoiseVariances(NamedTuple):
    """Variances of process (n,) per sample, `level` times the mean square change, and of the sensors (n,)."""

    level: float
    process: np.ndarray
    sensor: np.ndarray


class FilteredRecord(NamedTuple):
    """One record's run: the density after it, coefficients (N, p) and innovations (N, c) of each sample, and the
    negative log likelihood."""

    density: CoefficientDensity
    path: np.ndarray
    innovations: np.ndarray
    cost: float


def joint_start(model: Model, series: Series, density: CoefficientDensity) -> tuple[np.ndarray, np.ndarray]:
    """Joint vector (n + e,) and its covariance; the hidden state w = q - c rudder depends on its coefficient c."""
    n, e = len(model.states), len(density.mean)
    z = np.concatenate([series.start, density.mean])
    covariance = np.zeros((n + e, n + e))
    covariance[:n, :n] = np.diag(series.start_sd**2)
    covariance[n:, n:] = density.covariance
    gain = model.kernels.RATE_GAIN
    if gain is not None:
        rudder, jacobian = series.inputs[0, 0], np.eye(n + e)
        z[0] -= density.coefficients[gain] * rudder
        jacobian[0, n:] = -rudder * density.factor[gain]
        covariance = jacobian @ covariance @ jacobian.T
    return z, covariance


def filter_record(
    model: Model,
    series: Series,
    density: CoefficientDensity,
    noise: NoiseVariances,
    sigma: tuple[float, float] | None = None,
    start: tuple[np.ndarray, np.ndarray] | None = None,
) -> FilteredRecord:
    """One record through the filter, from its initial state and a density of the coefficients.

    Parameters
    ----------
    sigma : None: the extended filter.  Else the unscented one, whose density goes through a sample step at sigma points
        instead of along the tangent: their distance alpha in units of sqrt(m) standard deviations, m being the size of
        the joint vector, and the weight beta of the mean's shift in the covariance.
    start : states and constants that no coefficient depends on, with their covariance, instead of `joint_start`.
    """
    from ..models.simulate import substeps, tangent_tables

    n, p = len(model.states), len(model.coordinates)
    free = start is None and len(density.mean) > 0
    z, covariance = start or joint_start(model, series, density)
    path, innovations = np.empty((len(series.outputs), p)), np.empty_like(series.outputs)
    nearest = np.round(series.index + series.part).astype(np.int64)  # points of the time grid
    before = (
        z, np.concatenate([density.coefficients, model.constants]), covariance, density.origin,
        np.ascontiguousarray(density.factor), series.inputs, series.outputs, nearest, series.columns,
        series.dt, substeps(model, series.dt),
    )  # fmt: skip
    variances = noise.process, noise.sensor[series.columns]
    if sigma is None:
        from ..estimation.methods_only.filters._joint_kernels import kalman

        source, target, sparse = tangent_tables(model, range(p if free else 0), n)
        tables = source, target + (n if free else 0), sparse
        cost = kalman(model.kernels.tangent, *before, *tables, *variances, path, innovations)
    else:
        from ..estimation.methods_only.filters._unscented_kernels import unscented

        cost = unscented(model.kernels.rhs, *before, *variances, *sigma, path, innovations)
    after = density._replace(mean=z[n:], covariance=covariance[n:, n:])
    return FilteredRecord(after, path, innovations, cost if np.isfinite(z).all() else np.inf)


def smoothed_start(model: Model, series: Series, noise: NoiseVariances) -> np.ndarray:
    """Initial state (n,) given all samples of a record, the model's coefficients fixed.

    It is filtered along as a constant beside the states: the fixed-point smoother (Anderson & Moore 1979, Optimal
    Filtering, sec 7.2).
    """
    fixed = CoefficientDensity.fixed(model.coefficients)
    z, covariance = joint_start(model, series, fixed)
    beside = fixed._replace(factor=np.zeros((len(fixed.origin), len(z))), mean=np.zeros(len(z)))
    start = np.tile(z, 2), np.tile(covariance, (2, 2))
    return filter_record(model, series, beside, noise, start=start).density.mean


def with_smoothed_start(model: Model, series: Series, noise: NoiseVariances) -> Series:
    """The series with its initial state smoothed; unchanged where that is not finite."""
    first = smoothed_start(model, series, noise)
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
) -> tuple[float, NoiseVariances]:
    """Process noise of largest likelihood, and the negative log likelihood (inf if the filter diverges at every level).

    Parameters
    ----------
    change : (n,) mean square change of each state over a sample, of which the process variance is a multiple.
    sensor : (n,) sensor variances.
    levels : multiples tried, with the model's coefficients fixed.
    """
    choices = [NoiseVariances(level, level * change, sensor) for level in levels]
    fixed = CoefficientDensity.fixed(model.coefficients)
    costs = np.array([sum(filter_record(model, s, fixed, noise).cost for s in series) for noise in choices])
    costs = np.where(np.isfinite(costs), costs, np.inf)
    best = int(np.argmin(costs))
    return float(costs[best]), choices[best]


def best_start(
    starts: Sequence[Start], model: Model, series: Sequence[Series], change: np.ndarray, sensor: np.ndarray
) -> Start:
    """The least-squares start whose innovations have the largest likelihood."""
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


def square_changes(model: Model, series: Sequence[Series]) -> np.ndarray:
    """(n,) mean square change of each state over a sample, positions zero; of unmeasured states from their prior."""
    n = len(model.states)
    total, count = np.zeros(n), np.zeros(n)
    for s in series:
        step = np.diff(s.outputs, axis=0)
        np.add.at(total, s.columns, np.nanmean(step**2, axis=0))
        np.add.at(count, s.columns, 1)
    prior = np.mean([s.start_sd**2 for s in series], axis=0)
    return np.where(count > 0, total / np.maximum(count, 1), 1e-2 * prior)


def prior_factor(source: LeastSquares, inflation: float) -> np.ndarray:
    """Factor (p, p) of the prior covariance about a least-squares start.

    The least-squares covariance widened by `inflation`, or further until it stands for accelerations wrong by a tenth
    of their size (Zellner's g-prior), which covers the bias of differences.  Along undetermined directions, a tenth of
    the coefficients.
    """
    ratio = source.left_rms / np.maximum(source.residual_sd, 1e-12 * source.left_rms)
    per_coefficient = source.n / len(source.coefficients)
    smallest = float(np.min(ratio, where=np.isfinite(ratio), initial=1e12))
    widened = max(inflation**2, 0.01 * per_coefficient * smallest**2)
    undetermined = source.null / factors.column_lengths(source.null) * (0.1 * np.linalg.norm(source.coefficients))
    return np.hstack([np.sqrt(widened) * source.half, undetermined])


def joint_fit(
    records: Sequence[Record],
    model: Model,
    passes: int,
    inflation: float,
    sigma: tuple[float, float] | None = None,
) -> Fit:
    """Coefficients by up to `passes` passes of the joint filter over all records.

    Parameters
    ----------
    inflation : factor on the standard deviations of the least-squares start that make the prior.
    sigma : of the unscented filter, as in `filter_record`; None: the extended one.

    Raises
    ------
    CannotFit : a record lacks a channel, or there are no more measured values than coefficients.
    FitFailed : the filter diverges in its first pass.
    """
    records, series = unbroken_series(records, model, len(model.coordinates))
    sensor, change = sensor_variances(series, len(model.states)), square_changes(model, series)
    start = best_start(starts_of(records, model), model, series, change, sensor)
    model = model.with_coefficients(start.coefficients)
    prior = prior_factor(start.source, inflation)
    for narrower in NARROWER:
        done = run_passes(model, series, narrower * prior, change, sensor, passes, sigma)
        if done:
            return _as_fit(done, series, model, passes)
    raise FitFailed("the filter diverges in its first pass")


def run_passes(
    model: Model,
    series: Sequence[Series],
    prior: np.ndarray,
    change: np.ndarray,
    sensor: np.ndarray,
    passes: int,
    sigma: tuple[float, float] | None = None,
) -> list[tuple[list[FilteredRecord], float]]:
    """Up to `passes` passes, as many as do not diverge, with the largest change of a coefficient over each.

    The change is in posterior standard deviations.

    prior (p, p) is the factor of the prior covariance, change (n,) and sensor (n,) as in `best_noise`.
    """
    done: list[tuple[list[FilteredRecord], float]] = []
    series, levels = list(series), PROCESS
    for _ in range(passes):
        _, noise = best_noise(model, series, change, sensor, levels)
        levels = [level for level in PROCESS if 1.0 / NEAR < level / noise.level < NEAR]
        density, found = CoefficientDensity.prior(model.coefficients, prior), []
        for s in series:  # the density of the coefficients is carried over, the states start from each record
            found.append(filter_record(model, s, density, noise, sigma))
            density = found[-1].density
        if not np.isfinite([one.cost for one in found]).all():
            break
        after = found[-1].density
        moved = largest_change(after.coefficients - model.coefficients, after.coefficient_covariance)
        done.append((found, moved))
        model = model.with_coefficients(after.coefficients)
        series = [with_smoothed_start(model, s, noise) for s in series]
    return done


def largest_change(change: np.ndarray, covariance: np.ndarray) -> float:
    """Largest of the changes (p,) of coefficients, in standard deviations of their covariance (p, p)."""
    sd = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    return float(np.max(np.abs(change) / np.where(sd > 0.0, sd, np.inf), initial=0.0))


def _as_fit(done: list[tuple[list[FilteredRecord], float]], series: Sequence[Series], model: Model, passes: int) -> Fit:
    (last, change), complete = done[-1], len(done) == passes
    path = np.concatenate([one.path for found, _ in done for one in found])
    clock, passed = [], 0.0
    for s in list(series) * len(done):
        clock.append(passed + s.dt * (s.index + s.part))
        passed = clock[-1][-1]
    stride = max(1, -(-path.size // LONGEST_PATH))
    converged = complete and change < 1.0
    failure = "the coefficients still moved in the last pass" if complete else "a pass diverged"
    return Fit(
        last[-1].density.coefficients,
        last[-1].density.coefficient_covariance,
        converged=converged,
        message="" if converged else failure,
        n_iterations=len(done),
        trajectory=path[::-stride][::-1],
        trajectory_time_s=np.concatenate(clock)[::-stride][::-1],
        extra={
            "channels": [[model.states[i] for i in s.columns] for s in series],
            "innovations": [one.innovations for one in last],
            "largest_change": change,
            "cost": [sum(one.cost for one in found) for found, _ in done],
        },
    )
