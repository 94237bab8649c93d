"""Prediction error: the coefficients whose one-step predictions leave the likeliest innovations.

Maximum likelihood for a ship that wind and waves push about: besides the sensors' white noise, coloured forces (one
Ornstein-Uhlenbeck process per degree of freedom, with one correlation time) and the rudder sensor's noise act as
process noise.  An extended Kalman filter whitens the innovations (`innovations`); Levenberg-Marquardt steps of the
coefficients alternate with Fisher scoring of the sensor and force variances, which may become zero: then the
method is output error with the rudder's noise allowed for.

Predictions over one sample have few minima, unlike free runs: the search starts at the likeliest least-squares
solution under strong forces, and lets the forces shrink while the coefficients improve.
Source: Ljung, System Identification (1999), sec 7.4; Jategaonkar, Flight Vehicle System Identification (2015), ch 5.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..models.errors import BadInput
from . import factors
from .base import CannotFit, Fit, FitFailed, Method
from .innovations.estimator import QUANTUM, SYMBOLS, Estimator, Innovations, Setting
from .series import MEASURED
from .starts import starts_of

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model

FORCES = (4.0, 64.0)
"""Force sds, in QUANTUM, that starts are compared under."""
NULL = 1e-12
"""Singular values (columns of unit length) below which a direction counts as not identified."""
ROUGH, ENOUGH = 1.0, 1e-2
"""Promised gain in log likelihood at which the search for the noise's form ends, and the search itself."""
RIVAL = 6
"""Iterations that a fit without forces is given to beat one with forces."""
DAMPING, LEAST = 1e-7, 1e-20
TRIALS = 12


class Point(NamedTuple):
    """A setting, its innovations, and the damping that the next step starts with."""

    setting: Setting
    now: Innovations
    damping: float = DAMPING


class Found(NamedTuple):
    """Where a search stopped."""

    point: Point
    converged: bool
    iterations: int

    @property
    def log_likelihood(self) -> float:
        return self.point.now.log_likelihood


class Pem(Method):
    """Prediction error with estimated sensor noise and process noise (coloured forces).

    Parameters
    ----------
    max_iterations : pairs of a coefficient and a noise step.

    Records need the rudder and heading or yaw rate; surge and sway are used where the model has them, positions are
    not.  `extra` holds the log likelihood and the noise: `sensor_sd` by state, `force_sd` in N, N and N m (response
    models: rad/s2 of yaw and of its rate) and the forces' `correlation_s`.
    """

    name = "pem"
    title = "prediction error: likeliest innovations, sensor noise and gusts estimated along"

    def __init__(self, max_iterations: int = 30) -> None:
        self.max_iterations = max_iterations

    def check_options(self) -> None:
        super().check_options()
        if self.max_iterations < 1:
            raise BadInput(f"max_iterations is {self.max_iterations!r}, at least 1 is needed")

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        starts = [start.coefficients for start in starts_of(records, model)]
        est = estimator(model.with_coefficients(starts[0]), records)
        if est.n_values <= len(model.coordinates):
            raise CannotFit(f"{est.n_values} measured values for {len(model.coordinates)} coefficients")
        found = search(est, best_start(est, starts), self.max_iterations, ROUGH)
        est, found = settled(est, found)
        left = max(self.max_iterations - found.iterations, 1)
        last = search(est, found.point, left, ENOUGH)
        return _fit(est, last._replace(iterations=found.iterations + last.iterations))


def estimator(model: Model, records: Sequence[Record]) -> Estimator:
    """The records under the filter, with the channels of the model's velocities and heading."""
    est = Estimator(model, records)
    used = [symbol in MEASURED and symbol in model.states for symbol in SYMBOLS]
    est.data = [replace(d, measured=np.where(used, d.measured, np.nan)) for d in est.data]
    return est


def best_start(est: Estimator, starts: Sequence[np.ndarray]) -> Point:
    """The likeliest of coefficients (p,) under several amounts of process noise.

    Raises
    ------
    FitFailed : if the filter diverges with every one.
    """
    quiet = est.start()
    settings, moving = [], effective_forces(est, with_coefficients(quiet, starts[0]))
    for amount in FORCES:
        noise = quiet.noise.copy()
        noise[6 : 6 + est.n_forces] = amount * QUANTUM * moving
        settings += [with_coefficients(replace(quiet, noise=noise), start) for start in starts]
    found = est.many(settings)
    best = int(np.argmax([now.log_likelihood for now in found]))
    if found[best].log_likelihood <= -1e299:
        raise FitFailed("the filter diverges from every start")
    return Point(settings[best], found[best])


def effective_forces(est: Estimator, s: Setting) -> np.ndarray:
    """(nf,) whether a force moves anything: a model without a surge equation has no surge force."""
    steady = [[np.ones(d.time.size) for d in est.data]] * est.n_forces
    return np.linalg.norm(est.responses(est.traces(s), range(est.n_forces), steady), axis=1) != 0.0


