"""Cause `rudder_saturation`."""

from __future__ import annotations

from ..searches.scan import ByScan
from ._limits import CommandLimit, angles
from .base import DEGREE, Number


class RudderSaturation(CommandLimit):
    """The rudder stops at an angle (rad) short of the command; only where the rudder column is a command."""

    id = "rudder_saturation"
    unit = "rad"
    search = ByScan("rudder_saturation", angles)
    number = Number("limit", ("rudder_saturation",), scale=0.05 * DEGREE, low=0.0)
