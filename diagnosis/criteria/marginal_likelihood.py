"""Causes beside a base model whose own numbers are uncertain, its discrepancy: by marginal likelihood.

The bank is screened at the untouched base and where the discrepancy has taken what it can; the leaders of both are
refitted from no discrepancy at all.  A statistic is twice the gain of marginal likelihood, less for scores that scatter
between blocks of the records more than the likelihood says.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ...checks.statistics.selection import grown
from ...checks.statistics.tails import log_tail
from ...estimation.filters.innovations.noise_fit import fit_noise
from ...estimation.numerics.threads import beside
from ..candidate import Candidate
from ..discrepancy.fit import ROUNDS, Base, Fitted, fit, with_forces
from ..discrepancy.quadratic import START
from ..discrepancy.screen import GRID, Lead, screen
from ..selection.levels import FIRST, LATER, LEADERS, MOST_TIED, TESTS, TIE_NATS

if TYPE_CHECKING:
    from ...estimation.filters.innovations.settings import Setting
    from ..candidate import Variant
    from ..causes.base import Cause
    from ..state import State

PROMISING, FAR = 0.6, 0.05
"""Shares of the threshold and of the best log p-value that a screened cause must reach to be refitted."""
TRIAL = 3
"""Rounds of a fit that only compares times of a change."""
AROUND_S = (23.0, 12.0, 6.0)
"""Steps (s, of a 160 m ship) by which the time of a change is refined."""
BEST_TIMES = 3
WAVES = 20.0
"""Statistic that waves must reach beside a discrepancy: what is left of it feeds them."""


@dataclass(frozen=True, kw_only=True)
class MarginalCandidate(Candidate):
    """A cause refitted beside the discrepancy: its variant is without the time of a change.

    inflation : how much more its score scatters between blocks than the likelihood says.  fitted : the fit with it.
    time_s : time of a change (s).
    """

    cause: Cause = field(kw_only=False)
    inflation: float = 1.0
    fitted: Fitted
    time_s: float | None = None


@dataclass(frozen=True)
class Found:
    """What has been found: the fit without causes, the causes in order, the last fit, the best lead of each cause."""

    null: Fitted
    accepted: tuple[MarginalCandidate, ...]
    final: Fitted
    leads: Mapping[Cause, Lead]


@dataclass(frozen=True)
class MarginalLikelihood:
    """The criterion: marginal likelihood ratios, less for scores that scatter.

    state : the base model with its bank, for searches that scan.  bank : causes that may enter, with their variants.
    untouched : leads at the untouched base.
    """

    state: State
    bank: Mapping[Cause, Sequence[Variant]]
    untouched: Sequence[Lead]
    rng: np.random.Generator

    def tried(self, now: Found, step: int) -> tuple[Found, list[MarginalCandidate]]:
        """The leaders of the screens and what is scanned, best first."""
        final = now.final
        left = {c: v for c, v in self.bank.items() if c not in [a.cause for a in now.accepted]}
        leads = screen(final.base, final.setting, final.now, final.x, final.variant, final.variances, left)
        leads = _in_turn(leads, self.untouched, self._threshold(0)) if step == 0 else leads
        now = replace(now, leads=now.leads or {lead.cause: lead for lead in reversed(leads)})
        leaders = _leaders(leads, self._threshold(step))
        refitting = partial(_refitted_leads, final, leads, leaders, step == 0)
        scanning = partial(_scanned, self.state, final, left, self.rng)
        refitted, scanned = beside(final.base.est.threads, refitting, scanning)
        return now, sorted([*refitted, *scanned], key=lambda c: c.log_p)

    def entered(self, now: Found, tried: Sequence[MarginalCandidate], step: int) -> Found | None:
        """What has been found with the best candidate, and its ties."""
        threshold = self._threshold(step)
        if not tried or tried[0].log_p > threshold:
            return None
        best = tried[0]
        near = [c.cause for c in tried[1:] if _near(best, c, threshold)]
        return replace(now, accepted=(*now.accepted, replace(best, tied=tuple(near[:MOST_TIED]))), final=best.fitted)

    def _threshold(self, step: int) -> float:
        return float(np.log(self.state.alpha * (FIRST if step == 0 else LATER) / TESTS))


def search(
    state: State, base: Base, bank: Mapping[Cause, Sequence[Variant]], most: int, rng: np.random.Generator
) -> Found:
    """Accept causes one after the other while they pass the level.

    Eq. 12 of docs/mathematics/default-route.md.

    state : the base model with its bank, for searches that scan.
    """
    of_its_own = replace(base, est=replace(base.est))  # whose latest runs are its own
    null, raw = beside(base.est.threads, partial(fit, base, base.origin), partial(_untouched, of_its_own, bank))
    found = grown(MarginalLikelihood(state, bank, raw, rng), Found(null, (), null, {}), most)
    kept, final = _without_needless(found.accepted, found.final, float(np.log(state.alpha * LATER / TESTS)))
    return replace(found, accepted=kept, final=final)


def _without_needless(
    accepted: Sequence[MarginalCandidate], final: Fitted, threshold: float
) -> tuple[tuple[MarginalCandidate, ...], Fitted]:
    """The causes without the earlier ones that the later ones make needless, and the fit of those that stay.

    What changes at a time, and waves, stand in the origin of the fit and stay.
    """
    kept = list(accepted)
    for one in accepted[:-1]:
        others = [a for a in kept if a is not one]
        if any(a.time_s is not None or not a.variant for a in kept) or not others:
            break
        sizes = dict(zip(final.variant, final.sizes.tolist(), strict=True))
        variant = tuple(p for a in others for p in a.variant)
        start, terms = np.array([sizes[p] for p in variant]), final.x[: len(final.base.terms.parameters)]
        fitted = fit(final.base, final.setting, variant, start, final.variances, terms=terms)
        statistic = 2.0 * (final.evidence - fitted.evidence) / one.inflation
        if log_tail(max(statistic, 0.0), len(one.variant)) > threshold:
            kept, final = others, fitted
    return tuple(kept), final


def _near(best: MarginalCandidate, other: MarginalCandidate, threshold: float) -> bool:
    return other.log_p - best.log_p < TIE_NATS * max(1.0, best.inflation) and other.log_p < threshold


def _untouched(base: Base, bank: Mapping[Cause, Sequence[Variant]]) -> list[Lead]:
    """Leads at the untouched base: there a large effect is not yet absorbed."""
    s, now = fit_noise(base.est, with_forces(base.origin), 6)
    return screen(base, s, now, np.zeros(len(base.terms.parameters)), (), START, bank)


def _in_turn(first: Sequence[Lead], second: Sequence[Lead], threshold: float) -> list[Lead]:
    """Promising leads of both in turn, then the rest of the first."""
    out: list[Lead] = []
    a, b = ([x for x in leads if x.log_p < PROMISING * threshold] for leads in (first, second))
    for i in range(max(len(a), len(b))):
        out += [*a[i : i + 1], *b[i : i + 1]]
    return [*out, *(x for x in first if x.log_p >= PROMISING * threshold)]


def _leaders(leads: Sequence[Lead], threshold: float) -> list[Lead]:
    seen: list[Cause] = []
    out: list[Lead] = []
    best = min((lead.log_p for lead in leads), default=0.0)
    for lead in leads:
        if (
            lead.log_p < FAR * best
            and lead.cause not in seen
            and lead.log_p < PROMISING * threshold
            and len(out) < LEADERS
        ):
            out.append(lead)
        seen.append(lead.cause)
    return out


def _refitted_leads(now: Fitted, leads: Sequence[Lead], leaders: Sequence[Lead], far: bool) -> list[MarginalCandidate]:
    """The leaders refitted; far : also others that may be far from zero."""
    tried = [_tried(now, lead, leads) for lead in leaders]
    named = [lead.cause for lead in leaders]
    return tried + (_from_far(now, [lead for lead in leads if lead.cause not in named]) if far else [])


def _tried(now: Fitted, lead: Lead, leads: Sequence[Lead]) -> MarginalCandidate:
    """A lead refitted beside what is accepted."""
    if not lead.cause.search.steady:
        return _changing(now, lead, [x.time_s for x in leads if x.cause == lead.cause and x.time_s is not None])
    base, variant = now.base, lead.variant
    start = np.concatenate([now.sizes, _start(base, lead)])
    fitted = _refitted(now, base, variant, start)
    return _candidate(now, lead, variant, fitted, float(len([x for x in leads if x.cause == lead.cause])))


def _refitted(now: Fitted, base: Base, variant: Variant, start: np.ndarray) -> Fitted:
    """The better fit with a lead's parameters of two: from the numbers as they are, which may have taken its effect up,
    and from none."""
    first = _beside(now, base, variant, start)
    second = fit(base, base.origin, (*now.variant, *variant), start, rival=first.evidence)
    return max(first, second, key=lambda f: f.evidence)


def _beside(
    now: Fitted, base: Base, variant: Variant, start: np.ndarray, s: Setting | None = None, rounds: int = ROUNDS
) -> Fitted:
    """A fit with further parameters that starts from the numbers of another; s : whose noise it starts from."""
    terms = now.x[: len(base.terms.parameters)]
    return fit(base, s or now.setting, (*now.variant, *variant), start, now.variances, rounds, terms)


def _from_far(now: Fitted, leads: Sequence[Lead]) -> list[MarginalCandidate]:
    """Causes of a response model that a screen at zero overlooks, such as a long delay, which lags imitate: tried from
    the likeliest of the values of their search."""
    base, out, seen = now.base, [], set()
    for lead in leads:
        if base.est.model.is_3dof or lead.cause in seen or not (lead.cause.search.steady and lead.cause.search.scored):
            continue
        seen.add(lead.cause)
        options = list(lead.cause.search.starts(base.est, with_forces(base.origin), lead.variant))[1:]
        if not options:
            continue
        likeliest = options[int(np.argmax([n.log_likelihood for n in base.est.many(options)]))]
        sizes = [base.est.value(likeliest, p) - base.est.value(base.origin, p) for p in lead.variant]
        fitted = fit(base, base.origin, (*now.variant, *lead.variant), np.concatenate([now.sizes, sizes]))
        out.append(_candidate(now, lead, lead.variant, fitted, float(len(options))))
    return out


def _start(base: Base, lead: Lead) -> np.ndarray:
    """Zero, or for a parameter that cannot be negative its screened size within the values that its search tries."""
    there = list(lead.cause.search.starts(base.est, base.origin, lead.variant))[1:]
    if not there:
        return np.zeros(len(lead.variant))
    first = lead.variant[0]
    tried = [base.est.value(s, first) - base.est.value(base.origin, first) for s in there]
    start = np.zeros(len(lead.variant))
    start[0] = np.clip(lead.sizes[0], min(tried), max(tried))
    return start


def _candidate(
    now: Fitted, lead: Lead, variant: Variant, fitted: Fitted, tests: float, time_s: float | None = None
) -> MarginalCandidate:
    """A refitted cause with its statistic and log p-value (eq. 10 of docs/mathematics/default-route.md)."""
    statistic = 2.0 * (fitted.evidence - now.evidence)
    if not lead.cause.plausible(fitted.base.est, variant, fitted.sizes[len(now.variant) :]):
        statistic = 0.0
    k = len(variant) + (time_s is not None)
    log_p = log_tail(max(statistic / lead.inflation, 0.0), max(k, 1)) + float(np.log(max(tests, 1.0)))
    return MarginalCandidate(
        lead.cause, variant, log_p, statistic, fitted.setting, fitted.now, tests, k,
        inflation=lead.inflation, fitted=fitted, time_s=time_s,
    )  # fmt: skip


def _changing(now: Fitted, lead: Lead, times: Sequence[float]) -> MarginalCandidate:
    """A change at an unknown time: its size fitted at a few times, then around the best."""
    base, (size, time) = now.base, lead.variant
    done: dict[float, Fitted] = {}

    start = np.concatenate([now.sizes, [0.0]])

    def at_time(t: float) -> Base:
        return replace(base, origin=base.est.at(base.origin, time, t))

    def tried(t: float) -> Fitted:
        return _beside(now, at_time(t), (size,), start, rounds=TRIAL)

    def best_time() -> float:
        return max(done, key=lambda t: done[t].evidence)

    ends = 1.0, float(time.high) - 1.0
    for t in times[:BEST_TIMES]:
        done[t] = tried(t)
    for step in AROUND_S:
        middle = best_time()
        for t in (middle - step * base.est.clock, middle + step * base.est.clock):
            t = float(np.clip(t, *ends))
            if t not in done:
                done[t] = tried(t)
    t = best_time()
    return _candidate(now, lead, (size,), _refitted(now, at_time(t), (size,), start), GRID, t)


def _scanned(
    state: State, now: Fitted, bank: Mapping[Cause, Sequence[Variant]], rng: np.random.Generator
) -> list[MarginalCandidate]:
    """Causes that are looked for by scanning, from where the discrepancy is now."""
    out = []
    here = state.at(now.setting, now.now, ())
    for cause in (c for c in bank if not c.search.scored and c.search.steady):
        try:
            c = cause.search.attempt(cause, here, now.now.log_likelihood, rng)
        except (np.linalg.LinAlgError, ArithmeticError):
            continue
        if c is None or c.statistic < WAVES:
            continue
        if c.variant:  # its parameter joins the others
            size = [state.est.value(c.setting, p) for p in c.variant]
            fitted = _beside(now, now.base, c.variant, np.concatenate([now.sizes, size]), c.setting)
        else:
            fitted = fit(replace(now.base, origin=_with_numbers_of(now, c.setting)), c.setting, now.variant, now.sizes)
        lead = Lead(cause, c.variant, c.statistic, 1.0, c.log_p, np.zeros(len(c.variant)))
        out.append(_candidate(now, lead, c.variant, fitted, c.tests))
    return out


def _with_numbers_of(now: Fitted, s: Setting) -> Setting:
    """The origin with the entries that a scan has changed."""
    changed = np.any(s.vectors != now.setting.vectors, axis=0)
    vectors = np.where(changed, s.vectors, now.base.origin.vectors)
    return replace(now.base.origin, vectors=vectors)
