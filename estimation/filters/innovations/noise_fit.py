"""Noise of largest likelihood: sensor sds, sds of the random forces (>= 0) and their correlation time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...likelihood.minimiser import Damping, LastStep, try_steps
from .settings import Noise
from .vector import CHANNELS

if TYPE_CHECKING:
    from ._arguments import FilterRun, Trace
    from .estimator import Estimator, Innovations
    from .settings import Setting

QUANTUM = 1e-5
"""Force that the noise fit counts in, as a share of the force unit."""
SHORTEST_TAU_S, LONGEST_TAU_S = 1.0, 60.0
"""Bounds of the correlation time on a 160 m ship; those of smaller ones scale by `Estimator.clock`."""
RULE = Damping(growth=10.0, least=0.1, trials=5)
"""Shares of the Fisher information added to its diagonal: 0, then 0.1 and tenfold each time (forces of response models
are nearly collinear)."""
REDUCED = 0.1
"""Factor on the damping after a step that succeeds at the first trial."""
ENOUGH = 0.05
"""Gain in log likelihood below which a fit ends."""
RIDGE = 1e-9
"""Share of the Fisher information that is always added to its diagonal."""
ROUNDING = 1e-6
"""Fall of the log likelihood that a step may end with."""
CLIP = 4.5
"""Innovation beyond which a score counts no more (sensor outliers)."""
MOST_STEPS = 100
"""Steps after which a fit from several starts ends that still gains: where it ends before its optimum depends on the
processor, and a sensor's sd changes by 1.5-fold a step at most."""
FORCE_STARTS = (0.0, 4.0)
"""Random forces, in QUANTUM, that a fit from several starts begins with."""


class Point(NamedTuple):
    """A setting, its innovations, and the stored runs of all segments."""

    setting: Setting
    now: Innovations
    stored: Sequence[tuple[FilterRun, Trace]]

    @property
    def cost(self) -> float:
        """Negative log likelihood."""
        return -self.now.log_likelihood


def fit_noise(est: Estimator, s: Setting, most: int = 8) -> tuple[Setting, Innovations]:
    """Noise of largest likelihood near a setting, by at most `most` steps of damped Fisher scoring.

    Section 2 of docs/mathematics/diagnosis.md.
    """
    point, damping = _stored(est, s), 0.0
    for _ in range(most):
        if point.now.diverged:
            break
        trial = _step(est, point, damping)
        if not trial.better:
            break
        gain, point = point.cost - trial.point.cost, trial.point
        damping = trial.damping * (REDUCED if trial.number == 0 else 1.0)
        if gain < ENOUGH:
            break
    return point.setting, point.now


def fit_noise_from_starts(est: Estimator, s: Setting, start: Setting) -> tuple[Setting, Innovations]:
    """The best noise of several starts: the present one, and no or faint random forces beside those of `start`."""
    best = fit_noise(est, s, MOST_STEPS)
    for amount in FORCE_STARTS:
        force = amount * QUANTUM * np.array([1.0, 2.0, 1.0])[: est.n_forces]
        noise = replace(start.noise, force_sd=force)
        if noise.equals(s.noise):
            continue
        found = fit_noise(est, replace(s, noise=noise), MOST_STEPS)
        if found[1].log_likelihood > best[1].log_likelihood + 1e-3:
            best = found
    return best


def _stored(est: Estimator, s: Setting) -> Point:
    """A setting with every segment's run stored for derivatives."""
    stored = est.in_threads(lambda i: est.traced(s, i), range(len(est.segments)))
    return Point(s, est.gathered([run for run, _ in stored]), stored)


def _step(est: Estimator, point: Point, damping: float) -> LastStep[Point]:
    """The last trial of one step of sensors and forces."""
    gradient, fisher = _scores(est, point)
    noise = point.setting.noise
    held = _held(est, noise)

    def step(damping: float) -> tuple[np.ndarray, float]:
        return _bounded_step(gradient, fisher + damping * np.diag(np.diag(fisher)), held), np.inf

    def reached(change: np.ndarray) -> Point:
        return _stored(est, replace(point.setting, noise=_moved(est, noise, change)))

    return try_steps(step, reached, point.cost + ROUNDING, damping, 0.0, RULE)


