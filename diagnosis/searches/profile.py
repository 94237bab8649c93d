"""Causes with a second parameter that means nothing while the first is zero: scored over values of the second."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...checks.statistics.tails import log_tail
from ...estimation.filters.innovations.derivatives import columns
from ..candidate import Candidate, Screened, Variant
from ..state import State
from ..statistics.bootstrap import largest_score
from .base import Here, Search, refitted

if TYPE_CHECKING:
    from ..causes.base import Cause


@dataclass(frozen=True)
class ByProfile(Search):
    """Score of the first parameter at several values of the second.

    values : of the second parameter, s, for a 160 m ship.
    """

    values: tuple[float, ...]

    @property
    def counts_values(self) -> bool:
        return True

    def screen(self, cause: Cause, state: State, here: Here, rng: np.random.Generator) -> Screened:
        est, (variant,) = state.est, state.bank[cause]
        first, second = variant
        values = [x * est.clock - second.origin for x in self.values]
        rows = np.vstack([columns(est, est.at(here.setting, second, value), (first,)) for value in values])
        best, score, tests = largest_score(rng, here.projector, rows)
        log_p = log_tail(score.statistic, 1) + np.log(tests)
        return Screened(cause, variant, log_p, score, (float(score.step[0]), values[best]), tests)

    def refit(self, cause: Cause, state: State, item: Screened, before: float, rng: np.random.Generator) -> Candidate:
        est, (first, second) = state.est, item.variant
        s = est.at(est.at(state.setting, second, item.start[1]), first, item.start[0])
        s, _ = state.refit(s, (first,), 2)
        return refitted(cause, state, item.variant, s, 2, float(len(state.bank[cause])), before)

    def n_sizes(self, variant: Variant) -> int:
        return 1
