"""Score tests of the whole bank at a setting: which causes are refitted.

A cause whose fit fails stands in the bank with the reason, and the selection goes on without it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import numpy as np

from ...checks.tails import log_tail
from ...estimation.filters.innovations.derivatives import columns
from ..candidate import Screened, Variant
from ..searches.base import Here
from ..state import IN_SPAN, State, projector
from ..statistics.score_tests import effective_number

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator, Innovations
    from ...estimation.filters.innovations.settings import Parameter, Setting
    from ..causes.base import Cause


T = TypeVar("T")
R = TypeVar("R")


@dataclass(frozen=True)
class Failed:
    """A candidate that linear algebra or arithmetic gave no numbers for."""

    cause: Cause
    reason: str


def attempted(work: Callable[[T], R], cause_of: Callable[[T], Cause]) -> Callable[[T], R | Failed]:
    """Work on a candidate that says why it failed where a matrix is singular or a number not finite."""

    def guarded(item: T) -> R | Failed:
        try:
            return work(item)
        except (np.linalg.LinAlgError, ArithmeticError) as error:
            return Failed(cause_of(item), f"its fit fails: {error}")

    return guarded


def itself(cause: Cause) -> Cause:
    """The cause of work on a cause."""
    return cause


def sorted_out(state: State, outcomes: Iterable[R | Failed]) -> tuple[State, list[R]]:
    """The state with what failed, and what did not."""
    every = list(outcomes)
    failed = {one.cause: one.reason for one in every if isinstance(one, Failed)}
    kept = [one for one in every if not isinstance(one, Failed)]
    return (replace(state, failed={**state.failed, **failed}) if failed else state), kept


class Screen(NamedTuple):
    """Screened causes, best first; those that the nuisance absorbs; columns of the rest by cause and variant; causes
    whose screen failed, with the reason."""

    items: list[Screened]
    in_span: frozenset[Cause]
    families: list[list[np.ndarray]]
    here: Here
    failed: Mapping[Cause, str]


def screen(state: State, s: Setting, now: Innovations, rng: np.random.Generator) -> Screen:
    """Score of every cause not accepted yet, best variant each."""
    project = state.point.projector
    if s is not state.setting:
        project = projector(state.est, s, now, state.parameters, state.precisions())
    here = Here(s, now, project)
    bank = {cause: variants for cause, variants in state.bank.items() if cause not in state.causes}
    out, families, in_span = [], [], set()
    scored = {cause: variants for cause, variants in bank.items() if cause.search.scored}
    for cause, own in _columns(state.est, s, scored).items():
        scores = [project.score(c) for c in own]
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

    def by_search(cause: Cause) -> Screened | None:
        return cause.search.screen(cause, state, here, rng)

    screened = attempted(by_search, itself)
    others = [screened(cause) for cause in bank if not cause.search.scored]
    failed = {one.cause: one.reason for one in others if isinstance(one, Failed)}
    out += [item for item in others if item is not None and not isinstance(item, Failed)]
    return Screen(sorted(out, key=lambda c: c.log_p), frozenset(in_span), families, here, failed)


def counted(state: State, screen: Screen, rng: np.random.Generator) -> State:
    """The state with the first screen and the number of independent tests that the bank amounts to."""
    n = effective_number(screen.here.projector, screen.families, rng) if screen.families else 0.0
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
