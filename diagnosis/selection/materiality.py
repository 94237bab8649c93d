"""Causes that the records show, but whose size is below what matters."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..state import Unmodelled
from .forward import without

if TYPE_CHECKING:
    from ..causes.base import Cause
    from ..state import Candidate, State


def material(state: State) -> tuple[State, frozenset[Cause]]:
    """The state without causes whose sizes are below their floors, and these causes."""
    small: set[Cause] = set()
    while True:
        found = next(((a, cause) for a in state.accepted if (cause := _immaterial(state, a)) is not None), None)
        if found is None:
            return state, frozenset(small)
        accepted, cause = found
        small.add(cause)
        state = without(state, accepted)


def _immaterial(state: State, a: Candidate) -> Cause | None:
    """The cause, where its sizes are below their floors."""
    if isinstance(a.cause, Unmodelled):
        return None
    values = np.array([state.est.value(state.setting, p) for p in a.variant])
    return None if a.cause.matters(state.est, a.variant, values) else a.cause
