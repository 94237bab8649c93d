"""Checks of what whole columns mean: exchanged, mislabelled, or counted from another zero."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..datasets.columns import RUDDERS, TURN, VELOCITIES
from ..datasets.rudder_sign import ONE_SIDE, one_sided, steering_side
from ..models.instruments import SENSORS, SWAPS
from .base import ColumnCheck, ColumnFault, exact
from .files.rudder_response import response
from .integrity.readings import (
    AGREE,
    ASKEW,
    BETTER,
    better_reading,
    course_askew,
    exchanged,
    heading_ratio,
    rate_error,
    read_as,
)

if TYPE_CHECKING:
    from ..datasets.axes import Track
    from ..datasets.record import Record

RATES = ("yaw_rate_rad_s", "roll_rate_rad_s")
STEERED = ("heading_rad", "rudder_rad")
UNEXPLAINED = 0.3
"""Share of the heading's changes that the yaw-rate column must leave unexplained, and a column in its place may not."""


class ChannelSwap(ColumnCheck):
    """Two columns exchanged or mislabelled (`details` names them): yaw rate and roll rate against the heading, heading
    and yaw rate, rudder and heading against the yaw rate, two velocities or two positions against each other."""

    id, rank = "channel_swap", 55
    separate_by = "the logger's list of channels"

    def find(self, records: Sequence[Record], starboard: float) -> tuple[list[ColumnFault], list[Record]]:
        faults, fixed = self._of_rates(list(records))
        for look in (self._of_turn, self._of_rudder):
            more, fixed = look(fixed)
            faults += more
        better = better_reading(fixed)
        if better is not None and better.reading.check == self.id:
            said = better.evidence("with the columns exchanged")
            faults.append(self._fault(better.reading.columns, said, better.statistic))
            fixed = read_as(fixed, better.reading)
        return faults, fixed

    def _of_rates(self, records: list[Record]) -> tuple[list[ColumnFault], list[Record]]:
        """The rate channel that goes with the heading: yaw rate, or what is called roll rate."""
        if not all(r.has("heading_rad", *RATES) for r in records):
            return [], records
        own, other = (float(np.mean([rate_error(r, name) for r in records])) for name in RATES)
        if not (other < BETTER * own and own > UNEXPLAINED):
            return [], records
        said = (
            f"the heading moves with the roll-rate column (unexplained share {other:.3f}), "
            f"not with the yaw-rate column ({own:.3f})"
        )
        swap = exchanged(*RATES)
        return [self._fault(RATES, said, (own / max(other, 1e-6)) ** 2)], [swap(r) for r in records]

    def _of_turn(self, records: list[Record]) -> tuple[list[ColumnFault], list[Record]]:
        """Records whose yaw-rate column changes as the integral of the heading column."""
        swap = exchanged(*TURN)
        bad = [r.has(*TURN) and _goes_with(swap(r)) and not _goes_with(r) for r in records]
        if not any(bad):
            return [], records
        said = f"in {sum(bad)} of {len(bad)} records yaw_rate_rad_s changes as the integral of heading_rad does"
        fault = ColumnFault(self, {"channels": list(TURN)}, said, BETTER**-2, {})
        return [fault], [swap(r) if is_bad else r for r, is_bad in zip(records, bad, strict=True)]

    def _of_rudder(self, records: list[Record]) -> tuple[list[ColumnFault], list[Record]]:
        """Records whose yaw rate goes with the rudder column, not with the heading's.

        The rudder is an input, so that the exchange is none of a model's instruments: it is corrected in the records.
        """
        swap = exchanged(*STEERED)
        errors = [_with_rudder(r) for r in records]
        bad = [own > UNEXPLAINED > other and other < BETTER * own for own, other in errors]
        if not any(bad):
            return [], records
        own, other = np.mean([pair for pair, is_bad in zip(errors, bad, strict=True) if is_bad], axis=0)
        said = (
            f"in {sum(bad)} of {len(bad)} records the yaw rate is that of the rudder column (unexplained share "
            f"{other:.3f}), not that of the heading column ({own:.3f})"
        )
        fault = ColumnFault(self, {"channels": list(STEERED)}, said, float((own / max(other, 1e-6)) ** 2), {})
        return [fault], [swap(r) if is_bad else r for r, is_bad in zip(records, bad, strict=True)]

    def _fault(self, columns: Sequence[str], evidence: str, statistic: float) -> ColumnFault:
        names = {column: name for name, (column, _) in SENSORS.items()}
        pair = {names[column] for column in columns}
        switch = next(key for key, swap in SWAPS.items() if {names[c] for c in swap} == pair)
        return ColumnFault(self, {"channels": list(columns)}, evidence, float(statistic), {switch: 1.0})


