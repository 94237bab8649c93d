"""Checks of what whole columns mean: exchanged, mislabelled, or counted from another zero."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..datasets.columns import HEADING, RUDDERS, TURN
from ..datasets.rudder_sign import ONE_SIDE, one_sided, steering_side
from ..models.instruments import SWAPS
from .base import Check, ColumnCheck, Fault, cleaned, exact, scaled
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
)

if TYPE_CHECKING:
    from ..datasets.record import Record

RATES = ("yaw_rate_rad_s", "roll_rate_rad_s")
STEERED = ("heading_rad", "rudder_rad")
UNEXPLAINED = 0.3
"""Share of the heading's changes that the yaw-rate column must leave unexplained, and a column in its place may not."""


class ChannelSwap(ColumnCheck):
    """Two columns exchanged or mislabelled: yaw rate and roll rate against the heading, heading and yaw rate, rudder
    and heading against the yaw rate, two velocities or two positions against each other."""

    id, rank = "channel_swap", 55
    separate_by = "the logger's list of channels"

    def find(self, record: Record) -> list[Fault]:
        faults: list[Fault] = []
        for look in (_rates_exchanged, _turn_exchanged, _rudder_exchanged, _track_exchanged):
            faults += look(cleaned(record, faults))
        return faults


def _exchange(record: Record, columns: tuple[str, str], evidence: str, statistic: float, switch: bool = False) -> Fault:
    """Two columns under each other's names; switch: the exchange is an instrument of a model, too."""
    instruments = {key: 1.0 for key, swap in SWAPS.items() if switch and {*swap} == {*columns}}
    return Fault(
        evidence,
        columns,
        columns={name: record.column(other) for name, other in zip(columns, reversed(columns), strict=True)},
        statistic=float(statistic),
        instruments=instruments,
    )


def _rates_exchanged(record: Record) -> list[Fault]:
    """The rate channel that goes with the heading: yaw rate, or what is called roll rate."""
    if not record.has("heading_rad", *RATES):
        return []
    own, other = (rate_error(record, name) for name in RATES)
    if not (other < BETTER * own and own > UNEXPLAINED):
        return []
    said = (
        f"the heading moves with the roll-rate column (unexplained share {other:.3f}), "
        f"not with the yaw-rate column ({own:.3f})"
    )
    return [_exchange(record, RATES, said, (own / max(other, 1e-6)) ** 2, True)]


def _turn_exchanged(record: Record) -> list[Fault]:
    """A yaw-rate column that changes as the integral of the heading column."""
    if not record.has(*TURN) or _goes_with(record) or not _goes_with(exchanged(*TURN)(record)):
        return []
    return [_exchange(record, TURN, "yaw_rate_rad_s changes as the integral of heading_rad does", BETTER**-2)]


def _goes_with(record: Record) -> bool:
    """Whether the heading goes with the yaw rate, in one unit."""
    ratio = heading_ratio(record)
    return ratio is not None and ratio.correlation > AGREE and abs(ratio.slope - 1.0) < UNEXPLAINED


def _rudder_exchanged(record: Record) -> list[Fault]:
    """A yaw rate that goes with the rudder column, not with the heading's."""
    if not record.has(*STEERED, "yaw_rate_rad_s"):
        return []
    own, other = (rate_error(r, "yaw_rate_rad_s") for r in (record, exchanged(*STEERED)(record)))
    if not (own > UNEXPLAINED > other and other < BETTER * own):
        return []
    said = (
        f"the yaw rate is that of the rudder column (unexplained share {other:.3f}), not that of the heading column "
        f"({own:.3f})"
    )
    return [_exchange(record, STEERED, said, (own / max(other, 1e-6)) ** 2)]


def _track_exchanged(record: Record) -> list[Fault]:
    """Two velocities or two positions that agree far better under each other's names."""
    better = better_reading(record)
    if better is None or better.check != ChannelSwap.id:
        return []
    first, second = better.columns
    return [_exchange(record, (first, second), better.evidence("with the columns exchanged"), better.statistic, True)]


