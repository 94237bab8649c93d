"""Causes that set in at an unknown time: scored over a grid of times, in all records or one."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...checks.tails import log_tail
from ...estimation.filters.innovations.derivatives import columns
from ...estimation.filters.innovations.estimator import Estimator
from ...estimation.filters.innovations.settings import Setting
from ..candidate import Candidate, Screened, Variant
from ..state import State
from ..statistics.bootstrap import largest_score
from .base import Here, Search, most_likely, refitted

if TYPE_CHECKING:
    from ..causes.base import Cause


@dataclass(frozen=True)
class ByChangePoint(Search):
    """Score of the size at several times; variants are pairs (size, time).

    grid : number of times over the longest record.
    """

    grid: int = 12
    steady = False
    counts_values = True

    def screen(self, cause: Cause, state: State, here: Here, rng: np.random.Generator) -> Screened:
        est = state.est
        ((size, time),) = state.bank[cause]
        times = np.linspace(0.0, longest(est), self.grid + 2)[1:-1].tolist()
        owners: list[int | None] = [None, *range(est.n_records)] if est.n_records > 1 else [0]
        rows, places = [], []

        def setting_in(t: float) -> np.ndarray:
            return columns(est, est.at(here.setting, time, t), (size,))[0].reshape(-1, 6)

        for t, column in zip(times, state.in_threads(setting_in, times), strict=True):
            for record in owners:
                part = column if record is None else np.where((est.owner == record)[:, None], column, 0.0)
                rows.append(part.ravel())
                places.append((record, t))
        best, score, tests = largest_score(rng, here.projector, np.stack(rows))
        record, t = places[best]
        variant = (replace(size, record=record), replace(time, record=record))
        log_p = log_tail(score.statistic, 1) + np.log(tests)
        return Screened(cause, variant, log_p, score, (float(score.step[0]), t), tests)

    def refit(self, cause: Cause, state: State, item: Screened, before: float, rng: np.random.Generator) -> Candidate:
        est, (size, time) = state.est, item.variant
        s = est.at(est.at(state.setting, time, item.start[1]), size, float(np.clip(item.start[0], -0.8, 0.8)))
        s, _ = state.refit(s, (size,), 2)
        times = np.linspace(0.0, longest(est), 2 * self.grid + 2)[1:-1]
        s = self._best(state, s, time, [float(t) for t in times])  # under gusts that the change no longer hides in
        width, middle = float(times[1] - times[0]), est.value(s, time)
        s = self._best(state, s, time, [middle + share * width for share in (-0.6, -0.4, -0.2, 0.2, 0.4, 0.6)])
        return refitted(cause, state, item.variant, s, 2, item.tests, before)

    def _best(self, state: State, s: Setting, time, values: list[float]) -> Setting:
        settings = [s, *(state.est.at(s, time, value) for value in values)]
        return settings[most_likely(state, settings)]

    def n_sizes(self, variant: Variant) -> int:
        return 1


def longest(est: Estimator) -> float:
    """Duration of the longest record, s."""
    return max(float(d.offset_s + d.time[-1]) for d in est.segments)
