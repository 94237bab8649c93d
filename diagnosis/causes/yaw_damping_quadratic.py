"""Cause `yaw_damping_quadratic`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..searches.score import ByScore
from ._response import yaw_weight
from .base import Cause, require_entry, term

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..candidate import Variant


class YawDampingQuadratic(Cause):
    """Yaw moment N r|r| (bilge keels, skeg separation), in the vessel's own prime system; for a response model
    alpha r|r| beside r, in s/rad."""

    id = "yaw_damping_quadratic"
    where = "hull"
    unit = "1 (prime) or s/rad"
    search = ByScore()
    extension = "yaw_damping_quadratic"
    separate_by = "turning circles at several rudder angles, to both sides"

    def variants(self, est: Estimator) -> Sequence[Variant]:
        require_entry(est, "added_Nr_absr")
        return [(term(est, "Nrr", "1", "added_Nr_absr", yaw_weight(est)),)]
