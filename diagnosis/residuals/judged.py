"""Whether something stays unexplained once causes are named."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..candidate import Candidate, Unmodelled
from ..causes.sensors import HeadingDelay
from ..state import State, misfit_allowance
from ..statistics.score_tests import cauchy_combination
from . import tests
from .criterion import UNMODELLED, size_tests
from .features import YAW_RATE_IN_HEADING
from .unmodelled import best_unmodelled, margin_over_unmodelled

RIVALLED_NATS, RIVALLED_LEVEL = 30.0, 0.05
"""How near an unmodelled effect may come to what was named before its sizes are tested at a level of their own, and
that level: right names stand so near where effects are faint, and faint ones' small faults of description do not
show."""


def unexplained(state: State, rng: np.random.Generator) -> Candidate | None:
    """An effect outside the bank that the innovations still show, or that alone beats all that was named.

    What an unmodelled effect comes near to must be the same throughout the records at a level of its own.
    """
    threshold = float(np.log(state.alpha * UNMODELLED))
    effect = best_unmodelled(state, threshold, rng) if state.accepted else state.rival
    if effect is not None and not _is_small_delay(state, effect):
        return effect
    margin = margin_over_unmodelled(state)
    if margin < 0.0:
        return state.rival
    sizes = size_tests(state)
    if margin < RIVALLED_NATS and sizes:
        log_p = cauchy_combination([p for _, p in sizes])
        if log_p < np.log(RIVALLED_LEVEL):
            return _without_form(state, smallest(sizes)[0], log_p)
    line = tests.line_test(state.est, state.now)
    label, log_p = smallest(
        [
            *tests.activity_tests(state.est, state.now),
            *tests.whiteness_tests(state.est, state.now),
            *sizes,
            (f"a periodic error at {line[1]:.3g} rad/s", line[0]),
        ]
    )
    allowed = min(threshold, -0.5 * float(misfit_allowance(state).sum()))
    return _without_form(state, label, log_p) if log_p < allowed else None


def _is_small_delay(state: State, candidate: Candidate) -> bool:
    """Whether an unmodelled effect is a heading that is late, or early, by less than the cause of that name counts,
    where the sensors' channels have decided on that cause."""
    tested = any(isinstance(cause, HeadingDelay) for cause in state.bank)
    if tested or [p.name.split(":")[0] for p in candidate.variant] != [YAW_RATE_IN_HEADING]:
        return False
    est = state.est
    rate = state.now.states[:, est.kernels.STATES.index("r")]
    late_s = est.value(candidate.setting, candidate.variant[0]) / float(np.sqrt(np.mean(rate**2)))
    delay = HeadingDelay()
    return not delay.matters(est, delay.variants(est)[0], np.array([late_s]))


def smallest(rows: Sequence[tuple[str, float]]) -> tuple[str, float]:
    """Label of the most significant test, and its log p-value, their number taken into account."""
    label, log_p = min(rows, key=lambda t: t[1])
    return label, log_p + float(np.log(len(rows)))


def _without_form(state: State, label: str, log_p: float) -> Candidate:
    """An effect that shows in a test and has no form of its own."""
    return Candidate(Unmodelled(label), (), log_p, -2.0 * log_p, state.setting, state.now)
