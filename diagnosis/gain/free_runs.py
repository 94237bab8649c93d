"""Free runs of the filter by which a diagnosis decides: from its state after the first seconds, without random forces.

What is told of them are runs as every command has them (`runs.py`).  Quantities that belong to a record (wind, current)
are estimated anew on its first part.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...estimation.diagnosis_only.refit import gauss_newton
from ...estimation.filters.innovations.derivatives import columns
from ...estimation.filters.innovations.estimator import Estimator, Innovations
from ...estimation.filters.innovations.settings import Parameter, Setting
from ...estimation.likelihood.minimiser import Damping, try_steps

START_S = 10.0
"""Time (s, of a 160 m ship) that a free run starts after."""
FIRST_PART = 0.3
"""Share of a held-out record on which its own quantities are estimated."""
BLOCK_S = 20.0
RULE = Damping(growth=6.0, least=0.0, trials=8)
"""Damping of the fit of free runs."""
DRAWS = 1000


def transferred(held: Estimator, s: Setting, per_record: Sequence[Parameter]) -> Setting:
    """A training setting on the held-out records: shared parameters as they are, those of a record at zero."""
    row = s.vectors[0].copy()
    for p in per_record:
        for entry, _ in p.slots:
            row[entry] = held.base[entry]
    return Setting(np.tile(row, (len(held.segments), 1)), s.noise)


def adapted(held: Estimator, s: Setting, variant: Sequence[Parameter], share: float = FIRST_PART) -> Setting:
    """Per-record parameters estimated on the first part of each held-out record."""
    if not variant:
        return s
    early = held.first(share)
    kinds = {(p.name, p.slots): p for p in variant}
    own = [replace(p, record=i) for i in range(held.n_records) for p in kinds.values()]
    found = s
    now = early.evaluate(found)
    for _ in range(6):
        before = now.log_likelihood
        found, now = gauss_newton(early, found, now, own)
        if now.log_likelihood - before < 0.05:
            break
    return replace(found, noise=s.noise)


def fitted_to_simulate(
    est: Estimator, starts: Sequence[Setting], parameters: Sequence[Parameter], most: int = 25
) -> Setting:
    """Parameters that simulate the training records best (output error), from the best of several starts.

    Levenberg-Marquardt on the sum of N log(rms) over channels; heading and positions, which integrate every error,
    count only where no yaw rate is measured.
    """
    sim = simulating(est)
    found = [_simulation_fit(sim, s, parameters, most) for s in starts]
    return min(found, key=lambda one: one.cost).setting


def _simulation_fit(sim: Estimator, s: Setting, parameters: Sequence[Parameter], most: int) -> _Simulated:
    counted = counted_channels(sim)
    here, damping = _simulated(sim, s, counted), 1e-3
    for _ in range(most if len(parameters) < 12 else 8):
        scale, fisher, gradient = _equations(sim, here, parameters, counted)

        def step(d: float, scale=scale, fisher=fisher, gradient=gradient) -> tuple[np.ndarray, float]:
            found = np.linalg.solve(fisher + d * np.eye(len(gradient)), gradient)
            return found / scale, 0.5 * float(gradient @ found)

        def evaluate(change: np.ndarray, here=here) -> _Simulated:
            trial = here.setting
            for p, own in zip(parameters, change, strict=True):
                trial = sim.at(trial, p, sim.value(trial, p) + own)
            return _simulated(sim, trial, counted)

        trial = try_steps(step, evaluate, here.cost, damping, 0.0, RULE)
        if not trial.better:
            break
        gained, here, damping = here.cost - trial.point.cost, trial.point, max(0.2 * trial.damping, 1e-9)
        if gained < 0.1:
            break
    return here


def simulating(est: Estimator) -> Estimator:
    """The same, run freely after the first seconds."""
    return est.simulating(START_S * est.clock)


def counted_channels(est: Estimator) -> np.ndarray:
    """(6,) whether a channel counts in the fit of free runs: heading and positions where no yaw rate is measured."""
    counted = est.channels.copy()
    counted[[0, 4, 5]] &= not est.channels[1]
    return counted


class _Simulated(NamedTuple):
    """A setting with its free runs and their cost."""

    setting: Setting
    now: Innovations
    cost: float


def _simulated(sim: Estimator, s: Setting, counted: np.ndarray) -> _Simulated:
    now = sim.evaluate(s)
    return _Simulated(s, now, _simulation_cost(now, s, counted))


def weights(now: Innovations, counted: np.ndarray) -> np.ndarray:
    """Weight (6,) of each channel's output errors in the fit of free runs: one over their rms, which is at least the
    sensor's noise; 0 where the channel does not count."""
    return np.where(counted, 1.0 / np.maximum(_rms(now), 1.0), 0.0)


