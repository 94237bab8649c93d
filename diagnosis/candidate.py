"""A cause as a candidate of a selection: screened by its score, then refitted."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..checks.tails import log_tail
from ..estimation.filters.innovations.settings import Parameter

if TYPE_CHECKING:
    from ..estimation.filters.innovations.estimator import Innovations
    from ..estimation.filters.innovations.settings import Setting
    from .causes.base import Cause
    from .statistics.score_tests import Score

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
