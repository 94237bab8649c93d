"""Forward selection: screen, refit the leaders, rank, accept, delete, screen again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..methods.innovations.estimator import Setting
from . import unknown
from .attempts import ATTEMPTS
from .evidence import MOST_TIED, TIE_NATS, canonical_correlation, log_tail
from .gusts import worth
from .hypotheses import best_unknown
from .refitting import as_effectiveness, refined, refit_cause
from .screening import screen
from .search import HIDDEN, SHARE_FIRST, SHARE_LATER, SHARE_UNKNOWN, Candidate, Screened, Search, stands_out

LEADERS, LEADING = 4, 0.5
"""Most screened causes that are refitted, and the share of the best one's log p-value that they need: of 83 planted
effects and the stronger ones of 27 pairs all that were significant stood among the first four, above .65 of the best;
what another hides is screened again beside that one."""
FURTHER, PROMISING = 6, 0.25
"""The same for causes that are refitted as well because their score promises more than what the leaders came to: far
from its maximum (effects in measured records, coefficients that are free) a score says little about the likelihood."""
TIE_CORRELATION = 0.5
"""Canonical correlation of their projected sensitivities below which two causes are no tie."""


def select(search: Search, most: int) -> None:
    """Accept causes one after the other while they pass the family-wise level."""
    settle(search)
    for step in range(most):
        before = search.now.log_likelihood
        candidates = _candidates(search, step, before)
        share = SHARE_FIRST if step == 0 else SHARE_LATER / max(most - 1, 1)
        threshold = np.log(search.alpha * share / search.n_effective)
        candidates.sort(key=lambda c: c.log_p)
        if step == 0:
            search.first_candidates = candidates
            search.rival = best_unknown(search, np.log(search.alpha * SHARE_UNKNOWN))
        best = next((c for c in candidates if c.log_p < threshold and stands_out(search, c)), None)
        if best is None:
            return
        accept(search, best, candidates)


def settle(search: Search) -> None:
    """Noise (and free coefficients) of largest likelihood at the present causes.

    From every start: in measured records noise that was fitted beside other causes can be far from the best.
    """
    if search.parameters and not search.accepted:
        search.setting, search.now = search.refit(search.setting, (), 3)
    before = search.now.log_likelihood
    search.setting, search.now = search.est.settle(search.setting, search.start)
    if search.parameters and search.now.log_likelihood > before + 0.05:
        search.setting, search.now = search.refit(search.setting, (), 3)


def _candidates(search: Search, step: int, before: float) -> list[Candidate]:
    items = screen(search, search.setting, search.now, count=step == 0)
    if step == 0:
        search.first_screen = {i.cause: i for i in items}
    found = _refitted(search, items, before)
    for fault in [c for c in found if c.cause == "rudder_fault"]:
        steady = as_effectiveness(search, fault, before)
        if steady is not None and all(c.log_p > steady.log_p for c in found if c.cause == steady.cause):
            found = [*(c for c in found if c.cause != steady.cause), steady]
    named = {a.cause for a in search.accepted}
    for name, attempt in ATTEMPTS.items():
        candidate = attempt(search, before) if name in search.bank and name not in named else None
        found += [candidate] if candidate is not None else []
    return under_gusts(search, refined(search, found, before), before)


def _refitted(search: Search, items: Sequence[Screened], before: float) -> list[Candidate]:
    """The leaders of the screen and of one without gusts, then those behind them whose scores promise more."""

    def refits(chosen: Sequence[Screened]) -> list[Candidate]:
        return search.side_by_side(lambda own, item: refit_cause(own, item, before), chosen)

    level = np.log(0.1 / search.n_effective)
    chosen = _leaders(items, level, LEADERS, LEADING)
    have = {i.cause for i in chosen}
    gusty = search.setting.noise[6 : 6 + search.est.n_forces].any()
    if gusty and search.bare.log_likelihood > before - HIDDEN:
        calm = screen(search, search.quiet(search.setting), search.bare)
        chosen += [i for i in _leaders(calm, -15.0, 3, LEADING) if i.cause not in have]
    found, have = refits(chosen), {i.cause for i in chosen}
    kept = max((c.statistic for c in found), default=0.0)
    further = _leaders(items, level, FURTHER, PROMISING)
    return found + refits([i for i in further if i.cause not in have and -2.0 * i.log_p > kept])


def _leaders(items: Sequence[Screened], level: float, most: int, share: float) -> list[Screened]:
    """The first of screened causes (best first) that are beyond a level and not far behind the best."""
    return [i for i in items[:most] if i.log_p < min(level, share * items[0].log_p)]


def under_gusts(search: Search, found: Sequence[Candidate], before: float) -> list[Candidate]:
    """Candidates by what they gain over gusts, and by whether they leave any to be assumed."""
    taken = before - search.judged.worth

    def judged(own: Search, c: Candidate) -> Candidate:
        left = c.now.log_likelihood - worth(own.est, c.setting, c.now)
        return c.gaining(c.statistic + 2.0 * (taken - left))

    return search.side_by_side(judged, found)


def accept(search: Search, best: Candidate, candidates: Sequence[Candidate]) -> None:
    """Enter the best candidate, note its ties, refit everything and drop earlier causes that lost their evidence."""
    near = [c for c in candidates if c is not best and c.log_p - best.log_p < TIE_NATS]
    search.ties[best.cause] = tuple(c.cause for c in near if alike(search, best, c))[:MOST_TIED]
    search.setting, search.now = best.setting, best.now
    search.accepted.append(best)
    settle(search)
    _delete(search)
    _steady(search)


def alike(search: Search, first: Candidate, second: Candidate) -> bool:
    """Whether two causes move the innovations alike, each at its own size: else both may be true at once."""
    if not (first.variant and second.variant):
        return True
    est = search.est
    columns = [est.column(c.setting, c.now, c.variant) for c in (first, second)]
    return canonical_correlation(search.present, *columns) > TIE_CORRELATION


def _delete(search: Search) -> None:
    """Backward deletion of causes that no longer gain significantly; the last only if it brought another down."""
    *earlier, last = tuple(search.accepted)
    here = search.judged.worth
    for old in earlier:
        here = _tested(search, old, here)
    if len(search.accepted) <= len(earlier):
        _tested(search, last, here)


def _tested(search: Search, old: Candidate, here: float) -> float:
    """Take a cause out if the records, now worth `here`, are hardly worth less without it; what they are worth then."""
    if not old.variant:
        return here
    trial = without(search, old)
    left = worth(search.est, trial.setting, trial.now)
    if log_tail(2.0 * (here - left), len(old.variant)) <= np.log(search.alpha / search.n_effective):
        return here
    search.accepted, search.setting, search.now = trial.accepted, trial.setting, trial.now
    search.ties.pop(old.cause, None)
    return left


def _steady(search: Search) -> None:
    """A fault that beside later causes has come to act before the rudder moves gives way to effectiveness."""
    for fault in [a for a in search.accepted if a.cause == "rudder_fault"]:
        others = replace(search, accepted=[a for a in search.accepted if a is not fault])
        others.setting = _lacking(search, fault)
        here = replace(fault, setting=search.setting, now=search.now)
        steady = as_effectiveness(others, here, search.now.log_likelihood - 0.5 * fault.statistic)
        if steady is not None and steady.now.log_likelihood > search.now.log_likelihood - TIE_NATS:
            search.accepted = [steady if a is fault else a for a in search.accepted]
            search.setting, search.now = steady.setting, steady.now
            search.ties[steady.cause] = search.ties.pop(fault.cause)


def without(search: Search, cause: Candidate) -> Search:
    """The search with one accepted cause taken out and the rest refitted."""
    trial = replace(search, accepted=[a for a in search.accepted if a is not cause])
    trial.setting, trial.now = trial.refit(_lacking(search, cause), (), 4)
    return trial


def _lacking(search: Search, cause: Candidate) -> Setting:
    """The present setting with one accepted cause at zero."""
    bare = search.setting
    for p in cause.variant:
        bare = search.est.at(bare, p, 0.0)
    return bare


def size_tests(search: Search) -> list[tuple[str, float]]:
    """Log p-values of the accepted causes having one size throughout."""
    own = {cause: columns for cause, columns in search.effects.items() if len(columns)}
    return unknown.size_tests(search.est, search.now, search.present, own) if own else []
