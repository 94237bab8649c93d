"""Causes that the records show, but whose size is below what matters."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..candidate import Unmodelled
from ..residuals.criterion import without

if TYPE_CHECKING:
    from ..candidate import Candidate
    from ..causes.base import Cause
    from ..state import State


def material(state: State) -> tuple[State, frozenset[Cause]]:
    """The state without causes whose sizes are below their floors, and these causes."""
    small: set[Cause] = set()
    while True:
        found = next((a for a in state.accepted if not _matters(state, a)), None)
        if found is None:
            return state, frozenset(small)
        if not isinstance(found.cause, Unmodelled):
            small.add(found.cause)
        state = without(state, found)


def _matters(state: State, a: Candidate) -> bool:
    if isinstance(a.cause, Unmodelled):
        return True
    values = np.array([state.est.value(state.setting, p) for p in a.variant])
    return a.cause.matters(state.est, a.variant, values)
