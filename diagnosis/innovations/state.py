"""The state of a forward selection: records, present setting, accepted causes; frozen, each step returns a new one.

A cause is a candidate of the selection: screened by its score, then refitted.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from ...checks.tails import log_tail
from ...estimation.diagnosis_only.refit import refit
from ...estimation.filters.innovations.derivatives import columns
from ...estimation.filters.innovations.estimator import Estimator, Innovations
from ...estimation.filters.innovations.settings import Parameter, Setting
from ...estimation.filters.innovations.vector import CHANNELS
from ...estimation.numerics.threads import in_context
from ...models.linear_algebra import information_inverse, pinv
from .gusts import GustLikelihood
from .score_tests import Projector

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Innovations
    from ...estimation.filters.innovations.settings import Setting
    from ..causes.base import Cause
    from .score_tests import Score


Variant = tuple[Parameter, ...]
"""Parameters by which a cause is tried; a cause may have several variants."""


@dataclass(frozen=True)
class Screened:
    """One cause's best variant by its score.

    start : where a refit begins, for searches that need it.  tests : number of independent tests among its values.
    """

    cause: Cause
    variant: Variant
    log_p: float
    score: Score
    start: tuple[float, ...] = ()
    tests: float = 1.0


@dataclass(frozen=True)
class Unmodelled:
    """An effect outside the bank, by the label of its best description."""

    label: str


@dataclass(frozen=True)
class Candidate:
    """A cause (or an unmodelled effect) after refitting it with the noise.

    statistic : likelihood-ratio statistic, less the cost of gusts where that was judged; log_p its log p-value.
    tests : number of variants or starts that were tried.  k : degrees of freedom.
    penalised : penalised log likelihood of the records with an unmodelled effect (see `statistics.gusts`).
    tied : causes that it cannot be told from.
    """

    cause: Cause | Unmodelled
    variant: Variant
    log_p: float
    statistic: float
    setting: Setting
    now: Innovations
    tests: float = 1.0
    k: int = 0
    penalised: float = np.nan
    tied: tuple[Cause, ...] = ()

    def with_statistic(self, statistic: float) -> Candidate:
        """The candidate with another statistic and the log p-value that goes with it."""
        moved = self.log_p + log_tail(statistic, self.k) - log_tail(self.statistic, self.k)
        return replace(self, statistic=statistic, log_p=moved)


def candidate(
    cause: Cause | Unmodelled, variant: Variant, k: int, tests: float, before: float, setting: Setting, now: Innovations
) -> Candidate:
    """A refitted cause against the log likelihood `before` without it."""
    statistic = 2.0 * (now.log_likelihood - before)
    return Candidate(cause, variant, log_tail(statistic, k) + np.log(tests), statistic, setting, now, tests=tests, k=k)


T = TypeVar("T")
R = TypeVar("R")
HIDING = 1000.0
"""Nats that fitted gusts may absorb altogether where a cause could be hidden in them; a stronger one shows beside them
(of 74 injected effects in the benchmark two faint ones in calm, 21 and 46 nats, showed without gusts only)."""
TESTS = 25.0
"""Independent tests that the bank amounts to, where they are not counted."""
IN_SPAN = 1e-3
"""Share of a cause's information that must survive the nuisance, else it is not testable."""
MISFIT = 4e-4
"""Share of the accepted causes' strength that further ones must exceed: 2 % of their effect, as no cause (a rudder's
corners between samples, a limit's onset) is described to better than that."""


@dataclass(frozen=True)
class Point:
    """A setting with its innovations, and what follows from them alone (each worked out once).

    parameters : all that a refit moves.  prior : their precisions, None without any.
    """

    est: Estimator
    start: Setting
    setting: Setting
    now: Innovations
    parameters: tuple[Parameter, ...]
    prior: np.ndarray | None

    @cached_property
    def gusts(self) -> GustLikelihood:
        """The records under forces like gusts."""
        return GustLikelihood(self.est, self.setting, self.now)

    @cached_property
    def calm_now(self) -> Innovations:
        """Innovations under the first guess of the sensors' noise alone."""
        return self.est.evaluate(replace(self.setting, noise=self.start.noise))

    @cached_property
    def projector(self) -> Projector:
        """Scores with all that a refit moves projected out."""
        fixed = columns(self.est, self.setting, self.parameters) if self.parameters else np.zeros((0, self.now.e.size))
        return Projector(self.now, fixed, self.prior)


