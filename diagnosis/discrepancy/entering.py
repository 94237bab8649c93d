"""What enters the extended model: the causes and the numbers that predict left-out training records best.

Each record is simulated with what the other records give.  A choice counts only if no channel is predicted worse than
by the base model.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from .fit import Fitted
from .quadratic import mode
from .shares import left_out, simulated_error, without_numbers

WORSE = 1.05
"""Ratio of errors (rms) to the base model's, left-out records, that no channel may exceed."""


class Entering(NamedTuple):
    """Which of the causes enter, and the parameters (m,) of the fit with them, the model's own numbers at zero where
    these do not enter."""

    causes: tuple[int, ...]
    x: np.ndarray


def entering(final: Fitted, places: Sequence[np.ndarray], named: Sequence[int]) -> Entering:
    """The choice of least error among all subsets of the causes with and without the model's own numbers.

    places : of each cause's parameters among those of the fit.  named : causes that may enter.
    """
    segments, nothing = final.base.est.segments, np.zeros(final.x.size)
    base = _rms(final, [nothing] * len(segments))
    best, least = Entering((), nothing), 0.0
    for causes in (chosen for count in range(len(named), -1, -1) for chosen in combinations(named, count)):
        kept = np.concatenate([*(places[j] for j in causes), np.zeros(0, int)]).astype(int)
        whole, others = _whole(final, kept), [left_out(final.expansion, final, d.record, kept) for d in segments]
        alone = without_numbers(final, whole), [without_numbers(final, x) for x in others]
        for x, each in ((whole, others), alone) if causes else ((whole, others),):
            with np.errstate(divide="ignore", invalid="ignore"):
                ratio = _rms(final, each) / base
            known = ratio[np.isfinite(ratio)]
            score = float(np.mean(np.log(known))) if known.size else 0.0
            if score < least and np.all(known <= WORSE):
                best, least = Entering(causes, x), score
    return best


def _whole(final: Fitted, kept: np.ndarray) -> np.ndarray:
    """Parameters by all records with these causes only."""
    if kept.size == len(final.variant):
        return final.x
    return final.base.bounded(mode(final.expansion, final.variances, kept).x, final.variant)


def _rms(final: Fitted, each: Sequence[np.ndarray]) -> np.ndarray:
    """Root mean squared free-run error (6,) of all segments, each with parameters (m,) of its own."""
    square, known = np.zeros(6), np.zeros(6)
    for i, x in enumerate(each):
        e = simulated_error(final, x, i)
        square += np.nansum(e**2, axis=0)
        known += np.isfinite(e).sum(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.sqrt(square / known)
