"""What every search offers: a cause is screened by a score and then refitted, or tried directly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...estimation.filters.innovations.estimator import Estimator, Innovations
from ...estimation.filters.innovations.settings import Setting
from ..candidate import Candidate, Screened, Variant, candidate
from ..state import State

if TYPE_CHECKING:
    from ..causes.base import Cause
    from ..statistics.score_tests import Projector

FIRST_STEPS = 2
"""Steps of every leader's refit; those near the best go on."""


@dataclass(frozen=True)
class Here:
    """Where a screen looks: a setting with its innovations and the projection of the nuisance."""

    setting: Setting
    now: Innovations
    projector: Projector


class Search:
    """How a cause is looked for.

    scored : the variants are scored together with those of other causes (`screen` is then not called).
    steady : what belongs to a record holds all through it, so that other records have their own.
    counts_values : the level counts how many independent tests the tried values amount to.
    entries : numbers of the filter's vector that hold a cause without parameters.
    """

    scored = False
    steady = True
    counts_values = False

    @property
    def entries(self) -> tuple[str, ...]:
        return ()

    def screen(self, cause: Cause, state: State, here: Here, rng: np.random.Generator) -> Screened | None:
        """The cause's best variant by its score; None for a cause that is tried directly."""
        return None

    def refit(self, cause: Cause, state: State, item: Screened, before: float, rng: np.random.Generator) -> Candidate:
        """The screened cause with parameters and noise refitted; before: the log likelihood without it."""
        raise TypeError(f"{type(self).__name__} does not screen")

    def attempt(self, cause: Cause, state: State, before: float, rng: np.random.Generator) -> Candidate | None:
        """The cause tried without a screen; None where it gains nothing, or was screened."""
        return None

    def n_sizes(self, variant: Variant) -> int:
        """How many of a variant's parameters, the first ones, measure the effect's strength."""
        return len(variant)

    def starts(self, est: Estimator, s: Setting, variant: Variant) -> Sequence[Setting]:
        """Settings that a refit may start from, the given one first."""
        return [s]


def refitted(
    cause: Cause, state: State, variant: Variant, start: Setting, k: int, tests: float, before: float
) -> Candidate:
    """A candidate after the first steps of a refit."""
    return candidate(cause, variant, k, tests, before, *state.refit(start, variant, FIRST_STEPS))


def most_likely(state: State, settings: Sequence[Setting]) -> int:
    """Index of the setting of largest likelihood."""
    return int(np.argmax([now.log_likelihood for now in state.est.many(settings)]))
