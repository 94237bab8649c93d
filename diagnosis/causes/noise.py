"""Causes that only add variance: errors of the samples' times, and waves."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...checks.integrity.runs import common_step
from ...checks.result import NORMAL_90, Size
from ...estimation.filters.innovations.noise_fit import fit_noise
from ...models.linear_algebra import finite
from ..innovations.score_tests import independent_variances
from ..innovations.searches import ByScan, Search
from ..innovations.state import candidate
from ..innovations.tests import rate_statistic
from .base import DEGREE, Cause

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ...estimation.filters.innovations.settings import Setting
    from ..innovations.state import Candidate, State, Variant


SHARES = (0.03, 0.1, 0.3)
"""Errors that are scanned first, as shares of the sampling step."""
LARGEST_SHARE = 0.5
"""Largest error, as a share of the sampling step: samples keep their order."""
ROUGHER = 1.3
"""Factor on the error that the roughness of the samples allows: roughness and rates of change are estimates."""
GATE = 2.5
"""Standard score of the squared innovations growing with the channels' rates of change, below which none is scanned."""


def clock_errors(state: State) -> list[float]:
    """Errors (s) of the sampling instants to scan."""
    if rate_statistic(state.est, state.now) < GATE:
        return []
    return [share * state.est.segments[0].step_s for share in SHARES]


def largest_clock_error(est: Estimator) -> float:
    """Largest error of the clock, s: it makes a channel rough by the error times the channel's rate of change.

    The third differences of the samples hold that roughness and more (the sensor's noise, bends of the motion).
    """
    most = LARGEST_SHARE * max(d.step_s for d in est.segments)
    for c in np.flatnonzero(est.channels).tolist():
        rough, fast, count = 0.0, 0.0, 0
        for d in est.segments:
            y = d.measured[:, c]
            third, rate = np.diff(y, 3) ** 2, np.gradient(y, d.time)[1:-2] ** 2
            known = np.isfinite(third) & np.isfinite(rate)
            rough, fast, count = rough + third[known].sum() / 20.0, fast + rate[known].sum(), count + int(known.sum())
        if count > 50 and fast > 0.0:
            most = min(most, ROUGHER * float(np.sqrt(rough / fast)))
    return most


class ClockJitter(Cause):
    """Samples taken at t + error while the time column says t: error of standard deviation sd (s), independent from
    sample to sample; channels are noisier where they change fast."""

    id, where, unit = "clock_jitter", "sampling", "s"
    of_record = True
    search = ByScan("clock_jitter", clock_errors, largest_clock_error)
    separate_by = "time stamps taken by the instruments"
    beside_numbers = False

    def sizes(
        self, est: Estimator, s: Setting, variant: Variant, covariance: np.ndarray, rng: np.random.Generator
    ) -> tuple[Size, ...]:
        """The clock's error with the interval that the likelihood in its logarithm gives.

        One sample's channels share its error: spread of the samples' scores over curvature.
        """
        value, h = float(s.vectors[0, est.index["clock_jitter"]]), 0.05
        ll = []
        for factor in (np.exp(-h), 1.0, np.exp(h)):
            now = est.evaluate(est.with_entries(s, {"clock_jitter": value * factor}))
            ll.append(-np.sum(now.log_s + 0.5 * now.e**2, axis=1))
        curvature = max(-float(np.sum(ll[0] - 2.0 * ll[1] + ll[2])) / h**2, 1.0)
        half = NORMAL_90 * float(np.linalg.norm((ll[2] - ll[0]) / (2.0 * h))) / curvature
        return (Size("sd", value, value * float(np.exp(-half)), value * float(np.exp(half)), "s"),)


ENTRIES = ("wave_frequency", "wave_damping", "wave_rms")
WAVE_SIZES = {"period": "s", "damping": "1", "heading_rms": "rad"}
"""Sizes that are told of waves, and their units."""
FAINT = 0.1
"""Waves' rms over the sensors' noise where no more than their score is asked for."""
FREQUENCIES, RMS_DEG = (0.4, 0.55, 0.75, 1.0), (0.03, 0.12, 0.5)
"""Frequencies (rad/s, of a 160 m ship) and rms (degrees) that are tried first."""
WORTH_REFINING = 4.0
"""Nats that the best of them must gain."""


class WaveSearch(Search):
    """Scanned, then refined by a bounded simplex search; faint waves as if alike in all records, then each its own, as
    course and speed change how waves are met."""

    counts_values = True

    @property
    def entries(self) -> tuple[str, ...]:
        return ENTRIES

    def attempt(self, cause: Cause, state: State, before: float, rng: np.random.Generator) -> Candidate | None:
        est = state.est
        if not est.channels[:2].any():
            return None
        low, high = np.log([0.25 / est.clock, 0.02, 1e-5]), np.log([2.2 / est.clock, 0.5, 0.2])
        s = self._scanned(state, before)
        if s is None:
            return None
        x = np.zeros(3)
        for _ in range(3):
            s, _ = fit_noise(est, s, 3)
            x = _simplex(est, s, None, low, high)
            s = _waves_at(est, s, np.exp(x), None)
        if np.any(np.abs(x[:2] - high[:2]) < 1e-3) or abs(x[0] - low[0]) < 1e-3:
            return None  # broad-band, or beyond the band that is searched: noise, no waves
        if np.exp(x[2]) < _rounding(est):
            return None  # an even turn, rounded, is a narrow-band motion, too
        faint = [_waves_at(est, state.setting, np.array(kind), None) for kind in _faint_waves(state, low, high)]
        tests, each = independent_variances(rng, state.point, faint)
        common = candidate(cause, (), 1, tests, before, *state.refit(s, (), 3))
        if est.n_records == 1:
            return common
        s = common.setting
        for i in range(est.n_records):
            s = _waves_at(est, s, np.exp(_simplex(est, s, i, low, high)), i)
        own = candidate(cause, (), est.n_records, float(np.prod(2.0 * np.array(each))), before, *state.refit(s, (), 3))
        return replace(own, log_p=min(common.log_p, own.log_p))

    def _scanned(self, state: State, before: float) -> Setting | None:
        """The best of a few waves, with and without the random present forces; None where none gains."""
        est, s = state.est, state.setting
        sensors = np.minimum(s.noise.sensor_sd, 1.05 * state.start.noise.sensor_sd)
        quiet = replace(s.noise, sensor_sd=sensors)
        noises = [quiet, quiet.without_forces()] if s.noise.has_forces else [quiet]
        options = [
            _waves_at(est, replace(s, noise=noise), np.array([omega / est.clock, 0.1, rms * DEGREE]), None)
            for noise in noises
            for omega in FREQUENCIES
            for rms in RMS_DEG
        ]
        gains = [now.log_likelihood for now in est.many(options)]
        best = int(np.argmax(gains))
        return options[best] if gains[best] >= before + WORTH_REFINING else None


