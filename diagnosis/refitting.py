"""Refits of screened causes with the noise: likelihood ratios from several starts, the leaders to the end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..methods.innovations.estimator import Estimator, Innovations, Setting
from .bootstrap import independent_values
from .causes import CAUSES, Cause, Variant, starts
from .screening import FAULT_GRID
from .search import Candidate, Screened, Search, candidate

QUICK = 2
"""Steps of every leader's refit; those near the best go on."""
RACE_NATS, RACE_SHARE = 10.0, 0.3
"""How far behind the best a candidate may be, in nats or as a share of the best, and still be refitted to the end."""


def refit_cause(search: Search, item: Screened, before: float) -> Candidate:
    """The cause with parameters and noise refitted from the best of its starts."""
    est, s = search.est, search.setting
    entry, variant = CAUSES[item.cause], item.variant
    tests = float(len(search.bank[item.cause]))
    if item.cause == "rudder_fault":
        found, now = _refit_fault(search, item)
        k, tests = 2, item.tests
    elif entry.profile:
        first, second = variant
        s = est.at(est.at(s, second, item.start[1]), first, item.start[0])
        s, _ = search.refit(s, (first,), 2)
        found, now = search.refit(s, variant, QUICK)
        k = 2
    else:
        if entry.rings:
            s = _ring_start(est, s, entry, variant)
        elif entry.scan:
            options = list(starts(est, s, entry, variant))
            runs = est.many(options)
            s = options[int(np.argmax([n.log_likelihood for n in runs]))]
            tests *= independent_values(search, runs[1:])
        found, now = search.refit(s, variant, QUICK)
        k = len(variant)
    return candidate(item.cause, variant, k, tests, before, found, now)


def refined(search: Search, found: Sequence[Candidate], before: float) -> list[Candidate]:
    """The leaders among candidates refitted to the end; what is far behind after the first steps stays as it is."""
    best = max((c.statistic for c in found), default=0.0)
    least = best - max(2.0 * RACE_NATS, RACE_SHARE * best)

    def to_the_end(own: Search, c: Candidate) -> Candidate:
        moved = [*own.parameters, *c.variant]
        setting, now = own.est.refit(c.setting, moved, 8, own.precisions(len(c.variant)))
        return candidate(c.cause, c.variant, c.k, c.tests, before, setting, now)

    leaders = [c for c in found if c.statistic > least]
    return [*search.side_by_side(to_the_end, leaders), *(c for c in found if c.statistic <= least)]


def _ring_start(est: Estimator, s: Setting, entry: Cause, variant: Variant) -> Setting:
    """Each record's (north, east) pair: none or the best of eight directions on the middle ring, or about it on the
    others."""
    inner, middle, outer = np.multiply(entry.rings, est.clock if entry.id != "wave_drift" else 1.0)
    records = range(len(est.data))

    def tried(rings: Sequence[tuple[float, np.ndarray]]) -> np.ndarray:
        """Log likelihoods (R, M) of each record at M sizes and octants (R,)."""
        runs = est.many([_at_ring(est, s, variant, np.full(len(records), size), octant) for size, octant in rings])
        return np.nan_to_num([[_of_record(est, now, i) for now in runs] for i in records], nan=-np.inf)

    first = [(0.0, np.zeros(len(records))), *((middle, np.full(len(records), octant)) for octant in range(8))]
    gains = tried(first)
    octant = np.argmax(gains[:, 1:], axis=1)
    rings = [*first, *((size, octant + turn) for size in (inner, outer) for turn in (-1, 0, 1))]
    best = np.argmax(np.hstack([gains, tried(rings[9:])]), axis=1)
    size = np.array([rings[k][0] for k in best])
    return _at_ring(est, s, variant, size, np.array([rings[k][1][i] for i, k in enumerate(best)]))


def _at_ring(est: Estimator, s: Setting, variant: Variant, size: np.ndarray, octant: np.ndarray) -> Setting:
    """The setting with each record's (north, east) pair of a size (R,) in a direction (R,), in eighths of a turn."""
    pairs = size * np.array([np.cos(np.pi / 4.0 * octant), np.sin(np.pi / 4.0 * octant)])
    for j, p in enumerate(variant):
        s = est.at(s, p, float(pairs[j % 2, p.record]))
    return s


def _of_record(est: Estimator, now: Innovations, i: int) -> float:
    """Log likelihood of record i, short of a constant."""
    rows = slice(est.edges[i], est.edges[i + 1])
    return float(-np.sum(now.log_s[rows]) - 0.5 * np.sum(now.e[rows] ** 2))


def _refit_fault(search: Search, item: Screened) -> tuple[Setting, Innovations]:
    est, (e, t0) = search.est, item.variant
    s = est.at(est.at(search.setting, t0, item.start[1]), e, float(np.clip(item.start[0], -0.8, 0.8)))
    s, _ = search.refit(s, (e,), 2)
    times = np.linspace(0.0, max(d.time[-1] for d in est.data), 2 * FAULT_GRID + 2)[1:-1]
    trials = [s, *(est.at(s, t0, float(t)) for t in times)]  # under gusts that the loss no longer is hidden in
    s = trials[int(np.argmax([n.log_likelihood for n in est.many(trials)]))]
    width, middle = times[1] - times[0], est.value(s, t0)
    shifts = [est.at(s, t0, middle + share * width) for share in (-0.6, -0.4, -0.2, 0.0, 0.2, 0.4, 0.6)]
    s = shifts[int(np.argmax([n.log_likelihood for n in est.many(shifts)]))]
    return search.refit(s, (e, t0), QUICK)


def as_effectiveness(search: Search, fault: Candidate, before: float) -> Candidate | None:
    """The rudder's effectiveness, from where the fit of a fault has come to that is there before the rudder moves."""
    est, (e, t0) = search.est, fault.variant
    moved = [d.time[np.argmax(np.abs(d.rudder - d.rudder[0]) > 0.5 * np.ptp(d.rudder))] for d in est.data]
    named = {a.cause for a in search.accepted}
    untried = "rudder_effectiveness" in search.bank and "rudder_effectiveness" not in named
    if not untried or e.record is not None or est.value(fault.setting, t0) > min(moved):
        return None
    (variant,) = search.bank["rudder_effectiveness"]
    s = est.at(replace(search.setting, noise=fault.setting.noise), variant[0], est.value(fault.setting, e))
    found, now = search.refit(s, variant, QUICK)
    return candidate("rudder_effectiveness", variant, 1, 1.0, before, found, now)
