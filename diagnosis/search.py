"""The state of a diagnosis on its way: what was screened and refitted, what is accepted, and what it is worth."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from typing import TypeVar, cast

import numpy as np

from ..methods.innovations.estimator import SYMBOLS, Estimator, Innovations, Parameter, Setting
from ..methods.innovations.layout import CHANNELS
from ..models import model as models
from .causes import CAUSES, Variant
from .evidence import Projector, Score, log_tail
from .gusts import Judged

T = TypeVar("T")
R = TypeVar("R")
SHARE_FIRST, SHARE_LATER, SHARE_UNKNOWN = 0.5, 0.2, 0.3
"""How the family-wise level is spent: first cause, later ones, effects outside the bank."""
HIDDEN = 1000.0
"""Nats that fitted gusts may take up altogether where a cause could be hidden in them; a stronger one shows beside them
(of 74 planted effects in the benchmark two faint ones in calm, 21 and 46 nats, showed without gusts only)."""
IN_SPAN = 1e-3
"""Share of a cause's information that must survive the nuisance, else it is not testable."""
MIMICRY = 4e-4
"""Share of the accepted causes' strength that further ones must exceed: 2 % of their effect, as no cause (a rudder's
corners between samples, a limit's onset) is described to better than that."""


@dataclass(frozen=True)
class Screened:
    """One cause's best variant by its score."""

    cause: str
    variant: Variant
    log_p: float
    score: Score
    start: tuple[float, ...] = ()
    tests: float = 1.0


@dataclass(frozen=True)
class Candidate:
    """A cause after refitting it with the noise: twice the gain in log likelihood (less the cost of gusts where that
    was judged) and its log p-value."""

    cause: str
    variant: Variant
    log_p: float
    statistic: float
    setting: Setting
    now: Innovations
    tests: float = 1.0
    k: int = 0
    """Number of variants or starts that were tried, and degrees of freedom."""
    worth: float = np.nan
    """What the records are worth with an unknown effect (`gusts.worth`)."""

    def gaining(self, statistic: float) -> Candidate:
        """The candidate with another statistic, its log p-value moved along."""
        moved = self.log_p + log_tail(statistic, self.k) - log_tail(self.statistic, self.k)
        return replace(self, statistic=statistic, log_p=moved)


@dataclass
class Search:
    """The state of the selection."""

    est: Estimator
    start: Setting
    setting: Setting
    now: Innovations
    bank: dict[str, list[Variant]]
    rng: np.random.Generator
    alpha: float
    nuisance: tuple[Parameter, ...] = ()
    prior: np.ndarray | None = None
    accepted: list[Candidate] = field(default_factory=list)
    ties: dict[str, tuple[str, ...]] = field(default_factory=dict)
    n_effective: float = 25.0
    first_screen: dict[str, Screened] = field(default_factory=dict)
    first_candidates: list[Candidate] = field(default_factory=list)
    rival: Candidate | None = None
    in_span: set[str] = field(default_factory=set)
    known: dict[str, tuple[Setting, object]] = field(default_factory=dict)
    """What was worked out at a setting, the last one of each (see `once`)."""

    def once(self, what: str, work: Callable[[], T]) -> T:
        """What depends on nothing but the present setting, worked out once for it."""
        setting, found = self.known.get(what, (None, None))
        if setting is not self.setting:
            found = work()
            self.known[what] = (self.setting, found)
        return cast(T, found)

    @property
    def judged(self) -> Judged:
        """What noise like gusts makes of the records at the present setting."""
        return self.once("judged", lambda: Judged(self.est, self.setting, self.now))

    @property
    def bare(self) -> Innovations:
        """Innovations at the present setting under the sensors' noise alone."""
        return self.once("bare", lambda: self.est.evaluate(self.quiet(self.setting)))

    @property
    def present(self) -> Projector:
        """Scores at the present setting."""
        named = ", ".join(a.cause for a in self.accepted)
        return self.once(f"beside {named}", lambda: self.projector(self.setting, self.now))

    @property
    def effects(self) -> dict[str, np.ndarray]:
        """Columns (k, n) of each accepted cause's parameters at the present setting."""
        ends = len(self.nuisance) + np.cumsum([len(a.variant) for a in self.accepted], dtype=int)
        parts = np.split(self.present.nuisance, [len(self.nuisance), *ends])[1:]
        return {a.cause: part for a, part in zip(self.accepted, parts, strict=False)}

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """All that a refit moves: free coefficients, then those of the accepted causes."""
        return (*self.nuisance, *(p for a in self.accepted for p in a.variant))

    def precisions(self, extra: int) -> np.ndarray | None:
        """Prior precisions of the parameters followed by `extra` more, None without a prior."""
        if self.prior is None:
            return None
        return np.concatenate([self.prior, np.zeros(len(self.parameters) - len(self.nuisance) + extra)])

    def refit(self, s: Setting, extra: Variant = (), most: int = 6) -> tuple[Setting, Innovations]:
        """Parameters and noise of largest likelihood, from the gusts at hand and, if any are left, from none.

        Gusts that were fitted while an effect was missing hide how far the effect's size still is from its best.
        """
        moved = [*self.parameters, *extra]
        found, now = self.est.refit(s, moved, most, self.precisions(len(extra)))
        if moved and found.noise[6 : 6 + self.est.n_forces].any() and self._could_be_calm(found, now):
            still, calm = self.est.refit(self.quiet(found), moved, most, self.precisions(len(extra)))
            if calm.log_likelihood > now.log_likelihood:
                return still, calm
        return found, now

    def _could_be_calm(self, found: Setting, now: Innovations) -> bool:
        """Whether the gusts left take up little, or less than half of what they would at the present causes."""
        left = now.log_likelihood - self.est.evaluate(self.quiet(found)).log_likelihood
        taken = now.log_likelihood - self.bare.log_likelihood
        return left < HIDDEN or left < 0.5 * taken

    def side_by_side(self, refit: Callable[[Search, T], Candidate], items: Sequence[T]) -> list[Candidate]:
        """Refits of several items at once: while one sets up its next step, the filter runs for another."""
        jobs = list(zip(items, self.rng.spawn(len(items)), strict=True))  # draws the same whoever comes first
        return on_both_threads(lambda job: refit(replace(self, est=self.est.apart(), rng=job[1]), job[0]), jobs)

    def projector(self, s: Setting, now: Innovations) -> Projector:
        """Scores at a setting with all that a refit moves projected out."""
        fixed = self.est.column(s, now, self.parameters) if self.parameters else np.zeros((0, now.e.size))
        return Projector(now, fixed, self.precisions(0))

    def quiet(self, s: Setting) -> Setting:
        """The setting under the sensors' noise alone."""
        return replace(s, noise=self.start.noise.copy())


