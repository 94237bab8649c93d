"""Cause `rudder_saturation`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..searches.scan import ByScan
from ._limits import angles, require_command
from .base import DEGREE, Cause, one

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..candidate import Variant


class RudderSaturation(Cause):
    """The rudder stops at an angle (rad) short of the command; only where the rudder column is a command."""

    id = "rudder_saturation"
    where = "rudder"
    unit = "rad"
    search = ByScan("rudder_saturation", angles)
    separate_by = "record the rudder angle itself beside the command"

    def variants(self, est: Estimator) -> Sequence[Variant]:
        require_command(est)
        return [one(est, "limit", "rad", "rudder_saturation", scale=0.05 * DEGREE, low=0.0)]
