"""Noise of largest likelihood: sensor sds, sds of the random forces (>= 0) and their correlation time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...likelihood.minimiser import Damping, try_steps
from .settings import Noise
from .vector import CHANNELS

if TYPE_CHECKING:
    from ._arguments import Run, Trace
    from .estimator import Estimator, Innovations
    from .settings import Setting

QUANTUM = 1e-5
"""Force that the noise fit counts in, as a share of the force unit."""
SHORTEST_TAU_S, LONGEST_TAU_S = 1.0, 60.0
"""Bounds of the correlation time on a 160 m ship; those of smaller ones scale by `Estimator.clock`."""
RULE = Damping(growth=10.0, least=0.1, trials=5)
"""Shares of the Fisher information added to its diagonal: 0, then 0.1 and tenfold each time (forces of response models
are nearly collinear)."""
SENSORS_ONLY = 100.0
"""Share from which the forces stay and only the sensors move."""
ROUNDING = 1e-6
"""Fall of the log likelihood that a step may end with."""
CLIP = 4.5
"""Innovation beyond which a score counts no more (sensor outliers)."""
FORCE_STARTS = (0.0, 4.0)
"""Random forces, in QUANTUM, that a fit from several starts begins with."""


class Point(NamedTuple):
    """A setting, its innovations, and the stored runs of all segments."""

    setting: Setting
    now: Innovations
    stored: Sequence[tuple[Run, Trace]]

    @property
    def cost(self) -> float:
        """Negative log likelihood."""
        return -self.now.log_likelihood


def fit_noise(est: Estimator, s: Setting, most: int = 8, tolerance: float = 0.05) -> tuple[Setting, Innovations]:
    """Noise of largest likelihood near a setting, by at most `most` steps of Fisher scoring.

    Eq. 1 of docs/mathematics/default-route.md.
    """
    point = _stored(est, s)
    for _ in range(most):
        if point.now.diverged:
            break
        gain, point = _step(est, point)
        if gain < tolerance:
            break
    return point.setting, point.now


def fit_noise_from_starts(est: Estimator, s: Setting, start: Setting) -> tuple[Setting, Innovations]:
    """The best noise of several starts: the present one, and no or faint random forces beside those of `start`."""
    best = fit_noise(est, s, 12)
    for amount in FORCE_STARTS:
        force = amount * QUANTUM * np.array([1.0, 2.0, 1.0])[: est.n_forces]
        noise = replace(start.noise, force_sd=force)
        if noise.equals(s.noise):
            continue
        found = fit_noise(est, replace(s, noise=noise), 12)
        if found[1].log_likelihood > best[1].log_likelihood + 1e-3:
            best = found
    return best


def _stored(est: Estimator, s: Setting) -> Point:
    """A setting with every segment's run stored for derivatives."""
    stored = est.in_threads(lambda i: est.traced(s, i), range(len(est.segments)))
    return Point(s, est.gathered([run for run, _ in stored]), stored)


def _step(est: Estimator, point: Point) -> tuple[float, Point]:
    """Gain of one step, and where it leads."""
    nf, noise, now = est.n_forces, point.setting.noise, point.now
    sensors = _sensor_step(est, noise, now)
    q = (noise.force_sd / QUANTUM) ** 2
    gradient, fisher = _force_scores(est, point)
    if not (np.isfinite(gradient).all() and np.isfinite(fisher).all()):
        return 0.0, point

    def step(damping: float) -> tuple[np.ndarray, float]:
        if damping >= SENSORS_ONLY:
            return np.zeros(nf + 1), np.inf
        return _bounded_step(gradient, fisher + damping * np.diag(np.diag(fisher)), q), np.inf

    calm: list[Point] = []  # without forces their time is nothing to the likelihood: another such trial fails as well

    def reached(change: np.ndarray) -> Point:
        there = _moved(est, noise, sensors, change)
        if there.has_forces:
            return _stored(est, replace(point.setting, noise=there))
        if not calm:
            calm.append(_stored(est, replace(point.setting, noise=there)))
        return calm[0]

    trial = try_steps(step, reached, point.cost + ROUNDING, 0.0, 0.0, RULE)
    return (point.cost - trial.point.cost, trial.point) if trial.better else (0.0, point)


