"""Cause `rudder_rate_limit`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..searches.scan import ByScan
from ._limits import rates, require_command
from .base import DEGREE, Cause, one

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..candidate import Variant


class RudderRateLimit(Cause):
    """The rudder cannot turn faster than a rate (rad/s); only where the rudder column is a command."""

    id = "rudder_rate_limit"
    where = "rudder"
    unit = "rad/s"
    search = ByScan("rudder_rate_limit", rates)
    separate_by = "record the rudder angle itself beside the command"

    def variants(self, est: Estimator) -> Sequence[Variant]:
        require_command(est)
        return [one(est, "rate", "rad/s", "rudder_rate_limit", scale=0.01 * DEGREE, low=0.0)]
