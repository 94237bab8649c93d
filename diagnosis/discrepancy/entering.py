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
    """Which of the causes enter, whether the model's own numbers do, and the parameters (m,) of the fit with them."""

    causes: tuple[int, ...]
    numbers: bool
    x: np.ndarray


def entering(final: Fitted, places: Sequence[np.ndarray], named: Sequence[int]) -> Entering:
    """The choice of least error among all subsets of the causes with and without the model's own numbers.

    places : of each cause's parameters among those of the fit.  named : causes that may enter.
    """
    base = _rms(final, None, None)
    best, least = Entering((), False, np.zeros(final.x.size)), 0.0
    for count in range(len(named), -1, -1):
        for causes in combinations(named, count):
            kept = np.concatenate([*(places[j] for j in causes), np.zeros(0, int)]).astype(int)
            for numbers in (True, False):
                if not (numbers or causes):
                    continue
                with np.errstate(divide="ignore", invalid="ignore"):
                    ratio = _rms(final, kept, numbers) / base
                known = ratio[np.isfinite(ratio)]
                score = float(np.mean(np.log(known))) if known.size else 0.0
                if score < least and np.all(known <= WORSE):
                    best, least = Entering(causes, numbers, _whole(final, kept, numbers)), score
    return best


def _whole(final: Fitted, kept: np.ndarray, numbers: bool) -> np.ndarray:
    """Parameters by all records with these causes only."""
    if kept.size == len(final.variant):
        x = final.x
    else:
        x = final.base.bounded(mode(final.expansion, final.variances, kept).x, final.variant)
    return x if numbers else without_numbers(final, x)


def _rms(final: Fitted, kept: np.ndarray | None, numbers: bool | None) -> np.ndarray:
    """Root mean squared free-run error (6,) of left-out records; of the base model where nothing is kept."""
    square, known = np.zeros(6), np.zeros(6)
    for i, d in enumerate(final.base.est.segments):
        x = np.zeros(final.x.size) if kept is None else left_out(final.expansion, final, d.record, kept)
        e = simulated_error(final, x if numbers else without_numbers(final, x), i)
        square += np.nansum(e**2, axis=0)
        known += np.isfinite(e).sum(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.sqrt(square / known)
