"""The bank screened beside the discrepancy: every cause with the scales estimated anew for it, by one linearisation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...checks.statistics.tails import log_tail
from ...estimation.filters.innovations.derivatives import columns
from ..searches.change_point import longest
from .fit import Base, expanded
from .quadratic import START, Quadratic, inflation, mode, scales

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Innovations
    from ...estimation.filters.innovations.settings import Setting
    from ..candidate import Variant
    from ..causes.base import Cause

GRID = 12
"""Times of a change that are tried."""
QUICK = 12
"""Steps of the scales' fixed point in a screen."""


@dataclass(frozen=True)
class Lead:
    """A cause's variant by its screen: statistic, inflation of its variance by the blocks, log p-value, sizes (k,), and
    the time of a change (s)."""

    cause: Cause
    variant: Variant
    statistic: float
    inflation: float
    log_p: float
    sizes: np.ndarray
    time_s: float | None = None


def screen(
    base: Base,
    s: Setting,
    now: Innovations,
    x: np.ndarray,
    accepted: Variant,
    variances: np.ndarray,
    bank: Mapping[Cause, Sequence[Variant]],
) -> list[Lead]:
    """Leads of all causes, best first; x holds the terms' and the accepted parameters' values at the setting."""
    single = {cause: variants for cause, variants in bank.items() if cause.search.scored}
    unique = {(p.name, p.slots, p.record): p for vs in single.values() for v in vs for p in v}
    place = {key: i for i, key in enumerate(unique)}
    changing = [(c, v, t) for c, vs in bank.items() if not c.search.steady for v in vs for t in _times(base)]
    jumps = [columns(base.est, base.est.at(s, v[1], t), v[:1]) for _, v, t in changing]
    extra = tuple(unique.values()) + tuple(replace(v[0], name=f"{v[0].name}@{t:.3g}") for _, v, t in changing)
    whole = np.concatenate([x, np.zeros(len(extra))])
    more = np.vstack(jumps) if jumps else None
    q = expanded(base, s, now, whole, (*accepted, *extra), more)
    held = x.size
    ours = np.arange(len(base.terms.parameters), held)
    here, evidence = scales(q, ours, (variances, START))
    leads = []
    for cause, variants in single.items():
        for v in variants:
            at = np.array([held + place[p.name, p.slots, p.record] for p in v])
            leads.append(_lead(q, cause, v, at, ours, here, evidence, len(variants)))
    for j, (cause, v, t) in enumerate(changing):
        at = np.array([held + len(unique) + j])
        leads.append(replace(_lead(q, cause, v, at, ours, here, evidence, GRID), time_s=t))
    return sorted(leads, key=lambda lead: lead.log_p)


def _times(base: Base) -> list[float]:
    return np.linspace(0.0, longest(base.est), GRID + 2)[1:-1].tolist()


def _lead(
    q: Quadratic, cause: Cause, variant: Variant, at: np.ndarray, ours: np.ndarray, variances: np.ndarray,
    evidence: float, tests: int,
) -> Lead:  # fmt: skip
    """A variant by its screen, with the scales of the discrepancy estimated anew.

    Eq. 10 of docs/mathematics/default-route.md.
    """
    free = np.concatenate([ours, at])
    own, found = scales(q, free, (variances,), QUICK)
    there = mode(q, own, free)
    statistic = 2.0 * (found - evidence)
    places = np.flatnonzero(np.isin(there.active, at))
    spread = inflation(q, there, places)
    first, steady = variant[0], cause.search.steady
    if steady and first.low == 0.0 and there.x[at[0]] < 0.0:
        statistic = 0.0
    log_p = log_tail(max(statistic / spread, 0.0), at.size) + float(np.log(tests))
    return Lead(cause, variant, statistic, spread, log_p, there.x[at])