def _moved(est: Estimator, noise: Noise, sensors: np.ndarray, change: np.ndarray) -> Noise:
    """Noise with these sensors, its forces changed by (nf variances, log correlation time)."""
    q = (noise.force_sd / QUANTUM) ** 2
    new = np.clip(q + change[:-1], 0.0, 30.0 * q + 100.0)
    tau = noise.correlation_time_s * np.exp(np.clip(change[-1], -0.7, 0.7))
    return Noise(
        sensors,
        QUANTUM * np.sqrt(np.where(new < 1e-6, 0.0, new)),
        float(np.clip(tau, SHORTEST_TAU_S * est.clock, LONGEST_TAU_S * est.clock)),
    )


def _sensor_step(est: Estimator, noise: Noise, now: Innovations) -> np.ndarray:
    """Sensor sds (6,) after one scoring step."""
    share = noise.sensor_sd**2 / np.exp(2.0 * now.log_s)
    used = now.e != 0.0
    excess = np.sum((np.clip(now.e, -CLIP, CLIP) ** 2 - 1.0) * share * used, axis=0)
    weight = np.maximum(np.sum(share**2 * used, axis=0), 1e-9)
    return np.maximum(noise.sensor_sd * np.exp(np.clip(0.5 * excess / weight, -0.4, 0.4)), est.floors)


def _force_scores(est: Estimator, point: Point) -> tuple[np.ndarray, np.ndarray]:
    """Gradient (nf + 1,) and Fisher information of variances (QUANTUM^2) and log correlation time of the forces."""
    nf, e = est.n_forces, point.now.e.ravel()
    de, dl = by_noise(est, point)
    with np.errstate(over="ignore", invalid="ignore"):  # a run on its way to divergence: judged by the caller
        gradient = -np.sum(dl + e * de, axis=1)
        mean = de + e * dl
        fisher = mean @ mean.T + 2.0 * dl @ dl.T
    fisher[nf, nf] += 1.0
    return gradient, fisher


def by_noise(est: Estimator, point: Point) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives (nf + 1, N*6) of innovations and of log S / 2 by variances (QUANTUM^2) and log time of forces."""
    from ._derivatives import LANES, vary  # numba

    by_e, by_log_s = np.zeros((2, LANES, est.edges[-1] * CHANNELS))
    noise, n = point.setting.noise, len(est.kernels.STATES)

    def along(i: int) -> None:
        run, t = point.stored[i]
        done = (t.transition, t.slopes, t.gains, t.roots, t.spreads, run.e, run.states)
        vary(
            *done, est.segments[i].time, noise.force_sd, noise.correlation_time_s, n, QUANTUM, est.edges[i], by_e,
            by_log_s,
        )  # fmt: skip

    est.in_threads(along, range(len(est.segments)))
    return by_e[: est.n_forces + 1], by_log_s[: est.n_forces + 1]


def _bounded_step(gradient: np.ndarray, fisher: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Scoring step of (variances, log tau) that keeps variances at zero which want to be negative."""
    nf = q.size
    active = [j for j in range(nf) if not (q[j] <= 0.0 and gradient[j] <= 0.0)]
    active += [nf] if q.max() > 1e-4 else []
    while active:
        step = np.zeros(nf + 1)
        block = fisher[np.ix_(active, active)]
        step[active] = np.linalg.solve(block + 1e-9 * np.trace(block) * np.eye(len(active)), gradient[active])
        blocked = [j for j in active if j < nf and q[j] <= 0.0 and step[j] < 0.0]
        if not blocked:
            return step
        active = [j for j in active if j not in blocked]
    return np.zeros(nf + 1)