def on_both_threads(work: Callable[[T], R], items: Sequence[T]) -> list[R]:
    """The work of every item, in their order, two at a time."""
    with ThreadPoolExecutor(2) as pool:
        return list(pool.map(work, items))


def candidate(
    cause: str, variant: Variant, k: int, tests: float, before: float, setting: Setting, now: Innovations
) -> Candidate:
    statistic = 2.0 * (now.log_likelihood - before)
    return Candidate(cause, variant, log_tail(statistic, k) + np.log(tests), statistic, setting, now, tests=tests, k=k)


def mimicry(search: Search) -> np.ndarray:
    """Evidence (6,) by channel that the accepted causes leave behind because no cause describes a large effect exactly.

    It shows where the effects show.
    """
    left = np.zeros(CHANNELS)
    for a, strength in zip(search.accepted, strengths(search), strict=True):
        left += MIMICRY * strength * shown(search, a)
    return left


def shown(search: Search, named: Candidate) -> np.ndarray:
    """Shares (6,) of the channels in an accepted effect; even ones where no parameter moves it."""
    size = np.array([search.est.value(search.setting, p) for p in named.variant])
    effect = size @ search.effects[named.cause]
    energy = np.sum(effect.reshape(-1, CHANNELS) ** 2, axis=0)
    return energy / energy.sum() if energy.sum() > 0.0 else search.est.channels / search.est.channels.sum()


def stands_out(search: Search, found: Candidate) -> bool:
    """Whether a candidate is stronger, in the channel where it shows most, than what the accepted causes may leave."""
    if not search.accepted:
        return True
    left = mimicry(search)
    if not found.variant:
        return found.statistic > left.sum()
    beside = replace(search, accepted=[*search.accepted, found], setting=found.setting, now=found.now)
    where = shown(beside, found)
    own = found.statistic if found.variant[0].series is not None else strengths(beside)[-1]
    most = int(np.argmax(where))
    return own * where[most] > left[most]


def strengths(search: Search) -> list[float]:
    """Squares of the accepted causes' sizes in units of their standard errors, or their statistics where larger."""
    found, spread, at = [], covariance(search), len(search.nuisance)
    for a in search.accepted:
        k = 1 if CAUSES[a.cause].profile or a.cause == "rudder_fault" else len(a.variant)
        size = np.array([search.est.value(search.setting, p) for p in a.variant[:k]])
        block = spread[at : at + k, at : at + k]
        wald = float(size @ np.linalg.pinv(block, hermitian=True) @ size) if a.variant else 0.0
        found.append(max(wald, a.statistic))
        at += len(a.variant)
    return found


def covariance(search: Search) -> np.ndarray:
    """Covariance of `search.parameters` at the present setting."""
    if not search.parameters:
        return np.zeros((0, 0))
    d = search.present.nuisance
    fisher = d @ d.T
    prior = search.precisions(0)
    fisher += np.diag(prior) if prior is not None else 0.0
    scale = np.sqrt(np.diag(fisher)) + 1e-300
    return np.linalg.pinv(fisher / np.outer(scale, scale), rcond=1e-12, hermitian=True) / np.outer(scale, scale)


def channel_name(c: int) -> str:
    """Record channel of one of the filter's six."""
    return models.CHANNELS[SYMBOLS[c]]
