"""Causes beside an exact base model, or one whose coefficients are free: by the likelihood of the filter's innovations.

The score of every cause says which are refitted.  What enters is refitted with all else; what then no longer gains
significantly leaves again.  A cause whose fit fails stands in the bank with the reason, and the selection goes on
without it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np

from ...checks.tails import log_tail
from ...estimation.diagnosis_only.refit import refit
from ...estimation.filters.innovations.derivatives import columns
from ...estimation.filters.innovations.noise_fit import fit_noise_from_starts
from ...models.errors import FitFailed
from .gusts import penalised_likelihood
from .score_tests import canonical_correlation, effective_number
from .state import (
    HIDING,
    IN_SPAN,
    Candidate,
    Screened,
    State,
    Unmodelled,
    Variant,
    candidate,
    exceeds_misfit,
    is_large,
    matters,
)
from .unmodelled import UNMODELLED, best_unmodelled

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator, Innovations
    from ...estimation.filters.innovations.settings import Parameter, Setting
    from ..causes.base import Cause


T = TypeVar("T")
R = TypeVar("R")


Failures = dict["Cause", str]
"""Causes that linear algebra or arithmetic gave no numbers for, with the reason."""


def attempted(work: Callable[[T], R | None], failed: Failures | None = None) -> Callable[[T], R | None]:
    """Work on a cause, or on what has one, that gives None where a matrix is singular or a number not finite.

    failed : gets the cause, with the reason.
    """

    def guarded(item: T) -> R | None:
        try:
            return work(item)
        except (np.linalg.LinAlgError, ArithmeticError) as error:
            cause: Any = getattr(item, "cause", item)
            if failed is not None:
                failed[cause] = f"its fit fails: {error}"
            return None

    return guarded


class Screen(NamedTuple):
    """Screened causes, best first; those that the nuisance absorbs; columns of the rest by cause and variant; causes
    whose screen failed, with the reason."""

    items: list[Screened]
    in_span: frozenset[Cause]
    families: list[list[np.ndarray]]
    failed: Failures


def screen(state: State, s: Setting, now: Innovations, rng: np.random.Generator) -> Screen:
    """Score of every cause not accepted yet, best variant each."""
    here = state.point if s is state.setting else state.at(s, now).point
    bank = {cause: variants for cause, variants in state.bank.items() if cause not in state.causes}
    out, families, in_span = [], [], set()
    scored = {cause: variants for cause, variants in bank.items() if cause.search.scored}
    for cause, own in _columns(state.est, s, scored).items():
        scores = [here.projector.score(c) for c in own]
        if all(score.share < IN_SPAN for score in scores):
            in_span.add(cause)
            continue
        families.append(own)
        variants = scored[cause]
        ranked = [
            log_tail(score.statistic, len(v)) + np.log(len(variants)) for score, v in zip(scores, variants, strict=True)
        ]
        best = int(np.argmin(ranked))
        out.append(Screened(cause, variants[best], float(ranked[best]), scores[best]))

    failed: Failures = {}
    by_search = attempted(lambda cause: cause.search.screen(cause, state, here, rng), failed)
    out += filter(None, map(by_search, [cause for cause in bank if not cause.search.scored]))
    return Screen(sorted(out, key=lambda c: c.log_p), frozenset(in_span), families, failed)


def counted(state: State, screen: Screen, rng: np.random.Generator) -> State:
    """The state with the first screen and the number of independent tests that the bank amounts to."""
    n = effective_number(state.point.projector, screen.families, rng) if screen.families else 0.0
    return replace(
        state, n_effective=1.0 + n, screened={i.cause: i for i in screen.items}, in_span=state.in_span | screen.in_span
    )


def _columns(est: Estimator, s: Setting, bank: Mapping[Cause, Sequence[Variant]]) -> dict[Cause, list[np.ndarray]]:
    """Columns (k, n) of each variant of each cause; a parameter that stands in several is run once."""
    unique: dict[tuple, Parameter] = {}
    for p in (p for variants in bank.values() for variant in variants for p in variant):
        unique.setdefault((p.name, p.slots, p.record), p)
    rows = dict(zip(unique, columns(est, s, list(unique.values())), strict=True))
    return {
        cause: [np.stack([rows[p.name, p.slots, p.record] for p in variant]) for variant in variants]
        for cause, variants in bank.items()
    }


FIRST, LATER = 0.5, 0.2
"""How the family-wise level is spent: first cause, later ones; effects outside the bank have the rest (UNMODELLED)."""
LEADERS = 4
"""Most screened causes that are refitted: of 83 injected effects and the stronger ones of 27 pairs all that were
significant stood among the first four; what another hides is screened again beside that one."""
TIE_NATS, MOST_TIED = 4.6, 2
"""Log p-values within which significant rivals are tied, and how many are named beside the best."""
LEADING = 0.5
"""Share of the best one's log p-value that a cause needs to be refitted: of 83 injected effects and the stronger ones
of 27 pairs all that were significant stood above .65 of the best."""
TIE_CORRELATION = 0.5
"""Canonical correlation of their projected sensitivities below which two causes are no tie."""
FURTHER, PROMISING = 6, 0.25
"""The same for causes that are refitted as well because their score promises more than what the leaders came to: far
from its maximum (effects in measured records, coefficients that are free) a score says little about the likelihood."""
RACE_NATS, RACE_SHARE = 10.0, 0.3
"""How far behind the best a candidate may be, in nats or as a share of the best, and still be refitted to the end."""


def select(state: State, most: int, rng: np.random.Generator) -> State:
    """Accept causes one after the other while they pass the family-wise level, which the later ones share: by log
    likelihood ratios with the noise refitted, less the cost of gusts.

    Raises
    ------
    FitFailed : the model's run with the records is not finite, whatever the noise.
    """
    state = noise_fitted(state)
    if state.now.diverged:
        raise FitFailed(f"model {state.est.model.id} cannot be run with the records: its filter is not finite")
    for step in range(most):
        state, candidates = _candidates(state, step, state.now.log_likelihood, rng)
        candidates = sorted(candidates, key=lambda c: c.log_p)
        if step == 0:  # at first also what is outside the bank
            rival = best_unmodelled(state, np.log(state.alpha * UNMODELLED), rng)
            state = replace(state, candidates=tuple(candidates), rival=rival)
        level = np.log(state.alpha * (FIRST if step == 0 else LATER / max(most - 1, 1)) / state.n_effective)
        sound = (c for c in candidates if c.log_p < level and matters(state, c) and exceeds_misfit(state, c))
        best = next(sound, None)
        if best is None:
            break
        state = accepted(state, best, candidates, rng)
    return state


def material(state: State) -> tuple[State, frozenset[Cause]]:
    """The state without causes whose sizes are below their floors, and these causes."""
    small: set[Cause] = set()
    while (least := next((a for a in state.accepted if not is_large(state.est, a, state.setting)), None)) is not None:
        small.add(_cause(least))
        state = without(state, least)
    return state, frozenset(small)


def noise_fitted(state: State) -> State:
    """Noise (and free coefficients) of largest likelihood at the present causes.

    From every start: in measured records noise that was fitted beside other causes can be far from the best.
    """
    if state.parameters and not state.accepted:
        state = state.at(*state.refit(state.setting, (), 3))
    before = state.now.log_likelihood
    state = state.at(*fit_noise_from_starts(state.est, state.setting, state.start))
    if state.parameters and state.now.log_likelihood > before + 0.05:
        state = state.at(*state.refit(state.setting, (), 3))
    return state


def _candidates(state: State, step: int, before: float, rng: np.random.Generator) -> tuple[State, list[Candidate]]:
    screened = screen(state, state.setting, state.now, rng)
    state = counted(state, screened, rng) if step == 0 else replace(state, in_span=state.in_span | screened.in_span)
    failed = {**state.failed, **screened.failed}
    candidates = _refitted(state, screened.items, before, rng, failed)
    for complicated in list(candidates):
        simpler = simplified(state, complicated, before, rng)
        if simpler is not None and all(c.log_p > simpler.log_p for c in candidates if c.cause == simpler.cause):
            candidates = [*(c for c in candidates if c.cause != simpler.cause), simpler]

    by_search = attempted(lambda cause: cause.search.attempt(cause, state, before, rng), failed)
    candidates += filter(None, map(by_search, [cause for cause in state.bank if cause not in state.causes]))
    return replace(state, failed=failed), under_gusts(state, refined(state, candidates, before), before)


def simplified(state: State, candidate: Candidate, before: float, rng: np.random.Generator) -> Candidate | None:
    """A simpler cause that describes what a candidate does; None where there is none, or its fit fails."""
    return attempted(lambda c: _cause(c).simpler(state, c, before, rng))(candidate)


def _refitted(
    state: State, items: Sequence[Screened], before: float, rng: np.random.Generator, failed: Failures
) -> list[Candidate]:
    """The leaders of the screen and of one without gusts, then those behind them whose scores promise more."""

    def refits(chosen: Sequence[Screened]) -> list[Candidate]:
        own = dict(zip([i.cause for i in chosen], rng.spawn(len(chosen)), strict=True))  # the same whoever comes first
        refit_one = attempted(lambda i: i.cause.search.refit(i.cause, state, i, before, own[i.cause]), failed)
        return list(filter(None, state.in_threads(refit_one, chosen)))

    level = np.log(0.1 / state.n_effective)
    chosen = _leaders(items, level, LEADERS, LEADING)
    have = {i.cause for i in chosen}
    calm = state.point.calm_now
    if state.setting.noise.has_forces and calm.log_likelihood > before - HIDING:
        quiet = screen(state, replace(state.setting, noise=state.start.noise), calm, rng).items
        chosen += [i for i in _leaders(quiet, -15.0, 3, LEADING) if i.cause not in have]
    candidates, have = refits(chosen), {i.cause for i in chosen}
    kept = max((c.statistic for c in candidates), default=0.0)
    further = _leaders(items, level, FURTHER, PROMISING)
    more = [i for i in further if i.cause not in have and -2.0 * i.log_p > kept]
    return candidates + refits(more)


def _leaders(items: Sequence[Screened], level: float, most: int, share: float) -> list[Screened]:
    """The first of screened causes (best first) that are beyond a level and not far behind the best."""
    return [i for i in items[:most] if i.log_p < min(level, share * items[0].log_p)]


def refined(state: State, candidates: Sequence[Candidate], before: float) -> list[Candidate]:
    """The leaders among candidates refitted to the end; what is far behind after the first steps stays as it is."""
    best = max((c.statistic for c in candidates), default=0.0)
    least = best - max(2.0 * RACE_NATS, RACE_SHARE * best)

    def to_the_end(c: Candidate) -> Candidate:
        moved = [*state.parameters, *c.variant]
        setting, now = refit(state.est, c.setting, moved, 8, state.precisions(len(c.variant)))
        return candidate(c.cause, c.variant, c.k, c.tests, before, setting, now)

    leaders = [c for c in candidates if c.statistic > least]
    ends = state.in_threads(attempted(to_the_end), leaders)
    done = [end or first for first, end in zip(leaders, ends, strict=True)]
    return [*done, *(c for c in candidates if c.statistic <= least)]


def under_gusts(state: State, candidates: Sequence[Candidate], before: float) -> list[Candidate]:
    """Candidates by what they gain over gusts, and by whether they leave any to be assumed."""
    taken = before - state.point.gusts.penalised

    def judged(c: Candidate) -> Candidate:
        left = c.now.log_likelihood - penalised_likelihood(state.est, c.setting, c.now)
        return c.with_statistic(c.statistic + 2.0 * (taken - left))

    return state.in_threads(judged, candidates)


def accepted(state: State, best: Candidate, candidates: Sequence[Candidate], rng: np.random.Generator) -> State:
    """The state with the best candidate and its ties, everything refitted, without earlier causes that lost their
    evidence."""
    near = [c for c in candidates if c is not best and c.log_p - best.log_p < TIE_NATS]
    ties = tuple(_cause(c) for c in near if alike(state, best, c))[:MOST_TIED]
    best = replace(best, tied=ties)
    state = noise_fitted(state.at(best.setting, best.now, (*state.accepted, best)))
    return _simplified(_deleted(state), rng)


def alike(state: State, first: Candidate, second: Candidate) -> bool:
    """Whether two causes move the innovations alike, each at its own size: else both may be true at once."""
    if not (first.variant and second.variant):
        return True
    both = [columns(state.est, c.setting, c.variant) for c in (first, second)]
    return canonical_correlation(state.point.projector, *both) > TIE_CORRELATION


def _deleted(state: State) -> State:
    """Backward deletion of causes that no longer gain significantly; the last only if it brought another down."""
    *earlier, last = state.accepted
    here = state.point.gusts.penalised
    for old in earlier:
        state, here = _tested(state, old, here)
    if len(state.accepted) <= len(earlier):
        state, _ = _tested(state, last, here)
    return state


def _tested(state: State, old: Candidate, here: float) -> tuple[State, float]:
    """The state without a cause if the records, of penalised likelihood `here`, lose little; and what is left."""
    if not old.variant:
        return state, here
    trial = without(state, old)
    left = penalised_likelihood(state.est, trial.setting, trial.now)
    if log_tail(2.0 * (here - left), len(old.variant)) <= np.log(state.alpha / state.n_effective):
        return state, here
    return trial, left


def _simplified(state: State, rng: np.random.Generator) -> State:
    """The state with causes that beside later ones have become a simpler one given up for that."""
    for old in state.accepted:
        others = state.at(lacking(state, old), state.now, [a for a in state.accepted if a is not old])
        here = replace(old, setting=state.setting, now=state.now)
        before = state.now.log_likelihood - 0.5 * old.statistic
        simpler = simplified(others, here, before, rng)
        if simpler is None or simpler.now.log_likelihood <= state.now.log_likelihood - TIE_NATS:
            continue
        entered = [replace(simpler, tied=old.tied) if a is old else a for a in state.accepted]
        state = state.at(simpler.setting, simpler.now, entered)
    return state


def without(state: State, cause: Candidate) -> State:
    """The state with one accepted cause taken out and the rest refitted."""
    kept = [a for a in state.accepted if a is not cause]
    trial = state.at(lacking(state, cause), state.now, kept)
    return trial.at(*trial.refit(trial.setting, (), 4))


def lacking(state: State, cause: Candidate) -> Setting:
    """The present setting with one accepted cause at zero."""
    bare, est = state.setting, state.est
    for p in cause.variant:
        bare = est.at(bare, p, 0.0)
    if cause.variant or isinstance(cause.cause, Unmodelled):
        return bare
    return est.with_entries(bare, {name: float(est.base[est.index[name]]) for name in cause.cause.search.entries})


def _cause(c: Candidate) -> Cause:
    """The cause of a candidate of the bank."""
    assert not isinstance(c.cause, Unmodelled)
    return c.cause