def _goes_with(record: Record) -> bool:
    """Whether the heading goes with the yaw rate, in one unit."""
    ratio = heading_ratio(record)
    return ratio is not None and ratio.correlation > AGREE and abs(ratio.slope - 1.0) < UNEXPLAINED


def _with_rudder(record: Record) -> tuple[float, float]:
    """Shares of the heading column's and of the rudder column's changes that the yaw rate leaves unexplained; nan where
    a column is missing."""
    if not record.has(*STEERED, "yaw_rate_rad_s"):
        return float("nan"), float("nan")
    return rate_error(record, "yaw_rate_rad_s"), rate_error(exchanged(*STEERED)(record), "yaw_rate_rad_s")


class EarthFrameVelocity(ColumnCheck):
    """The surge and sway columns hold velocities along north and east."""

    id, rank = "earth_frame_velocity", 56
    columns = VELOCITIES
    separate_by = "the logger's list of channels"

    def find(self, records: Sequence[Record], starboard: float) -> tuple[list[ColumnFault], list[Record]]:
        better = better_reading(records)
        if better is None or better.reading.check != self.id:
            return [], list(records)
        said = better.evidence("when they are read as north and east")
        fault = ColumnFault(self, {}, said, better.statistic, {"earth_frame_velocity": 1.0})
        return [fault], read_as(records, better.reading)


BACKWARDS = "the compass is mounted or read backwards, both positions have the other sign, or the craft went astern"
TURNED = "the heading counts from another direction, the positions' axes are turned, or the craft moved sideways"
REVERSED = "; or time runs backwards, which a yaw rate would show"


class HeadingZero(ColumnCheck):
    """The heading counts from another direction, or is read astern: recorded = true + a, a beyond what a compass may
    err, as the positions show against heading and velocities, or, without velocities, against the heading alone."""

    id, rank = "heading_zero", 57
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


CLEAR = 6.0
"""Standard deviations by which the rudder must act to the other side."""
TURNING = 10.0
"""What a turn all of which goes to one side counts for, in standard deviations."""


class RudderSign(ColumnCheck):
    """The rudder column's sign contradicts the vessel: b in r' = a r + c r |r| + b delta + d has the other sign,
    as it is and at the lag that fits best (a late rudder looks turned, and is not); or all of a turn goes against its
    rudder."""

    id, rank = "rudder_sign", 58
    joint = True
    columns = RUDDERS
    separate_by = "one rudder order and the side to which the ship turns"

    def find(self, records: Sequence[Record], starboard: float) -> tuple[list[ColumnFault], list[Record]]:
        z = starboard * _sign(records)
        if not z < -CLEAR:
            return [], list(records)
        said = (
            f"a rudder angle the record calls positive turns the ship to the other side than the model's ({-z:.0f} sd)"
        )
        return [ColumnFault(self, {}, said, z * z, {"rudder_reversed": 1.0})], [_turned(r) for r in records]


def _sign(records: Sequence[Record]) -> float:
    """Standard deviations by which a positive rudder turns the ship to starboard; in turns alone the share of the yaw
    rate that goes to one side, counted as so many; 0 where nothing tells it."""
    swung = [r for r in records if not _held(r)]
    if not swung:
        sides = [side for r in records if (side := steering_side(r)) is not None]
        same = len({side for side, _ in sides}) == 1
        return TURNING * min(sure for _, sure in sides) * (1.0 if sides[0][0] == "starboard" else -1.0) if same else 0.0
    answer = response(swung)
    return answer.z if answer is not None and answer.z * answer.z_best > 0.0 else 0.0


def _held(record: Record) -> bool:
    """Whether the rudder is held to one side: then the yaw acceleration says little of it."""
    rudder = record.rudder()
    return abs(one_sided(rudder[np.isfinite(rudder)])) > ONE_SIDE


def _turned(record: Record) -> Record:
    return record.with_channels(**{n: -record.column(n) for n in RUDDERS if record.has(n)})
