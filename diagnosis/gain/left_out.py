"""Free-run errors of training records that are left out of the fit: by these causes stay in the extended model or not.

A record is left out by one Gauss-Newton step back from the fit to all of them, without its rows in the normal
equations.  Of a single record, thirds are left out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...estimation.filters.innovations.derivatives import columns
from ...estimation.filters.innovations.vector import CHANNELS
from .free_runs import (
    block_samples,
    counted_channels,
    error_blocks,
    error_of,
    free_run,
    ratio_of,
    scored_from,
    simulating,
    weights,
)

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ...estimation.filters.innovations.settings import Parameter, Setting

PARTS = 3
"""Parts of a single record that are left out in turn."""
SLIGHT = 0.01
"""Share of a channel's own motion by which its error may grow without being of importance."""
RIDGE = 1e-6
"""Added to the normal equations in columns of unit length."""


Blocks = dict[int, np.ndarray]
"""Channel -> (B, 2) sum of squared errors and number of samples of each block of the left-out records."""


def left_out_errors(
    est: Estimator, s: Setting, parameters: Sequence[Parameter], simulated: bool, per_record: bool
) -> Blocks:
    """Squared free-run errors of each channel, SI, in blocks over all parts that were left out.

    Parameters
    ----------
    s : the fit to all records.
    parameters : what was fitted.
    simulated : it was fitted to free runs, else to innovations.
    per_record : some of them belong to a record, which is then scored after the part that they are estimated from; that
        part stays in the fit.
    """
    starts = scored_from(est, per_record)
    parts = _parts(est, starts if per_record else [0] * len(starts))
    steps = _steps_back(est, s, parameters, simulated, parts)
    found: dict[int, list[tuple[float, int]]] = {c: [] for c in np.flatnonzero(est.channels).tolist()}
    for part, step in zip(parts, steps, strict=True):
        trial = s
        for p, change in zip(parameters, step.tolist(), strict=True):
            trial = est.at(trial, p, est.value(trial, p) + change)
        for i in range(len(est.segments)):
            inside = part[est.samples_of(i)].copy()
            inside[: starts[i]] = False
            if not inside.any():
                continue
            predicted = free_run(est, trial, i)
            for c, blocks in found.items():
                error = error_of(est.segments[i].measured[inside, c], predicted[inside, c], c)
                blocks += error_blocks(error, block_samples(est, i))
    return {c: np.array(blocks) for c, blocks in found.items()}


def worst_ratio(before: Blocks, after: Blocks, motion: Mapping[int, float], rng: np.random.Generator) -> float:
    """Largest ratio of errors (rms) among the channels that are predicted worse beyond chance; at least 1.

    motion : of each channel, of which an error must be more than SLIGHT to be worse: errors of the size of the sensors'
        noise depend on the state that a run starts from.
    """
    worst = 1.0
    for c, old in before.items():
        ratio, low, _ = ratio_of(old, after[c], rng)
        lost = (after[c][:, 0].sum() - old[:, 0].sum()) / max(old[:, 1].sum(), 1.0)
        worst = max(worst, ratio) if low > 1.0 and lost > (SLIGHT * motion[c]) ** 2 else worst
    return worst


def motions(est: Estimator) -> dict[int, float]:
    """Standard deviation of each channel about its mean in the records."""
    found = {}
    for c in np.flatnonzero(est.channels).tolist():
        known = [d.measured[np.isfinite(d.measured[:, c]), c] for d in est.segments]
        found[c] = float(np.sqrt(np.mean(np.concatenate([y - y.mean() for y in known if y.size]) ** 2)))
    return found


def best_ratio(before: Blocks, after: Blocks, rng: np.random.Generator) -> float:
    """Smallest ratio of errors (rms) among the channels that are predicted better beyond chance; at most 1."""
    best = 1.0
    for c, old in before.items():
        ratio, _, high = ratio_of(old, after[c], rng)
        best = min(best, ratio) if high < 1.0 else best
    return best


def _parts(est: Estimator, starts: Sequence[int]) -> list[np.ndarray]:
    """Masks (N,) of the samples that are left out together: of a record, or of a part of the only one, from the first
    sample that may be left out of each segment on."""
    late = np.concatenate([np.arange(d.time.size) >= k for d, k in zip(est.segments, starts, strict=True)])
    if est.n_records > 1:
        return [(est.owner == i) & late for i in range(est.n_records)]
    place = np.arange(est.edges[-1]) * PARTS // int(est.edges[-1])
    return [(place == i) & late for i in range(PARTS)]


def _steps_back(
    est: Estimator, s: Setting, parameters: Sequence[Parameter], simulated: bool, parts: Sequence[np.ndarray]
) -> list[np.ndarray]:
    """Change (p,) of the parameters without each part."""
    if not parameters:
        return [np.zeros(0)] * len(parts)
    run = simulating(est) if simulated else est
    now = run.evaluate(s)
    weight = weights(now, counted_channels(run)) if simulated else np.ones(CHANNELS)
    rows = columns(run, s, parameters).reshape(len(parameters), -1, CHANNELS) * weight
    target = now.e * weight
    scale = np.sqrt((rows**2).sum(axis=(1, 2))) + 1e-300
    rows /= scale[:, None, None]
    steps = []
    for part in parts:
        kept = rows[:, ~part].reshape(len(parameters), -1)
        fisher = kept @ kept.T + RIDGE * np.eye(len(parameters))
        # The gradient of what is kept: at the fit to all, that of the part with the other sign.
        gradient = rows[:, part].reshape(len(parameters), -1) @ target[part].ravel()
        steps.append(np.linalg.solve(fisher, gradient) / scale)
    return steps
