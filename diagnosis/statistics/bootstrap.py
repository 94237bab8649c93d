"""Levels of what is not identified, or at the end of its range, where there is no effect.

A change time, a time constant or a frequency means nothing while the effect's size is zero, and a delay, a play or a
variance cannot be negative: the likelihood-ratio statistic is then not chi2.  It is compared with the largest score
over the values that are searched, drawn by multiplier bootstrap (Hansen 1996) around the present setting, the recorded
rudder used again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...estimation.filters.innovations.noise_fit import CLIP
from ...models.linear_algebra import pinv
from .score_tests import Projector, Score, independent_tests

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Innovations
    from ...estimation.filters.innovations.settings import Setting
    from ..state import Point

ONE_SIDED = 0.5
"""How many tests a single score is whose parameter cannot be negative."""
NUDGE = 0.01
"""Share by which noise is changed for the scores of noise."""
TESTABLE = 1e-3
"""Share of a score's information that must survive the nuisance."""


def largest_score(rng: np.random.Generator, projector: Projector, columns: np.ndarray) -> tuple[int, Score, float]:
    """The column (m, n) of largest score, and how many independent tests the choice among them amounts to."""
    scores = [projector.score(column[None]) for column in columns]
    best = int(np.argmax([score.statistic for score in scores]))
    return best, scores[best], independent_tests(rng, projector.terms(projector.project(columns)))


def independent_values(rng: np.random.Generator, point: Point, runs: Sequence[Innovations]) -> float:
    """How many tests of one parameter the choice among its values amounts to, all to one side of zero.

    runs : innovations at the present setting with the effect at each of the values.
    """
    changes = [point.now.change(run).ravel() for run in runs if not run.diverged]
    if not changes:
        return ONE_SIDED
    projector = point.projector
    return independent_tests(rng, projector.terms(projector.project(np.stack(changes))), sided=True)


def independent_variances(
    rng: np.random.Generator, point: Point, settings: Sequence[Setting]
) -> tuple[float, list[float]]:
    """How many tests of one variance the choice among its kinds amounts to, in all segments and in each.

    settings : the present one with a little noise of each kind; that of sensors and gusts is projected out.
    """
    est, noise = point.est, point.setting.noise
    nuisance = []
    for c in np.flatnonzero(est.channels):
        nuisance.append(replace(noise, sensor_sd=_nudged(noise.sensor_sd, int(c))))
    for j in np.flatnonzero(noise.force_sd):
        nuisance.append(replace(noise, force_sd=_nudged(noise.force_sd, int(j))))
    varied = [replace(point.setting, noise=n) for n in nuisance]
    terms = np.stack([_of_variance(point.now, run) for run in est.many([*varied, *settings])])

    def tests(terms: np.ndarray) -> float:
        fixed, own = terms[: len(nuisance)], terms[len(nuisance) :]
        left = own - own @ pinv(fixed) @ fixed
        kept = np.sum(left**2, axis=1) > TESTABLE * np.sum(own**2, axis=1)
        return independent_tests(rng, left[kept], sided=True)

    return tests(terms), [tests(part) for part in np.split(terms, est.edges[1:-1], axis=1)]


def _nudged(sd: np.ndarray, j: int) -> np.ndarray:
    changed = sd.copy()
    changed[j] *= 1.0 + NUDGE
    return changed


def _of_variance(now: Innovations, run: Innovations) -> np.ndarray:
    """What each sample adds (N,) to the score of a little noise."""
    e = np.clip(now.e, -CLIP, CLIP)
    return np.sum((e**2 - 1.0) * (run.log_s - now.log_s) - e * now.change(run), axis=1)