class EarthFrameVelocity(ColumnCheck):
    """The surge and sway columns hold velocities along north and east."""

    id, rank = "earth_frame_velocity", 56
    separate_by = "the logger's list of channels"

    def find(self, record: Record) -> list[Fault]:
        return _reread(record, self.id, "when they are read as north and east", {"earth_frame_velocity": 1.0})


def _reread(record: Record, check: str, how: str, instruments: Mapping[str, float]) -> list[Fault]:
    """Columns that agree far better when they are read as a check (id) says."""
    better = better_reading(record)
    if better is None or better.check != check:
        return []
    fixed = {name: better.record.column(name) for name in better.columns}
    return [Fault(better.evidence(how), better.columns, (), True, fixed, False, None, better.statistic, instruments)]


BACKWARDS = "the compass is mounted or read backwards, both positions have the other sign, or the craft went astern"
TURNED = "the heading counts from another direction, the positions' axes are turned, or the craft moved sideways"
REVERSED = "; or time runs backwards, which a yaw rate would show"


class HeadingZero(ColumnCheck):
    """The heading counts from another direction, or is read astern: recorded = true + a, a beyond what a compass may
    err, as the positions show against heading and velocities, or, without velocities, against the heading alone."""

    id, rank = "heading_zero", 57
    separate_by = "the mounting and the zero of the compass, and whether the ship went astern"

    def find(self, record: Record) -> list[Fault]:
        return _reread(record, self.id, "with the heading turned by 180 deg", {"heading_bias": np.pi}) or (
            _off_the_course(record)
        )


def _off_the_course(record: Record) -> list[Fault]:
    """A course of the positions that stands at one angle to all headings."""
    track = course_askew(record)
    if track is None:
        return []
    offset = float(np.angle(np.exp(-1j * track.angle)))
    reading = BACKWARDS if np.pi - abs(offset) < ASKEW else TURNED
    more = REVERSED if reading == BACKWARDS and not record.has("yaw_rate_rad_s") else ""
    said = (
        f"heading_rad stands at {np.rad2deg(offset):.4g} deg to the course of the positions, which turns "
        f"{track.turn:.3g} times as far: {reading} all the time{more}"
    )
    before = 1.0 - (1.0 - track.scatter) * np.cos(track.angle)
    return [
        Fault(
            said,
            (HEADING,),
            (exact("offset", offset, "rad"),),
            columns={HEADING: record.heading_unwrapped() + track.angle},
            statistic=float(before / max(track.scatter, 1e-12)),
            instruments={"heading_bias": offset},
        )
    ]


CLEAR = 6.0
"""Standard deviations by which the rudder must act to the other side."""
TURNING = 10.0
"""What a turn all of which goes to one side counts for, in standard deviations."""


class RudderSign(Check):
    """The rudder column's sign contradicts the vessel: b in r' = a r + c r |r| + b delta + d has the other sign,
    as it is and at the lag that fits best (a late rudder looks turned, and is not); or all of a turn goes against its
    rudder."""

    id, stage, is_cause = "rudder_sign", ColumnCheck.stage, True
    separate_by = "one rudder order and the side to which the ship turns"

    def find(self, records: Sequence[Record], starboard: float) -> list[Fault]:
        """The fault of each of the records, where they show it together; else empty.

        starboard : 1 where a positive rudder is to turn the ship to starboard, -1 to port.
        """
        z = starboard * _sign(records)
        if not z < -CLEAR:
            return []
        said = (
            f"a positive rudder is to turn the ship to {'starboard' if starboard > 0.0 else 'port'}, and it turns to "
            f"the other side (z = {-z:.0f}): the sign is wrong, or port and starboard (left and right thrust) are "
            "exchanged"
        )
        rudders = [scaled(r, **{name: -1.0 for name in RUDDERS if r.has(name)}) for r in records]
        return [Fault(said, RUDDERS, (), True, own, False, None, z * z, {"rudder_reversed": 1.0}) for own in rudders]


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