@dataclass(frozen=True)
class State:
    """The state of the selection.

    bank : testable causes and their variants.  nuisance, prior : free coefficients and the precisions of their prior.
    accepted : causes that are in.
    n_effective : independent tests that the bank amounts to.  screened, candidates, rival : of the first step: all
    screened causes, all refitted ones, and the best unmodelled effect.  in_span : causes that the nuisance absorbs.
    failed : causes whose fit failed, with the reason.
    """

    est: Estimator
    start: Setting
    point: Point
    bank: Mapping[Cause, tuple[Variant, ...]]
    alpha: float
    nuisance: tuple[Parameter, ...] = ()
    prior: np.ndarray | None = None
    accepted: tuple[Candidate, ...] = ()
    n_effective: float = TESTS
    screened: Mapping[Cause, Screened] = field(default_factory=dict)
    candidates: tuple[Candidate, ...] = ()
    rival: Candidate | None = None
    in_span: frozenset[Cause] = frozenset()
    failed: Mapping[Cause, str] = field(default_factory=dict)

    @property
    def setting(self) -> Setting:
        """The present setting."""
        return self.point.setting

    @property
    def now(self) -> Innovations:
        """Innovations at the present setting."""
        return self.point.now

    @property
    def causes(self) -> tuple[Cause, ...]:
        """The accepted causes."""
        return tuple(a.cause for a in self.accepted if not isinstance(a.cause, Unmodelled))

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """All that a refit moves: free coefficients, then those of the accepted causes."""
        return (*self.nuisance, *(p for a in self.accepted for p in a.variant))

    def precisions(self, extra: int = 0) -> np.ndarray | None:
        """Prior precisions of the parameters followed by `extra` more, None without a prior."""
        if self.prior is None:
            return None
        return np.concatenate([self.prior, np.zeros(len(self.parameters) - len(self.nuisance) + extra)])

    def at(self, setting: Setting, now: Innovations, accepted: Sequence[Candidate] | None = None) -> State:
        """The state at another setting, with other accepted causes if any are given."""
        moved = self if accepted is None else replace(self, accepted=tuple(accepted))
        point = Point(self.est, self.start, setting, now, moved.parameters, moved.precisions())
        return replace(moved, point=point)

    @property
    def effects(self) -> dict[Cause, np.ndarray]:
        """Columns (k, n) of each accepted cause's parameters at the present setting."""
        ends = len(self.nuisance) + np.cumsum([len(a.variant) for a in self.accepted], dtype=int)
        parts = np.split(self.point.projector.nuisance, [len(self.nuisance), *ends])[1:]
        return dict(zip(self.causes, parts, strict=False))

    def refit(self, s: Setting, extra: Variant = (), most: int = 6) -> tuple[Setting, Innovations]:
        """Parameters and noise of largest likelihood, from the random present forces and, if any are left, from none.

        Forces that were fitted while an effect was missing hide how far the effect's size still is from its best.
        """
        moved, prior = [*self.parameters, *extra], self.precisions(len(extra))
        setting, now = refit(self.est, s, moved, most, prior)
        if moved and setting.noise.has_forces and self._could_be_calm(setting, now):
            still, calm = refit(self.est, replace(setting, noise=self.start.noise), moved, most, prior)
            if calm.log_likelihood > now.log_likelihood:
                return still, calm
        return setting, now

    def _could_be_calm(self, setting: Setting, now: Innovations) -> bool:
        """Whether the forces left absorb little, or less than half of what they would at the present causes."""
        calm = self.est.evaluate(replace(setting, noise=self.start.noise))
        left = now.log_likelihood - calm.log_likelihood
        taken = now.log_likelihood - self.point.calm_now.log_likelihood
        return left < HIDING or left < 0.5 * taken

    def in_threads(self, work: Callable[[T], R], items: Sequence[T]) -> list[R]:
        """Results of work that runs the filter, in the order of the items: while one sets up its next step, the filter
        runs for another."""
        from concurrent.futures import ThreadPoolExecutor

        if self.est.threads < 2:
            return [work(item) for item in items]
        with ThreadPoolExecutor(self.est.threads) as pool:
            return list(pool.map(in_context(work), items))


