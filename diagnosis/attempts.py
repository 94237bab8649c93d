"""Causes that are scanned instead of scored: their derivative at the null says nothing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..methods.innovations.estimator import Estimator, Innovations, Setting
from ..methods.innovations.layout import CHANNELS
from . import unknown
from .bootstrap import ONE_SIDED, independent_noise, independent_values
from .search import Candidate, Search, candidate

DEGREE = np.pi / 180.0
FAINT = 0.1
"""Waves' rms over the sensors' noise where no more than their score is asked for."""
LIMITS = (1.5, 1.2, 1.0, 0.9985, 0.995, 0.985, 0.97, 0.9, 0.8, 0.6, 0.4, 0.2)
"""Limits that are tried first, as shares of the command's largest value: just below it a little changes much."""
MOST_VALUES = 24
"""Values that a scan goes on to, each in the last one's proportion to the one before, while the last one is best."""


def try_waves(search: Search, before: float) -> Candidate | None:
    """Narrow-band motion on heading and yaw rate: scanned, then refined by a bounded simplex search.

    Each record has its own, as course and speed change how waves are met; faint ones are seen as if they were the same.
    """
    est, s = search.est, search.setting
    if not est.channels[:2].any():
        return None
    clock = est.clock
    slots = [est.index[n] for n in ("wave_frequency", "wave_damping", "wave_rms")]
    low = np.log([0.25 / clock, 0.02, 1e-5])
    high = np.log([2.2 / clock, 0.5, 0.2])

    def at(base: Setting, values: Sequence[float] | np.ndarray) -> Setting:
        return _waves_at(base, slots, values, None)

    quiet = s.noise.copy()
    quiet[:6] = np.minimum(quiet[:6], 1.05 * search.start.noise[:6])
    options = []
    for gusts in (1.0, 0.0):
        noise = quiet.copy()
        noise[6 : 6 + est.n_forces] *= gusts
        for omega in (0.4, 0.55, 0.75, 1.0):
            for rms in (0.03 * DEGREE, 0.12 * DEGREE, 0.5 * DEGREE):
                options.append(at(replace(s, noise=noise), (omega / clock, 0.1, rms)))
        if not s.noise[6 : 6 + est.n_forces].any():
            break
    gains = [n.log_likelihood for n in est.many(options)]
    best = int(np.argmax(gains))
    if gains[best] < before + 4.0:
        return None
    s = options[best]
    for _ in range(3):
        s, _ = est.fit_noise(s, 3)
        x = _simplex(est, s, slots, None, low, high)
        s = at(s, np.exp(x))
    if np.any(np.abs(x[:2] - high[:2]) < 1e-3) or abs(x[0] - low[0]) < 1e-3:
        return None  # broad-band, or beyond the band that is searched: noise, no waves
    tests, each = independent_noise(search, [at(search.setting, kind) for kind in _faint_waves(search, low, high)])
    common = candidate("wave_motion", (), 1, tests, before, *search.refit(s, (), 3))
    if len(est.data) == 1:
        return common
    s = common.setting
    for i in range(len(est.data)):
        s = _waves_at(s, slots, np.exp(_simplex(est, s, slots, i, low, high)), i)
    tests = float(np.prod(2.0 * np.array(each)))
    own = candidate("wave_motion", (), len(est.data), tests, before, *search.refit(s, (), 3))
    return replace(own, log_p=min(common.log_p, own.log_p))


def _faint_waves(search: Search, low: np.ndarray, high: np.ndarray) -> list[tuple[float, float, float]]:
    """Waves (frequency, damping, rms) of every kind between bounds (logarithms), far below the sensors' noise."""
    sd = np.where(search.est.channels, search.setting.noise[:CHANNELS], np.inf)
    kinds = [np.exp(np.linspace(low[j], high[j], n)).tolist() for j, n in ((0, 12), (1, 3))]
    return [(omega, damping, FAINT * min(sd[0], sd[1] / omega)) for omega in kinds[0] for damping in kinds[1]]


def _waves_at(s: Setting, slots: Sequence[int], values: Sequence[float] | np.ndarray, record: int | None) -> Setting:
    """The setting with waves (frequency, damping, rms) in all records or one."""
    p = s.p.copy()
    p[slice(None) if record is None else record, slots] = values
    return replace(s, p=p)


