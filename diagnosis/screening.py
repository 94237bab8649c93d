"""Score tests of the whole bank at a setting: which causes are worth a refit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..methods.innovations.estimator import Estimator, Innovations, Parameter, Setting
from .attempts import ATTEMPTS
from .bootstrap import largest_score
from .causes import CAUSES, Variant, fault_variant
from .evidence import Projector, effective_number, log_tail
from .search import IN_SPAN, Screened, Search, on_both_threads

FAULT_GRID = 12


def screen(search: Search, s: Setting, now: Innovations, count: bool = False) -> list[Screened]:
    """Score of every cause not accepted yet, best variant each, best first; `count`: find the effective number."""
    est = search.est
    projector = search.present if s is search.setting else search.projector(s, now)
    used = {a.cause for a in search.accepted} | {"rudder_fault", *ATTEMPTS}
    out, scored = [], {}
    for name, variants in search.bank.items():
        if name in used:
            continue
        if CAUSES[name].profile:
            out.append(_screen_profile(search, s, now, projector, name))
        else:
            scored[name] = variants
    families = []
    for name, columns in _columns(est, s, now, scored).items():
        variants = scored[name]
        scores = [projector.score(c) for c in columns]
        if all(score.share < IN_SPAN for score in scores):
            search.in_span.add(name)
            continue
        families.append(columns)
        ranked = [
            log_tail(score.statistic, len(v)) + np.log(len(variants)) for score, v in zip(scores, variants, strict=True)
        ]
        best = int(np.argmin(ranked))
        out.append(Screened(name, variants[best], float(ranked[best]), scores[best]))
    if "rudder_fault" in search.bank and all(a.cause != "rudder_fault" for a in search.accepted):
        out.append(_screen_fault(search, s, now, projector))
    if count:
        search.n_effective = 1.0 + (effective_number(projector, families, search.rng) if families else 0.0)
    return sorted(out, key=lambda c: c.log_p)


def _columns(
    est: Estimator, s: Setting, now: Innovations, bank: Mapping[str, Sequence[Variant]]
) -> dict[str, list[np.ndarray]]:
    """Columns (k, n) of each variant of each cause; a parameter that stands in several is run once."""
    unique: dict[tuple, Parameter] = {}
    for p in (p for variants in bank.values() for variant in variants for p in variant):
        unique.setdefault((p.name, p.slots, p.record), p)
    rows = dict(zip(unique, est.scores(s, now, list(unique.values())), strict=True))
    return {
        name: [np.stack([rows[p.name, p.slots, p.record] for p in variant]) for variant in variants]
        for name, variants in bank.items()
    }


def _screen_fault(search: Search, s: Setting, now: Innovations, projector: Projector) -> Screened:
    """Loss of effectiveness from a change time on, over a grid of times, in all records or one."""
    est = search.est
    longest = max(d.time[-1] for d in est.data)
    at = est.index["fault_time"]
    times = np.linspace(0.0, longest, FAULT_GRID + 2)[1:-1].tolist()
    columns, places = [], []
    owners = [None, *range(len(est.data))] if len(est.data) > 1 else [0]

    def losing_from(t: float) -> np.ndarray:
        p = s.p.copy()
        p[:, at] = t
        return est.apart().column(replace(s, p=p), now, fault_variant(est, None)[:1])[0].reshape(-1, 6)

    for t, column in zip(times, on_both_threads(losing_from, times), strict=True):
        for record in owners:
            rows = slice(None) if record is None else slice(est.edges[record], est.edges[record + 1])
            part = np.zeros_like(column)
            part[rows] = column[rows]
            columns.append(part.ravel())
            places.append((record, t))
    best, score, tests = largest_score(search, projector, np.stack(columns))
    record, t = places[best]
    log_p = log_tail(score.statistic, 1) + np.log(tests)
    start = (float(score.step[0]), t)
    return Screened("rudder_fault", fault_variant(est, record), log_p, score, start, tests)


def _screen_profile(search: Search, s: Setting, now: Innovations, projector: Projector, name: str) -> Screened:
    """The first parameter's score over values of the second, which means nothing while the first is zero."""
    est, (variant,) = search.est, search.bank[name]
    first, second = variant
    values = [x * est.clock - est.base[second.slots[0][0]] for x in CAUSES[name].profile]
    columns = np.vstack([est.column(est.at(s, second, value), now, (first,)) for value in values])
    best, score, tests = largest_score(search, projector, columns)
    log_p = log_tail(score.statistic, 1) + np.log(tests)
    return Screened(name, variant, log_p, score, (float(score.step[0]), values[best]), tests)
