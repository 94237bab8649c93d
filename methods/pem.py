"""Prediction error: the coefficients, and the noise, whose one-step predictions have the likeliest innovations.

An extended Kalman filter whitens the innovations (`filters.innovations`); Levenberg-Marquardt steps of the coefficients
alternate with Fisher scoring of the sensor and force variances, which may become zero.
Sources: Ljung 1999, System Identification, sec 7.4; Jategaonkar 2015, Flight Vehicle System Identification, ch 5.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from ..datasets.record import Record
from ..estimation.filters.innovations.derivatives import responses, tangent, traces
from ..estimation.filters.innovations.estimator import Estimator, Innovations, estimator
from ..estimation.filters.innovations.noise_fit import QUANTUM, fit_noise, fit_noise_from_starts
from ..estimation.filters.innovations.settings import Setting
from ..estimation.filters.innovations.vector import SYMBOLS
from ..estimation.likelihood.linear_problem import NULL, LinearProblem
from ..estimation.likelihood.minimiser import Damping, try_steps
from ..estimation.likelihood.output_error import identify
from ..estimation.numerics import factors
from ..estimation.records.series import MEASURED
from ..estimation.regression.starts import starts_of
from ..estimation.results.fit import Fit
from ..models.errors import CannotFit, FitFailed
from ..models.model import Model
from .base import method
from .options import option, whole


@method("pem", "prediction error: likeliest innovations, sensor noise and gusts estimated along")
def Pem(
    records: Sequence[Record],
    model: Model,
    max_iterations: int = option(100, "pairs of a coefficient step and a noise step", whole(1)),
) -> Fit:
    """Prediction error with estimated sensor noise and process noise (coloured forces).

    Maximum likelihood for a ship in wind and waves: in addition to the white noise of the sensors, coloured forces (one
    Ornstein-Uhlenbeck process per degree of freedom, with one correlation time) and the noise of the rudder sensor act
    as process noise.  The variances may become zero: then the method is output error that allows for the rudder's
    noise.

    The search starts at the likeliest least-squares solution under strong forces, and lets the forces decrease while
    the coefficients improve.  Predictions over one sample have fewer minima than free runs, but strong forces can also
    hide what the coefficients lack: where the coefficients of `output-error` are likelier than what was found, the
    search goes on from them.

    Records need the rudder and heading or yaw rate; surge and sway are used where the model has them, positions are
    not.  `extra` holds the log likelihood and the noise: `sensor_sd` by state, `force_sd` in N, N and N m (response
    models: rad/s2 of yaw and of its rate) and the forces' `correlation_s`.
    """
    starts = [start.coefficients for start in starts_of(records, model)]
    est = velocity_estimator(model.with_coefficients(starts[0]), records)
    p = len(model.coordinates)
    if est.n_values <= p:
        raise CannotFit(f"{est.n_values} measured values for {p} coefficients")
    first = _searched(est, best_start(est, starts), max_iterations)
    est, found = _likelier(est, *first, _by_free_runs(records, model), max_iterations)
    solution = factors.solve(information(est, found.point), NULL)
    notes = [factors.rank_message(solution.rank, p), "" if found.converged else "stopped before convergence"]
    setting = found.point.setting
    return Fit(
        setting.vectors[0, :p],
        solution.covariance,
        converged=found.converged,
        message="; ".join(filter(None, notes)),
        n_iterations=found.n_iterations,
        extra={"log_likelihood": found.log_likelihood, **noise_of(est, setting)},
    )


def _likelier(
    est: Estimator, kept: Estimator, found: SearchResult, free_run: np.ndarray | None, max_iterations: int
) -> tuple[Estimator, SearchResult]:
    """What was found, or what the search finds from the coefficients (p,) of a fit to free runs, if these are
    likelier with noise of their own: large forces explain what coefficients do not."""
    if free_run is not None:
        setting, innovations = fit_noise_from_starts(est, with_coefficients(est.start(), free_run), est.start())
        if innovations.log_likelihood > found.log_likelihood:
            other, likelier = _searched(est, SearchPoint(setting, innovations), max_iterations)
            if likelier.log_likelihood > found.log_likelihood:
                return other, likelier._replace(n_iterations=found.n_iterations + likelier.n_iterations)
    return kept, found


def _searched(est: Estimator, start: SearchPoint, max_iterations: int) -> tuple[Estimator, SearchResult]:
    """The whole search from one point, with the filter in the form of noise found."""
    found = search(est, start, max_iterations, ROUGH)
    est, found = with_best_noise_form(est, found)
    last = search(est, found.point, max(max_iterations - found.n_iterations, 1), ENOUGH)
    return est, last._replace(n_iterations=found.n_iterations + last.n_iterations)


def _by_free_runs(records: Sequence[Record], model: Model) -> np.ndarray | None:
    """Coefficients (p,) by output error; None where it finds none."""
    try:
        outcome = identify(records, model)
        return outcome.problem.coefficients(outcome.minimum.z)
    except (CannotFit, FitFailed):
        return None


FORCES = (4.0, 64.0)
"""Standard deviations of the forces, in QUANTUM, under which starts are compared."""
ROUGH, ENOUGH = 1.0, 1e-2
"""Predicted gain in log likelihood at which the search for the form of the noise ends, and the whole search."""
RIVAL = 6
"""Iterations of a fit without forces, to compare with one that has forces."""
FIRST_DAMPING, LEAST_DAMPING = 1e-7, 1e-20
RULE = Damping(growth=10.0, least=0.0, trials=12)


class SearchPoint(NamedTuple):
    """A setting of coefficients and noise, its innovations, and the damping that the next step starts with."""

    setting: Setting
    innovations: Innovations
    damping: float = FIRST_DAMPING

    @property
    def cost(self) -> float:
        """Negative log likelihood."""
        return -self.innovations.log_likelihood


class SearchResult(NamedTuple):
    """Where a search stopped."""

    point: SearchPoint
    converged: bool
    n_iterations: int

    @property
    def log_likelihood(self) -> float:
        return self.point.innovations.log_likelihood


def velocity_estimator(model: Model, records: Sequence[Record]) -> Estimator:
    """The filter for the records, with the channels of the model's velocities and heading only."""
    used = [symbol in MEASURED and symbol in model.states for symbol in SYMBOLS]
    return estimator(model, records).with_channels(used)