def _rms(now: Innovations) -> np.ndarray:
    """Root mean square (6,) of the output errors of each channel, in standard deviations of its sensor."""
    used = (now.e != 0.0).sum(axis=0)
    return np.sqrt((now.e**2).sum(axis=0) / np.maximum(used, 1))


def _equations(
    sim: Estimator, here: _Simulated, parameters: Sequence[Parameter], counted: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Lengths (p,) of the weighted columns, and the normal equations (p, p), (p,) in columns of unit length."""
    weight = weights(here.now, counted)
    rows = (columns(sim, here.setting, parameters).reshape(len(parameters), -1, 6) * weight).reshape(
        len(parameters), -1
    )
    target = (here.now.e * weight).ravel()
    scale = np.linalg.norm(rows, axis=1) + 1e-300
    unit = rows / scale[:, None]
    return scale, unit @ unit.T, -(rows @ target) / scale


def _simulation_cost(now: Innovations, s: Setting, counted: np.ndarray) -> float:
    """Sum of N log(rms) over the channels that count."""
    used, sd = (now.e != 0.0).sum(axis=0), s.noise.sensor_sd
    with np.errstate(over="ignore", invalid="ignore"):
        rms = sd * _rms(now)
        cost = float(np.sum(used[counted] * np.log(np.maximum(rms[counted], sd[counted]))))
    return cost if np.isfinite(cost) else np.inf


def free_run(est: Estimator, s: Setting, segment: int) -> np.ndarray:
    """Predicted channels (T, 6) of a segment, run freely from START_S on.

    The filter only gives the state that the run starts from: where it is lost with the noise of the setting, it starts
    with the first guess of the noise.
    """
    time = est.segments[segment].time
    free = max(int(np.searchsorted(time, min(START_S * est.clock, 0.2 * time[-1]))), 2)
    found = est.free_run(s, segment, free)
    if np.isfinite(found[:, est.channels]).all():
        return found
    return est.free_run(replace(s, noise=est.start().noise), segment, free)


def scored_from(held: Estimator, per_record: bool) -> list[int]:
    """First sample that counts in each record."""
    starts = []
    for d in held.segments:
        start = FIRST_PART * d.time[-1] if per_record else min(START_S * held.clock, 0.2 * d.time[-1])
        starts.append(int(np.searchsorted(d.time, start)) + 1)
    return starts


def error_of(y: np.ndarray, predicted: np.ndarray, c: int) -> np.ndarray:
    """Errors (n,) of a channel, headings by the smaller angle; 1e6 where the prediction is not finite."""
    error = y - predicted
    if c == 0:
        error = np.mod(error + np.pi, 2.0 * np.pi) - np.pi
    return np.where(np.isfinite(predicted) | ~np.isfinite(y), error, 1e6)


def block_samples(est: Estimator, segment: int) -> int:
    """Samples of a block of BLOCK_S, s of a 160 m ship: errors of different blocks count as independent."""
    return max(1, round(BLOCK_S * est.clock / est.segments[segment].step_s))


def error_blocks(error: np.ndarray, size: int) -> list[tuple[float, int]]:
    """Sum of squares and number of the errors (n,) that are known, of each block of `size`."""
    parts = [error[i : i + size] for i in range(0, error.size, size)]
    return [(float(np.nansum(p**2)), int(np.isfinite(p).sum())) for p in parts]


def ratio_of(old: np.ndarray, new: np.ndarray, rng: np.random.Generator) -> tuple[float, float, float]:
    """Ratio of the rms errors new over old, of blocks (B, 2), with its 90 % interval by a block bootstrap."""
    pick = rng.integers(0, len(old), (DRAWS, len(old)))
    ratios = np.sqrt(new[pick, 0].sum(axis=1) / np.maximum(old[pick, 0].sum(axis=1), 1e-300))
    low, high = np.quantile(ratios, [0.05, 0.95])
    whole = np.sqrt(new[:, 0].sum() / max(old[:, 0].sum(), 1e-300))
    return float(whole), float(low), float(high)
