"""Sizes of the causes beside a discrepancy, with robust intervals, and whether they differ between records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...checks.result import NORMAL_90
from ...checks.statistics.random_effects import random_effects_mean
from ..causes.base import Cause
from ..criteria.marginal_likelihood import AROUND_S
from .fit import expanded
from .quadratic import by_record, mode, robust_covariance

if TYPE_CHECKING:
    from ..candidate import Variant
    from ..criteria.marginal_likelihood import Found, MarginalCandidate
    from .quadratic import Quadratic


@dataclass(frozen=True)
class Sized:
    """An accepted cause: values and covariance of its parameters, standard deviation between records and probability of
    equal sizes (None where each record has its own)."""

    accepted: MarginalCandidate
    variant: Variant
    values: np.ndarray
    covariance: np.ndarray
    between: float
    p_equal: float | None

    @property
    def clear(self) -> bool:
        """Whether the sizes are clearly not zero."""
        if not self.variant:
            return True
        k = self.accepted.cause.search.n_sizes(self.variant)
        if self.variant[0].record is not None and self.variant[0].record >= 0 and k > 1:
            return True  # pairs by record: their test has passed
        sd = float(np.sqrt(max(self.covariance[0, 0], 0.0)))
        return abs(float(self.values[0])) > NORMAL_90 * sd


def sized(found: Found, bank: Mapping[Cause, Sequence[Variant]]) -> list[Sized]:
    """Sizes of all accepted causes from one expansion, the time of a change among the parameters."""
    final, held = found.final, len(found.final.base.terms.parameters)
    times = [(a, next(iter(bank[a.cause]))[1]) for a in found.accepted if a.time_s is not None]
    variant = (*final.variant, *(replace(time, low=-np.inf, high=np.inf) for _, time in times))
    x = np.concatenate([final.x, np.zeros(len(times))])
    q = expanded(final.base, final.setting, final.now, x, variant)
    at_mode = mode(q, final.variances, np.arange(held, x.size))
    out, at = [], held
    for a in found.accepted:
        places = np.arange(at, at + len(a.variant))
        at += len(a.variant)
        own = a.variant
        if a.time_s is not None:
            j = [b for b, _ in times].index(a)
            places = np.append(places, final.x.size + j)
            own = (*own, times[j][1])
        values = np.concatenate([final.x, [t.time_s or 0.0 for t, _ in times]])[places] if len(places) else np.zeros(0)
        covariance = _covariance(q, at_mode, places)
        if a.time_s is not None:
            covariance[-1, -1] += (0.5 * AROUND_S[-1] * final.base.est.clock / NORMAL_90) ** 2
        between, p_equal = 0.0, None
        if len(own) and own[0].record is None and a.time_s is None and final.base.est.n_records > 1:
            between, p_equal = _between(q, final.variances, places)
            covariance = covariance + between**2 / final.base.est.n_records * np.eye(len(places))
        out.append(Sized(a, own, values, covariance, between, p_equal))
    return out


def _covariance(q: Quadratic, at_mode, places: np.ndarray) -> np.ndarray:
    """Covariance by the likelihood with variances that are at least those of the blocks' scatter."""
    own = np.array([int(np.flatnonzero(at_mode.active == p)[0]) for p in places], int)
    model = at_mode.covariance[np.ix_(own, own)]
    robust = np.diag(robust_covariance(q, at_mode, own)) if own.size else np.zeros(0)
    grow = np.sqrt(np.maximum(robust / np.maximum(np.diag(model), 1e-300), 1.0))
    return model * np.outer(grow, grow)


def _between(q: Quadratic, variances: np.ndarray, places: np.ndarray) -> tuple[float, float]:
    values, spread = by_record(q, variances, places)
    usable = np.isfinite(spread[:, 0]) & (spread[:, 0] > 0.0)
    if usable.sum() < 2:
        return 0.0, 1.0
    mean = random_effects_mean(values[usable, 0], spread[usable, 0])
    return mean.between, mean.p_equal
