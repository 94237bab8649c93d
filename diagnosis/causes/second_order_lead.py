"""Cause `second_order_lead`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...estimation.filters.innovations.settings import Parameter
from ..searches.profile import ByProfile
from .base import Cause, NotTestable

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..candidate import Variant


class SecondOrderLead(Cause):
    """Second time constant T2 and lead T3 that a first-order Nomoto model lacks: rudder through
    (1 + T3 s)/(1 + T2 s), T3 = T2 (1 - lead)."""

    id = "second_order_lead"
    where = "hull"
    unit = "s"
    search = ByProfile((0.5, 1.5, 5.0, 15.0, 45.0))
    extension = "second_order_lead"
    separate_by = "rudder steps with the yaw rate sampled fast"

    def stands_beside_numbers(self, is_3dof: bool) -> bool:
        return False

    def variants(self, est: Estimator) -> Sequence[Variant]:
        if "lead" not in est.index:
            raise NotTestable("only for first-order response models: others have it")
        lead = Parameter("lead", "1", ((est.index["lead"], 1.0),), scale=0.02, low=-20.0, high=5.0)
        base = float(est.base[est.index["lead_T2"]])
        shortest = est.segments[0].step_s - base  # what is faster than the sampling is not seen
        slots = ((est.index["lead_T2"], 1.0),)
        return [(lead, Parameter("T2", "s", slots, scale=0.2, low=shortest, high=200.0, origin=base))]
