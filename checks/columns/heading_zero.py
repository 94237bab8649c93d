"""Check `heading_zero`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..fault import exact
from ..integrity.readings import ASKEW, better_reading, course_askew, read_as
from ._base import ColumnCheck, ColumnFault

if TYPE_CHECKING:
    from ...datasets.axes import Track
    from ...datasets.record import Record

BACKWARDS = "the compass is mounted or read backwards, both positions have the other sign, or the craft went astern"
TURNED = "the heading counts from another direction, the positions' axes are turned, or the craft moved sideways"
REVERSED = "; or time runs backwards, which a yaw rate would show"


class HeadingZero(ColumnCheck):
    """The heading counts from another direction, or is read astern: recorded = true + a, a beyond what a compass may
    err, as the positions show against heading and velocities, or, without velocities, against the heading alone."""

    id = "heading_zero"
    rank = 57
    columns = ("heading_rad",)
    separate_by = "the mounting and the zero of the compass, and whether the ship went astern"

    def find(self, records: Sequence[Record], starboard: float) -> tuple[list[ColumnFault], list[Record]]:
        better = better_reading(records)
        if better is not None and better.reading.check == self.id:
            said = better.evidence("with the heading turned by 180 deg")
            fault = ColumnFault(self, {}, said, better.statistic, {"heading_bias": float(np.pi)})
            return [fault], read_as(records, better.reading)
        tracks = [course_askew(r) for r in records]
        faults = [self._of_course(r, track) for r, track in zip(records, tracks, strict=True) if track is not None]
        return faults[:1], [_about_course(r, track) for r, track in zip(records, tracks, strict=True)]

    def _of_course(self, record: Record, track: Track) -> ColumnFault:
        """A course of the positions that stands at one angle to all headings."""
        offset = float(np.angle(np.exp(-1j * track.angle)))
        reading = BACKWARDS if np.pi - abs(offset) < ASKEW else TURNED
        more = REVERSED if reading == BACKWARDS and not record.has("yaw_rate_rad_s") else ""
        said = (
            f"heading_rad stands at {np.rad2deg(offset):.4g} deg to the course of the positions, which turns "
            f"{track.turn:.3g} times as far: {reading} all the time{more}"
        )
        before = 1.0 - (1.0 - track.scatter) * np.cos(track.angle)
        statistic = float(before / max(track.scatter, 1e-12))
        return ColumnFault(self, {}, said, statistic, {"heading_bias": offset}, (exact("offset", offset, "rad"),))


def _about_course(record: Record, track: Track | None) -> Record:
    """The record with its heading turned to the mean of its course."""
    return record if track is None else record.with_channels(heading_rad=record.heading_unwrapped() + track.angle)