def _rounding(est: Estimator) -> float:
    """Step of which the recorded heading takes multiples, rad, the median over records; 0 where it takes none."""
    return float(np.median([common_step(segment.measured[:, 0]) for segment in est.segments]))


class WaveMotion(Cause):
    """Motion of heading and yaw rate in waves (first order): narrow-band noise that the rudder does not cause, of a
    period at which the ship meets the waves (s), and of a root mean square of the heading (rad); a damping ratio is
    told by a likelihood alone."""

    id, where, unit = "wave_motion", "environment", "s, 1, rad"
    of_record = True
    search = WaveSearch()
    separate_by = "heading and rate sampled at several times the wave frequency"

    def sizes(
        self, est: Estimator, s: Setting, variant: Variant, covariance: np.ndarray, rng: np.random.Generator
    ) -> tuple[Size, ...]:
        """Period, damping and rms, of all records or each, with intervals from the curvature of the likelihood."""
        slots = [est.index[name] for name in ENTRIES]
        shared = bool(np.all(s.vectors[:, slots] == s.vectors[0, slots]))
        out = []
        for owner in [None] if shared else range(est.n_records):
            values = s.vectors[est.rows(owner)[0], slots]
            half = NORMAL_90 * np.sqrt(np.diag(_wave_covariance(est, s, values, owner)))
            label = None if owner is None else est.record_names[owner]
            period_s, others = 2.0 * np.pi / values[0], values[1:]
            out += [
                Size(name, float(v), float(v * np.exp(-w)), float(v * np.exp(w)), unit, label)
                for (name, unit), v, w in zip(WAVE_SIZES.items(), (period_s, *others), half, strict=True)
            ]
        return tuple(out)


def _faint_waves(state: State, low: np.ndarray, high: np.ndarray) -> list[tuple[float, float, float]]:
    """Waves (frequency, damping, rms) of every kind between bounds (logarithms), far below the sensors' noise."""
    sd = np.where(state.est.channels, state.setting.noise.sensor_sd, np.inf)
    kinds = [np.exp(np.linspace(low[j], high[j], n)).tolist() for j, n in ((0, 12), (1, 3))]
    return [(omega, damping, FAINT * min(sd[0], sd[1] / omega)) for omega in kinds[0] for damping in kinds[1]]


def _waves_at(est: Estimator, s: Setting, values: np.ndarray, record: int | None) -> Setting:
    """The setting with waves (frequency, damping, rms) in all records or one."""
    return est.with_entries(s, dict(zip(ENTRIES, values.tolist(), strict=True)), record)


def _simplex(est: Estimator, s: Setting, record: int | None, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Logarithms of the waves of largest likelihood in all records or one, between bounds."""
    from scipy.optimize import minimize

    rows = est.rows(record)
    x = np.log(s.vectors[rows[0], [est.index[name] for name in ENTRIES]])

    def cost(y: np.ndarray) -> float:
        inside = np.clip(y, low, high)
        (now,) = est.many([_waves_at(est, s, np.exp(inside), record)], [rows])
        return -now.log_likelihood + 10.0 * float(np.sum((y - inside) ** 2))

    simplex = x + np.vstack([np.zeros(3), 0.15 * np.eye(3)])
    options = {"maxfev": 35 if record is None else 60, "initial_simplex": simplex}
    return np.clip(minimize(cost, x, method="Nelder-Mead", options=options).x, low, high)


def _wave_covariance(est: Estimator, s: Setting, values: np.ndarray, owner: int | None) -> np.ndarray:
    """Covariance (3, 3) of the logarithms of frequency, damping and rms, the noise held."""
    h = np.array([0.02, 0.1, 0.05])

    def likelihood(step: np.ndarray) -> float:
        (now,) = est.many([_waves_at(est, s, values * np.exp(step), owner)], [est.rows(owner)])
        return now.log_likelihood

    steps = np.diag(h)
    middle = likelihood(np.zeros(3))
    hessian = np.zeros((3, 3))
    for i in range(3):
        up, down = likelihood(steps[i]), likelihood(-steps[i])
        hessian[i, i] = -(up - 2.0 * middle + down) / h[i] ** 2
        for j in range(i):
            mixed = likelihood(steps[i] + steps[j]) - likelihood(steps[i] - steps[j])
            mixed += likelihood(-steps[i] - steps[j]) - likelihood(steps[j] - steps[i])
            hessian[i, j] = hessian[j, i] = -mixed / (4.0 * h[i] * h[j])
    value, axes = np.linalg.eigh(finite(hessian))
    return axes @ np.diag(1.0 / np.maximum(value, 1.0)) @ axes.T