def _held(est: Estimator, noise: Noise) -> np.ndarray:
    """Which numbers of `_scores` are at their lower bound."""
    return np.concatenate([noise.force_sd <= 0.0, [not noise.has_forces], noise.sensor_sd <= est.floors])


def _moved(est: Estimator, noise: Noise, change: np.ndarray) -> Noise:
    """Noise changed by (nf variances of forces, log correlation time, 6 log sds of sensors)."""
    nf = noise.force_sd.size
    q = (noise.force_sd / QUANTUM) ** 2
    new = np.clip(q + change[:nf], 0.0, 30.0 * q + 100.0)
    tau = noise.correlation_time_s * np.exp(np.clip(change[nf], -0.7, 0.7))
    return Noise(
        np.maximum(noise.sensor_sd * np.exp(np.clip(change[nf + 1 :], -0.4, 0.4)), est.floors),
        QUANTUM * np.sqrt(np.where(new < 1e-6, 0.0, new)),
        float(np.clip(tau, SHORTEST_TAU_S * est.clock, LONGEST_TAU_S * est.clock)),
    )


def _scores(est: Estimator, point: Point) -> tuple[np.ndarray, np.ndarray]:
    """Gradient (nf + 7,) and Fisher information of the numbers of `by_noise`.

    Where a derivative along an unstable run is not finite, that by a sensor is taken with the filter's gains held, and
    that by a force is left out.
    """
    e = point.now.e.ravel()
    de, dl = by_noise(est, point)
    with np.errstate(over="ignore", invalid="ignore"):  # a run on its way to divergence
        mean = de + e * dl
        fisher = mean @ mean.T + 2.0 * dl @ dl.T
    lost = ~np.isfinite(np.diag(fisher))
    if lost.any():
        held = _with_gains_held(est, point)
        de[lost], dl[lost] = held[0][lost], held[1][lost]
        mean = de + e * dl
        fisher = mean @ mean.T + 2.0 * dl @ dl.T
    fisher[est.n_forces, est.n_forces] += 1.0
    return -np.sum(dl + e * de, axis=1), fisher


def _with_gains_held(est: Estimator, point: Point) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives as `by_noise` gives them, of the sensors with the filter's gains held and none of the forces."""
    now, first = point.now, est.n_forces + 1
    share = np.where(now.e != 0.0, point.setting.noise.sensor_sd**2 * np.exp(-2.0 * now.log_s), 0.0)
    dl = np.zeros((first + CHANNELS, *share.shape))
    dl[first:] = share * np.eye(CHANNELS)[:, None, :]
    return (-now.e * dl).reshape(len(dl), -1), dl.reshape(len(dl), -1)


def by_noise(est: Estimator, point: Point) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives (nf + 7, N*6) of innovations and of log S / 2 by variances (QUANTUM^2) and log time of the forces,
    and by the log standard deviations of the sensors."""
    from ._derivatives import FORCES, LANES, vary  # numba

    by_e, by_log_s = np.zeros((2, LANES, est.edges[-1] * CHANNELS))
    noise, n = point.setting.noise, len(est.kernels.STATES)

    def along(i: int) -> None:
        run, t = point.stored[i]
        done = (t.transition, t.slopes, t.gains, t.roots, t.spreads, run.e, run.states, est.segments[i].time)
        sds = (noise.sensor_sd, noise.force_sd, noise.correlation_time_s)
        vary(*done, *sds, n, QUANTUM, est.edges[i], by_e, by_log_s)

    est.in_threads(along, range(len(est.segments)))
    rows = [*range(est.n_forces), *range(FORCES - 1, LANES)]
    return by_e[rows], by_log_s[rows]


def _bounded_step(gradient: np.ndarray, fisher: np.ndarray, held: np.ndarray) -> np.ndarray:
    """Scoring step that leaves the numbers at their lower bound (held) which want to be smaller."""
    active = np.diag(fisher) > 0.0
    active &= ~(held & (gradient <= 0.0))
    step = np.zeros(gradient.size)
    while active.any():
        block = fisher[np.ix_(active, active)]
        size = np.sqrt(np.diag(block))
        step[:] = 0.0
        step[active] = (
            np.linalg.solve(block / np.outer(size, size) + RIDGE * np.eye(size.size), gradient[active] / size) / size
        )
        blocked = active & held & (step < 0.0)
        if not blocked.any():
            return step
        active &= ~blocked
    return np.zeros(gradient.size)
