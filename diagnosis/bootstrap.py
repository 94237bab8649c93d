"""Levels of what is not identified, or at the end of its range, where there is no effect.

A change time, a time constant or a frequency means nothing while the effect's size is zero, and a delay, a play or a
variance cannot be negative: twice the gain in log likelihood is then no chi2.  It is held against the largest score
over the values that are searched, drawn by multiplier bootstrap (Hansen 1996) around the present setting, the recorded
rudder used again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..methods.innovations.estimator import CLIP, Innovations, Setting
from ..methods.innovations.layout import CHANNELS
from .evidence import Projector, Score, independent
from .search import IN_SPAN, Search

ONE_SIDED = 0.5
"""How many tests a single score is whose parameter cannot be negative."""
NUDGE = 0.01
"""Share by which noise is changed for the scores of noise."""


def largest_score(search: Search, projector: Projector, columns: np.ndarray) -> tuple[int, Score, float]:
    """The column (m, n) of largest score, and how many independent tests the choice among them amounts to."""
    scores = [projector.score(column[None]) for column in columns]
    best = int(np.argmax([score.statistic for score in scores]))
    return best, scores[best], independent(search.rng, projector.terms(projector.project(columns)))


def independent_values(search: Search, runs: Sequence[Innovations]) -> float:
    """How many tests of one parameter the choice among its values amounts to, all to one side of zero.

    runs : innovations at the present setting with the effect at each of the values.
    """
    changes = [search.now.change(run).ravel() for run in runs if run.log_likelihood > -1e299]
    if not changes:
        return ONE_SIDED
    projector = search.present
    return independent(search.rng, projector.terms(projector.project(np.stack(changes))), sided=True)


def independent_noise(search: Search, settings: Sequence[Setting]) -> tuple[float, list[float]]:
    """How many tests of one variance the choice among its kinds amounts to, in all records and in each.

    settings : the present one with a little noise of each kind; that of sensors and gusts is projected out.
    """
    est, noise = search.est, search.setting.noise
    nuisance = []
    for j in [*np.flatnonzero(est.channels), *(CHANNELS + np.flatnonzero(noise[CHANNELS : CHANNELS + est.n_forces]))]:
        nudged = noise.copy()
        nudged[j] *= 1.0 + NUDGE
        nuisance.append(replace(search.setting, noise=nudged))
    terms = np.stack([_of_variance(search.now, run) for run in est.many([*nuisance, *settings])])

    def tests(terms: np.ndarray) -> float:
        fixed, own = terms[: len(nuisance)], terms[len(nuisance) :]
        left = own - own @ np.linalg.pinv(fixed) @ fixed
        told = np.sum(left**2, axis=1) > IN_SPAN * np.sum(own**2, axis=1)
        return independent(search.rng, left[told], sided=True)

    return tests(terms), [tests(part) for part in np.split(terms, est.edges[1:-1], axis=1)]


def _of_variance(now: Innovations, run: Innovations) -> np.ndarray:
    """What each sample adds (N,) to the score of a little noise."""
    e = np.clip(now.e, -CLIP, CLIP)
    return np.sum((e**2 - 1.0) * (run.log_s - now.log_s) - e * now.change(run), axis=1)