def first_state(
    est: Estimator,
    bank: Mapping[Cause, tuple[Variant, ...]],
    alpha: float,
    nuisance: tuple[Parameter, ...],
    prior: np.ndarray | None,
) -> State:
    """The base model with the first guess of its sensors' noise."""
    start = est.start()
    point = Point(est, start, start, est.evaluate(start), nuisance, prior)
    return State(est, start, point, bank, alpha, nuisance, prior)


def covariance(state: State) -> np.ndarray:
    """Covariance of `state.parameters` at the present setting."""
    if not state.parameters:
        return np.zeros((0, 0))
    d, prior = state.point.projector.nuisance, state.precisions()
    fisher = d @ d.T + (np.diag(prior) if prior is not None else 0.0)
    return information_inverse(fisher, 1e-12)


# ---- what the accepted causes may leave behind
def misfit_allowance(state: State) -> np.ndarray:
    """Evidence (6,) by channel that the accepted causes leave behind because no cause describes a large effect exactly.

    It shows where the effects show.
    """
    left = np.zeros(CHANNELS)
    for a, strength in zip(state.accepted, strengths(state), strict=True):
        left += MISFIT * strength * channel_shares(state, a)
    return left


def channel_shares(state: State, entry: Candidate) -> np.ndarray:
    """Shares (6,) of the channels in an accepted effect; even ones where no parameter moves it."""
    size = np.array([state.est.value(state.setting, p) for p in entry.variant])
    place = state.accepted.index(entry)
    first = len(state.nuisance) + sum(len(a.variant) for a in state.accepted[:place])
    effect = size @ state.point.projector.nuisance[first : first + len(entry.variant)]
    energy = np.sum(np.reshape(effect, (-1, CHANNELS)) ** 2, axis=0)
    return energy / energy.sum() if energy.sum() > 0.0 else state.est.channels / state.est.channels.sum()


def matters(state: State, candidate: Candidate) -> bool:
    """Whether a candidate is above its cause's floor; that counts where the base model's coefficients are fitted to the
    records, which is never exact: very small sizes are what it lacks elsewhere.  The reference speed is none of them:
    every response model whose surge is measured has it fitted."""
    speed = state.est.index.get("reference_speed")
    free = any(entry != speed for p in state.nuisance for entry, _ in p.slots)
    return not free or is_large(state.est, candidate, candidate.setting)


def is_large(est: Estimator, candidate: Candidate, at: Setting) -> bool:
    """Whether a candidate's sizes at a setting are above its cause's floor, as what is in no bank always is."""
    if isinstance(candidate.cause, Unmodelled):
        return True
    return candidate.cause.matters(est, candidate.variant, np.array([est.value(at, p) for p in candidate.variant]))


def exceeds_misfit(state: State, candidate: Candidate) -> bool:
    """Whether a candidate is stronger, in the channel where it shows most, than what the accepted causes may leave."""
    if not state.accepted:
        return True
    left = misfit_allowance(state)
    if not candidate.variant:
        return candidate.statistic > left.sum()
    with_it = state.at(candidate.setting, candidate.now, (*state.accepted, candidate))
    where = channel_shares(with_it, candidate)
    own = candidate.statistic if candidate.variant[0].series is not None else strengths(with_it)[-1]
    most = int(np.argmax(where))
    return own * where[most] > left[most]


def strengths(state: State) -> list[float]:
    """Squares of the accepted causes' sizes in units of their standard errors, or their statistics where larger."""
    out, spread, at = [], covariance(state), len(state.nuisance)
    for a in state.accepted:
        k = 1 if not isinstance(a.cause, Unmodelled) and a.cause.search.of_first else len(a.variant)
        size = np.array([state.est.value(state.setting, p) for p in a.variant[:k]])
        block = spread[at : at + k, at : at + k]
        wald = float(size @ pinv(block, hermitian=True) @ size) if a.variant else 0.0
        out.append(max(wald, a.statistic))
        at += len(a.variant)
    return out
