"""Cause `heading_offset`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..kinematics.series import TrackEffect, half_a_degree
from ..searches.score import ByScore
from .base import DEGREE, Cause, one, require_channels

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..state import Variant


class HeadingOffset(Cause):
    """Misread heading: recorded = true + b, b in rad; the track shows it."""

    id = "heading_offset"
    where = "sensor"
    unit = "rad"
    search = ByScore()
    smallest = 0.1 * DEGREE
    largest = 17.0 * DEGREE
    power_size = 0.1 * DEGREE
    separate_by = "positions on two opposite straight courses"
    track = (TrackEffect("b", "rad", ("heading_bias",), lambda path: path.turned_way, half_a_degree),)
    track_rivals = ("axis_misalignment",)

    def variants(self, est: Estimator) -> Sequence[Variant]:
        require_channels(est, "psi", "x", "y")
        return [one(est, "b", "rad", "heading_bias", scale=0.05 * DEGREE)]
