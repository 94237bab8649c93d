"""What enters the extended model: the causes and the numbers that predict left-out training records best.

Each record is simulated with what the other records give.  A choice counts only if no channel is predicted worse than
by the base model, and if its gain is larger than its standard error over the records.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from ..gain.guard import WORSE
from .fit import Fitted
from .shares import left_out, simulated_error, without_numbers


class Entering(NamedTuple):
    """Which of the causes enter, and the parameters (m,) of the fit with them, the model's own numbers at zero where
    these do not enter."""

    causes: tuple[int, ...]
    x: np.ndarray


def entering(final: Fitted, places: Sequence[np.ndarray], named: Sequence[int], numbers: bool) -> Entering:
    """The choice of least error among all subsets of the causes, with and without the model's own numbers.

    Eq. 16 of docs/mathematics/default-route.md.

    places : of each cause's parameters among those of the fit.  named : causes that may enter.  numbers : whether the
    model's own numbers may.
    """
    est, nothing = final.base.est, np.zeros(final.x.size)
    base = _errors(final, [nothing] * est.n_records)
    best, least = Entering((), nothing), 0.0
    for causes in (chosen for count in range(len(named), -1, -1) for chosen in combinations(named, count)):
        kept = np.concatenate([*(places[j] for j in causes), np.zeros(0, int)]).astype(int)
        whole, *others = (left_out(final.expansion, final, r, kept) for r in (None, *range(est.n_records)))
        alone = without_numbers(final, whole), [without_numbers(final, x) for x in others]
        for x, each in (*([(whole, others)] if numbers else []), *([alone] if causes else [])):
            score, surely = _score(base, _errors(final, each))
            if score < least and surely:
                best, least = Entering(causes, x), score
    return best


def _score(base: _Errors, found: _Errors) -> tuple[float, bool]:
    """Mean logarithm of the ratio of errors to the base model's over the channels; whether no channel is worse and the
    gain exceeds its standard error over the records."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = found.rms() / base.rms()
        by_record = np.log(found.of_records() / base.of_records())
    known = ratio[np.isfinite(ratio)]
    score = float(np.mean(np.log(known))) if known.size else 0.0
    each = np.array([np.mean(row[np.isfinite(row)]) for row in by_record if np.isfinite(row).any()])
    error = float(np.std(each, ddof=1) / np.sqrt(each.size)) if each.size > 1 else 0.0
    return score, bool(np.all(known <= WORSE)) and -score > error


class _Errors(NamedTuple):
    """Squared free-run errors and known values of the channels, (R, 6) by record."""

    square: np.ndarray
    known: np.ndarray

    def rms(self) -> np.ndarray:
        """Root mean squared error (6,) of all records; nan where nothing is known."""
        return np.sqrt(self.square.sum(axis=0) / self.known.sum(axis=0))

    def of_records(self) -> np.ndarray:
        """Root mean squared error (R, 6) of each record; nan where nothing is known."""
        return np.sqrt(self.square / self.known)


def _errors(final: Fitted, each: Sequence[np.ndarray]) -> _Errors:
    """Free-run errors of all records, each with parameters (m,) of its own."""
    square, known = np.zeros((len(each), 6)), np.zeros((len(each), 6))
    for i, d in enumerate(final.base.est.segments):
        e = simulated_error(final, each[d.record], i)
        square[d.record] += np.nansum(e**2, axis=0)
        known[d.record] += np.isfinite(e).sum(axis=0)
    return _Errors(square, known)
