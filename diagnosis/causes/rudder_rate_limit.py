"""Cause `rudder_rate_limit`."""

from __future__ import annotations

from ..searches.scan import ByScan
from ._limits import CommandLimit, rates
from .base import DEGREE, Number


class RudderRateLimit(CommandLimit):
    """The rudder cannot turn faster than a rate (rad/s); only where the rudder column is a command."""

    id = "rudder_rate_limit"
    unit = "rad/s"
    search = ByScan("rudder_rate_limit", rates)
    number = Number("rate", ("rudder_rate_limit",), scale=0.01 * DEGREE, low=0.0)
