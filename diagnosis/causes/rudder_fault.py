"""Cause `rudder_fault`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...estimation.filters.innovations.settings import Parameter
from ..searches.base import refitted
from ..searches.change_point import ByChangePoint, longest
from .base import Cause
from .rudder_effectiveness import RudderEffectiveness

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..candidate import Candidate, Variant
    from ..state import State


class RudderFault(Cause):
    """Sudden loss (or gain) of rudder force: effectiveness 1 + e from time t0 (s) of the record on."""

    id = "rudder_fault"
    where = "rudder"
    unit = "1, s"
    search = ByChangePoint()
    smallest = 0.02
    power_size = 0.1
    separate_by = "a rudder-force check before and after"

    def variants(self, est: Estimator) -> Sequence[Variant]:
        e = Parameter("e", "1", ((est.index["rudder_fault"], 1.0),), low=-1.0, high=1.0, scale=0.02)
        slots = ((est.index["rudder_fault_time"], 1.0),)
        return [(e, Parameter("t0", "s", slots, low=0.0, high=longest(est), scale=1.0))]

    def simpler(self, state: State, found: Candidate, before: float, rng: np.random.Generator) -> Candidate | None:
        """The rudder's effectiveness, where the fault has come to act before the rudder moves."""
        steady = RudderEffectiveness()
        est, (e, t0) = state.est, found.variant
        firsts = [d for i, d in enumerate(est.segments) if i == 0 or d.record != est.segments[i - 1].record]
        moved = [d.time[np.argmax(np.abs(d.rudder - d.rudder[0]) > 0.5 * np.ptp(d.rudder))] for d in firsts]
        untried = steady in state.bank and steady not in state.causes
        if not untried or e.record is not None or est.value(found.setting, t0) > min(moved):
            return None
        (variant,) = state.bank[steady]
        s = replace(state.setting, noise=found.setting.noise)
        s = est.at(s, variant[0], est.value(found.setting, e))
        return refitted(steady, state, variant, s, 1, 1.0, before)
