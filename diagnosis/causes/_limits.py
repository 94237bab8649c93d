"""Limits on the commands' rate and angle: what the causes share, and values that a scan tries."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..residuals.features import lagged
from .base import Cause, NotTestable

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..candidate import Variant
    from ..state import State

LIMITS = (1.5, 1.2, 1.0, 0.9985, 0.995, 0.985, 0.97, 0.9, 0.8, 0.6, 0.4, 0.2)
"""Limits that are tried first, as shares of the command's largest value: just below it a little changes much."""


class CommandLimit(Cause):
    """Base class of what the rudder cannot follow of its command."""

    where = "rudder"
    separate_by = "record the rudder angle itself beside the command"

    def variants(self, est: Estimator) -> Sequence[Variant]:
        if not est.commanded:
            raise NotTestable("the rudder column is the angle itself, which already shows its limits")
        return super().variants(est)


def rates(state: State) -> list[float]:
    """Rates (rad/s) about and below the quietened commands' largest."""
    d = state.est.segments
    seen = max(float(np.max(np.abs(np.diff(q) / np.diff(x.time)))) for q, x in zip(_quiet(state), d, strict=True))
    return [share * seen for share in LIMITS]


def angles(state: State) -> list[float]:
    """Angles (rad) about and below the quietened commands' largest."""
    seen = max(float(np.mean(np.abs(q)[np.abs(q) > 0.98 * np.abs(q).max()])) for q in _quiet(state))
    return [share * seen for share in LIMITS]


def _quiet(state: State) -> list[np.ndarray]:
    return [lagged(d.rudder, d.time, 1.5 * d.step_s) for d in state.est.segments]
