"""Cause `yaw_damping_cubic`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..searches.score import ByScore
from ._response import yaw_weight
from .base import Cause, require_entry, term

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..candidate import Variant


class YawDampingCubic(Cause):
    """Yaw moment N r^3, in the vessel's own prime system; for a response model alpha r^3 beside r, in s2/rad2."""

    id = "yaw_damping_cubic"
    where = "hull"
    unit = "1 (prime) or s2/rad2"
    search = ByScore()
    extension = "yaw_damping_cubic"
    separate_by = "turning circles at several rudder angles, to both sides"

    def variants(self, est: Estimator) -> Sequence[Variant]:
        require_entry(est, "added_Nrrr")
        return [(term(est, "Nrrr", "1", "added_Nrrr", yaw_weight(est)),)]
