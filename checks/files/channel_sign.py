"""Check `channel_sign`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...datasets.axes import track_of
from ..base import FileCheck
from ..fault import Fault, cleaned, exact
from ..integrity.averages import averages_of
from ..integrity.ratios import AGREE, heading_ratio, turns_back
from ..integrity.readings import BETTER, LEAST, TRACK, better_reading, course_askew, track_error

if TYPE_CHECKING:
    from ...datasets.record import Record


class ChannelSign(FileCheck):
    """A column with the other sign: yaw rate against heading, sway or east against the track, the track's turns against
    the heading's."""

    id = "channel_sign"
    rank = 50
    ends = True
    separate_by = "the logger's list of channels and its axes"

    def find(self, record: Record) -> list[Fault]:
        rate = self._of_rate(record)
        if rate is not None:
            record = cleaned(record, [rate])
            better = better_reading([record])
            backwards = better.reading.check == "heading_zero" if better else course_askew(record) is not None
            if rate.channels == ("yaw_rate_rad_s",) and backwards:
                said = "the yaw rate turns against the heading, and the ship goes astern: time runs backwards"
                return [Fault(said, ("time_s",), rate.sizes, standing=True)]
        track = self._of_track(record)
        unread = better_reading([record]) is None  # which another check names
        if track is None and unread and not (rate and rate.standing):
            track = self._of_course(record)
        return [f for f in (rate, track) if f]

    def _of_rate(self, record: Record) -> Fault | None:
        ratio = heading_ratio(record)
        if ratio is None or ratio.correlation > -AGREE or not turns_back(ratio.slope):
            return None
        said = f"yaw_rate_rad_s turns against the heading (correlation {ratio.correlation:.3f})"
        size, track = (exact("ratio", ratio.slope, "1"),), track_of(averages_of(record))
        if track is None:
            said += "; without positions nothing tells which of the two is wrong"
            return Fault(said, ("heading_rad", "yaw_rate_rad_s"), size, standing=True)
        wrong = "heading_rad" if track.mirrored else "yaw_rate_rad_s"
        said += f"; the track turns with {'the yaw rate' if track.mirrored else 'the heading'}"
        return Fault(said, (wrong,), size, factors={wrong: -1.0})

    def _of_track(self, record: Record) -> Fault | None:
        if not record.has(*TRACK):
            return None
        short = averages_of(record)
        present = track_error(short)
        errors = {name: track_error(short.with_channels(**{name: -short.column(name)})) for name in TRACK[1:]}
        best = min(errors, key=lambda name: errors[name])
        if not errors[best] < BETTER * present > BETTER * LEAST:
            return None
        better = better_reading([record])
        if better is not None and better.own < errors[best]:  # which another check names
            return None
        said = (
            f"the track disagrees with the velocities by {present:.3f} of the way made, by {errors[best]:.3f} with "
            f"{best} reversed"
        )
        return Fault(said, (best,), (exact("disagreement", present, "1"),), factors={best: -1.0})

    def _of_course(self, record: Record) -> Fault | None:
        """Positions alone, without velocities or together with them: their track turns to the other side."""
        found = track_of(averages_of(record))
        if found is None or not found.mirrored:
            return None
        said = f"the track turns against the heading, as if {found.reading}; or the heading counts anticlockwise"
        return Fault(said, ("north_m", "east_m"), standing=True)