def with_coefficients(s: Setting, coefficients: np.ndarray) -> Setting:
    """The setting with other coefficients (p,) in every record."""
    p = s.p.copy()
    p[:, : len(coefficients)] = coefficients
    return replace(s, p=p)


def information(est: Estimator, point: Point) -> np.ndarray:
    """Triangular factor (p + 1, p + 1) of [derivatives of the whitened innovations | -innovations]."""
    p = len(est.model.coordinates)
    rows = np.vstack([est.tangent(point.setting, range(p)), -point.now.e.reshape(1, -1)]).T
    if not np.isfinite(rows).all():
        raise FitFailed("derivatives of the innovations are not finite")
    return factors.fold(factors.empty(p), rows)


def search(est: Estimator, point: Point, most: int, enough: float) -> Found:
    """Noise and coefficient steps in turn until the likelihood gains less than `enough`."""
    gain, iteration = np.inf, 0
    while gain >= enough and iteration < most:
        point, gain = improved(est, point)
        iteration += 1
    return Found(point, gain < enough, iteration)


def settled(est: Estimator, found: Found) -> tuple[Estimator, Found]:
    """The likelier form of the noise: rudder corners in doubt or exact, forces or none.

    In response models forces, once strong, can hide what the coefficients lack; the many channels of other models
    prevent that.
    """
    exact = est.with_corners(0.0)
    now = exact.evaluate(found.point.setting)
    if now.log_likelihood > found.log_likelihood:
        est, found = exact, found._replace(point=found.point._replace(now=now))
    s, nf = found.point.setting, est.n_forces
    if est.model.is_3dof or not s.noise[6 : 6 + nf].any():
        return est, found
    s = replace(s, noise=est.start().noise)
    rival = search(est, Point(s, est.evaluate(s)), RIVAL, ROUGH)
    iterations = found.iterations + rival.iterations
    best = rival if rival.log_likelihood > found.log_likelihood else found
    return est, best._replace(iterations=iterations)


def improved(est: Estimator, point: Point) -> tuple[Point, float]:
    """One noise step and one step of the coefficients; the larger of what the two gain or promise."""
    before = point.now.log_likelihood
    s, now = est.fit_noise(point.setting, 1)
    gain = now.log_likelihood - before
    point, promise = stepped(est, point._replace(setting=s, now=now))
    return point, max(gain, promise)


def stepped(est: Estimator, point: Point) -> tuple[Point, float]:
    """A Levenberg-Marquardt step of the coefficients that raises the likelihood, and the gain it promised."""
    factor = information(est, point)
    length = np.linalg.norm(factor[:, :-1], axis=0)
    length = np.where(length > 0.0, length, 1.0)
    u, singular, vt = np.linalg.svd(factor[:, :-1] / length, full_matrices=False)
    kept = singular > NULL * singular[0]
    singular, projected, back = singular[kept], (u.T @ factor[:, -1])[kept], vt[kept].T / length[:, None]
    coefficients, damping = point.setting.p[0, : length.size], point.damping
    for trial in range(TRIALS):
        left = damping / (singular**2 + damping)
        promise = float(0.5 * np.sum(projected**2 * (1.0 - left**2)))
        step = back @ (singular / (singular**2 + damping) * projected)
        s = with_coefficients(point.setting, coefficients + step)
        now = est.evaluate(s)
        if now.log_likelihood > point.now.log_likelihood:
            return Point(s, now, max(damping * (0.01 if trial == 0 else 1.0), LEAST)), promise
        if promise < ENOUGH:
            break
        damping *= 10.0
    return point._replace(damping=DAMPING), promise if promise < ENOUGH else 0.0


def _fit(est: Estimator, found: Found) -> Fit:
    point = found.point
    solution = factors.solve(information(est, point), NULL)
    p = len(est.model.coordinates)
    said = [] if solution.rank == p else [f"the records determine {solution.rank} of {p} directions"]
    said += [] if found.converged else ["stopped before convergence"]
    return Fit(
        point.setting.p[0, :p],
        solution.covariance,
        converged=found.converged,
        message="; ".join(said),
        n_iterations=found.iterations,
        extra={"log_likelihood": point.now.log_likelihood, **noise_of(est, point.setting)},
    )


def noise_of(est: Estimator, s: Setting) -> dict:
    """Sensor sds by state, force sds by the name of their input, and the forces' correlation time."""
    nf, first = est.n_forces, est.layout[3]
    names = est.kernels.INPUTS[first : first + nf]
    return {
        "sensor_sd": {SYMBOLS[c]: float(s.noise[c]) for c in np.flatnonzero(est.channels)},
        "force_sd": dict(zip(names, (s.noise[6 : 6 + nf] * est.unit).tolist(), strict=True)),
        "correlation_s": float(s.noise[6 + nf]),
    }