def _simplex(
    est: Estimator, s: Setting, slots: Sequence[int], record: int | None, low: np.ndarray, high: np.ndarray
) -> np.ndarray:
    """Logarithms of the waves of largest likelihood in all records or one, between bounds."""
    from scipy.optimize import minimize

    some = None if record is None else [record]
    x = np.log(s.p[record or 0, slots])

    def cost(y: np.ndarray) -> float:
        inside = np.clip(y, low, high)
        now = est.evaluate(_waves_at(s, slots, np.exp(inside), record), some)
        return -now.log_likelihood + 10.0 * float(np.sum((y - inside) ** 2))

    simplex = x + np.vstack([np.zeros(3), 0.15 * np.eye(3)])
    options = {"maxfev": 35 if record is None else 60, "initial_simplex": simplex}
    return np.clip(minimize(cost, x, method="Nelder-Mead", options=options).x, low, high)


def try_jitter(search: Search, before: float) -> Candidate | None:
    """Errors of the sampling instants: scanned if squared innovations grow with the channels' rates of change."""
    if unknown.rate_statistic(search.est, search.now) < 2.5:
        return None
    step = float(np.median(np.diff(search.est.data[0].time)))
    return _scanned(search, "clock_jitter", "clock", [share * step for share in (0.03, 0.1, 0.3, 0.8)], before)


def try_limit(search: Search, cause: str, slot: str, before: float) -> Candidate | None:
    """A limit on the command's rate or angle: scanned about and below the quietened command's largest value."""
    d = search.est.data
    quiet = [unknown.lagged(x.rudder, x.time, 1.5 * float(np.median(np.diff(x.time)))) for x in d]
    if slot == "rudder_rate":
        seen = max(float(np.max(np.abs(np.diff(q) / np.diff(x.time)))) for q, x in zip(quiet, d, strict=True))
    else:
        seen = max(float(np.mean(np.abs(q)[np.abs(q) > 0.98 * np.abs(q).max()])) for q in quiet)
    return _scanned(search, cause, slot, [share * seen for share in LIMITS], before)


def _scanned(search: Search, cause: str, slot: str, values: Sequence[float], before: float) -> Candidate | None:
    """The best value of one entry of the parameter vector, scanned and then refined in its logarithm.

    A limit's values differ in what they do; the error of a clock only in how much.
    """
    from scipy.optimize import minimize_scalar

    est, s = search.est, search.setting
    index = est.index[slot]

    def changed(value: float) -> Setting:
        p = s.p.copy()
        p[:, index] = value
        return replace(s, p=p)

    def at(value: float) -> tuple[Setting, Innovations]:
        return est.fit_noise(changed(value), 2)

    values = list(values)
    gains = [at(value)[1].log_likelihood for value in values]
    while gains[-1] == max(gains) > before + 2.0 and len(values) < MOST_VALUES:
        values.append(values[-1] ** 2 / values[-2])
        gains.append(at(values[-1])[1].log_likelihood)
    best = int(np.argmax(gains))
    if gains[best] < before + 2.0:
        return None
    ends = np.log([values[max(best - 1, 0)], values[min(best + 1, len(values) - 1)]])
    low, high = min(ends) - 0.3 * (best == 0), max(ends) + 0.3 * (best == len(values) - 1)
    found: Any = minimize_scalar(
        lambda x: -at(float(np.exp(x)))[1].log_likelihood, bounds=(low, high), options={"xatol": 0.01, "maxiter": 14}
    )
    (variant,) = search.bank[cause]
    value = float(np.exp(found.x)) if -found.fun > gains[best] else values[best]
    setting, now = search.refit(at(value)[0], variant, 2)
    tests = independent_values(search, est.many([changed(v) for v in values])) if variant else ONE_SIDED
    return candidate(cause, variant, 1, tests, before, setting, now)


ATTEMPTS: dict[str, Callable[[Search, float], Candidate | None]] = {
    "wave_motion": try_waves,
    "clock_jitter": try_jitter,
    "rudder_rate_limit": lambda search, before: try_limit(search, "rudder_rate_limit", "rudder_rate", before),
    "rudder_saturation": lambda search, before: try_limit(search, "rudder_saturation", "rudder_limit", before),
}