def best_start(est: Estimator, starts: Sequence[np.ndarray]) -> SearchPoint:
    """The likeliest of several coefficients (p,), each under several amounts of process noise."""
    quiet = est.start()
    settings, effective = [], effective_forces(est, with_coefficients(quiet, starts[0]))
    for amount in FORCES:
        noise = replace(quiet.noise, force_sd=amount * QUANTUM * effective)
        settings += [with_coefficients(replace(quiet, noise=noise), start) for start in starts]
    found = est.many(settings)
    best = int(np.argmax([innovations.log_likelihood for innovations in found]))
    if found[best].diverged:
        raise FitFailed("the filter diverges from every start")
    return SearchPoint(settings[best], found[best])


def effective_forces(est: Estimator, s: Setting) -> np.ndarray:
    """(nf,) whether a force has any effect: a model without a surge equation has no surge force."""
    steady = [[np.ones(d.time.size) for d in est.segments]] * est.n_forces
    return np.linalg.norm(responses(est, traces(est, s), range(est.n_forces), steady), axis=1) != 0.0


def with_coefficients(s: Setting, coefficients: np.ndarray) -> Setting:
    """The setting with other coefficients (p,) for every record."""
    vectors = s.vectors.copy()
    vectors[:, : len(coefficients)] = coefficients
    return replace(s, vectors=vectors)


def information(est: Estimator, point: SearchPoint) -> np.ndarray:
    """Triangular factor (p + 1, p + 1) of [derivatives of the whitened innovations | -innovations]."""
    p = len(est.model.coordinates)
    rows = np.vstack([tangent(est, point.setting, range(p)), -point.innovations.e.reshape(1, -1)]).T
    if not np.isfinite(rows).all():
        raise FitFailed("derivatives of the innovations are not finite")
    return factors.fold(factors.empty(p), rows)


def search(est: Estimator, point: SearchPoint, max_iterations: int, enough: float) -> SearchResult:
    """Noise and coefficient steps in turn until the log likelihood gains less than `enough`."""
    gain, iteration = np.inf, 0
    while gain >= enough and iteration < max_iterations:
        point, gain = improved(est, point)
        iteration += 1
    return SearchResult(point, gain < enough, iteration)


def with_best_noise_form(est: Estimator, found: SearchResult) -> tuple[Estimator, SearchResult]:
    """The likelier form of the noise: rudder corners uncertain or exact, with forces or without.

    Forces are compared with none for response models only: there, large forces can hide errors of the coefficients.
    The many channels of other models prevent that.
    """
    exact = est.with_corners(0.0)
    innovations = exact.evaluate(found.point.setting)
    if innovations.log_likelihood > found.log_likelihood:
        est, found = exact, found._replace(point=found.point._replace(innovations=innovations))
    s = found.point.setting
    if est.model.is_3dof or not s.noise.has_forces:
        return est, found
    s = replace(s, noise=est.start().noise)
    rival = search(est, SearchPoint(s, est.evaluate(s)), RIVAL, ROUGH)
    n_iterations = found.n_iterations + rival.n_iterations
    best = rival if rival.log_likelihood > found.log_likelihood else found
    return est, best._replace(n_iterations=n_iterations)


def improved(est: Estimator, point: SearchPoint) -> tuple[SearchPoint, float]:
    """One noise step and one step of the coefficients, and the larger of their actual and predicted gain."""
    before = point.innovations.log_likelihood
    s, innovations = fit_noise(est, point.setting, 1)
    gain = innovations.log_likelihood - before
    point, predicted = stepped(est, point._replace(setting=s, innovations=innovations))
    return point, max(gain, predicted)


def stepped(est: Estimator, point: SearchPoint) -> tuple[SearchPoint, float]:
    """A Levenberg-Marquardt step of the coefficients that raises the likelihood, and the gain that it predicted.

    Without such a step: the point itself, and the predicted gain where that is below ENOUGH, else zero.
    """
    linear = LinearProblem(information(est, point))
    trial = try_steps(linear.step, partial(_moved, est, point), point.cost, point.damping, ENOUGH, RULE)
    if trial.better:
        damping = max(trial.damping * (0.01 if trial.number == 0 else 1.0), LEAST_DAMPING)
        return trial.point._replace(damping=damping), trial.predicted
    return point._replace(damping=FIRST_DAMPING), trial.predicted if trial.predicted < ENOUGH else 0.0


def _moved(est: Estimator, point: SearchPoint, step: np.ndarray) -> SearchPoint:
    s = with_coefficients(point.setting, point.setting.vectors[0, : step.size] + step)
    return SearchPoint(s, est.evaluate(s))


def noise_of(est: Estimator, s: Setting) -> dict:
    """Standard deviations of the sensors by state and of the forces by input, and the forces' correlation time, s."""
    nf, first = est.n_forces, est.shape.first_force
    names = est.kernels.INPUTS[first : first + nf]
    return {
        "sensor_sd": {SYMBOLS[c]: float(s.noise.sensor_sd[c]) for c in np.flatnonzero(est.channels)},
        "force_sd": dict(zip(names, (s.noise.force_sd * est.unit).tolist(), strict=True)),
        "correlation_s": s.noise.correlation_time_s,
    }
