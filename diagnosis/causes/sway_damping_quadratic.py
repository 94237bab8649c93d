"""Cause `sway_damping_quadratic`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..searches.score import ByScore
from .base import Cause, require_3dof, require_entry, term

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..candidate import Variant


class SwayDampingQuadratic(Cause):
    """Cross-flow drag Y v|v|, in the vessel's own prime system."""

    id = "sway_damping_quadratic"
    where = "hull"
    unit = "1"
    search = ByScore()
    extension = "sway_damping_quadratic"
    separate_by = "hard turns with sway measured, or an oblique towing test"

    def variants(self, est: Estimator) -> Sequence[Variant]:
        require_3dof(est)
        require_entry(est, "added_Yv_absv")
        return [(term(est, "Yvv", "1", "added_Yv_absv"),)]
