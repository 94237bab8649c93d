"""Checks of what whole columns mean: exchanged, mislabelled, or counted from another zero."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..datasets.columns import HEADING, RUDDERS, TURN, VELOCITIES
from ..datasets.geometry import velocity_over_ground
from ..datasets.yaw_response import FEWEST, steering_side
from .base import Check, ColumnCheck, Fault, cleaned, exact, scaled, without
from .integrity.readings import (
    AGREE,
    AGREE_AS_RUDDER,
    ASKEW,
    BETTER,
    LEAST,
    course_askew,
    course_ratio,
    early_heading,
    exchanged,
    has_lag,
    heading_lag,
    heading_ratio,
    rate_error,
    reread,
    swap_of,
)

if TYPE_CHECKING:
    from ..datasets.record import Record

RATES = ("yaw_rate_rad_s", "roll_rate_rad_s")
STEERED = ("heading_rad", "rudder_rad")
WIND = ("wind_speed_m_s", "wind_direction_rad")
TURNS_FAR, UNSTEADY = 0.5, 1.0
"""Range of headings, rad, from which a wind told from the bow differs from a true one; and deviation of a wind from its
mean, as a share, from which it has none."""
UNEXPLAINED = 0.3
"""Share of the heading's changes that the yaw-rate column must leave unexplained, and a column in its place may not."""
OTHER = 3.0
"""Factor between the changes of the heading and those that a rate gives from which it is another quantity, where they
do not go together: a late or biased yaw rate gives less of them, by its correlation."""


class ChannelSwap(ColumnCheck):
    """Two columns exchanged or mislabelled: yaw rate and roll rate against the heading, heading and yaw rate, rudder
    and heading against the yaw rate, two velocities or two positions against each other; a yaw rate that is none, as
    the heading shows which the track confirms; a course in the place of the heading; or a wind told from the bow."""

    id, rank = "channel_swap", 55
    separate_by = "the logger's list of channels"

    def find(self, record: Record) -> list[Fault]:
        faults: list[Fault] = []
        for look in (_rates_exchanged, _turn_exchanged, _rudder_exchanged, _no_yaw_rate):
            faults += look(cleaned(record, faults))
        faults += reread(cleaned(record, faults), self.id)
        return faults + _wind_from_the_bow(cleaned(record, faults))


def _exchange(record: Record, columns: tuple[str, str], evidence: str, statistic: float, switch: bool = False) -> Fault:
    """Two columns under each other's names; switch: the exchange is an instrument of a model, too."""
    fixed = exchanged(*columns)(record)
    instruments = {swap_of(columns): 1.0} if switch else {}
    values = {name: fixed.column(name) for name in columns}
    return Fault(evidence, columns, columns=values, statistic=float(statistic), instruments=instruments)


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


def _no_yaw_rate(record: Record) -> list[Fault]:
    """A yaw-rate column that goes with the heading neither in size nor in time, where the course of the positions goes
    with the heading."""
    turned = heading_ratio(record, steady=False)
    if turned is None or abs(turned.correlation) > AGREE_AS_RUDDER or 1.0 / OTHER < abs(turned.slope) < OTHER:
        return []
    course = course_ratio(record)
    if course is None or not course.correlation > AGREE_AS_RUDDER:
        return []
    said = (
        f"yaw_rate_rad_s is another quantity, and is left out: its changes are {abs(1.0 / turned.slope):.2g} of those "
        f"of heading_rad (correlation {turned.correlation:.2g}), with which the course of the positions goes "
        f"({course.correlation:.2g})"
    )
    return [Fault(said, TURN[1:], columns=without(record, TURN[1], True), statistic=LEAST**-2)]


def _wind_from_the_bow(record: Record) -> list[Fault]:
    """A wind whose direction is relative to the bow, true or apparent: with the heading added, and for an apparent one
    the ship's velocity taken off, it is far steadier than the column says, while the ship turns."""
    if not record.has(*WIND, HEADING):
        return []
    speed, direction, heading = *map(record.column, WIND), record.heading_unwrapped()
    known = np.isfinite(speed) & np.isfinite(direction) & np.isfinite(heading)
    if known.sum() < FEWEST or np.ptp(heading[known]) < TURNS_FAR:
        return []
    from_bow = speed * np.exp(1j * (direction + heading))
    readings = {"the direction counts from the bow": from_bow}
    if record.has(*VELOCITIES):
        readings["the wind is apparent, from the bow"] = from_bow - velocity_over_ground(record)
    present, errors = _unsteady(speed * np.exp(1j * direction)), {how: _unsteady(x) for how, x in readings.items()}
    how = min(errors, key=lambda one: errors[one])
    if not errors[how] < BETTER * min(present, UNSTEADY):
        return []
    wind = readings[how]
    said = (
        f"the recorded wind varies by {100.0 * present:.0f} % of its speed; by {100.0 * errors[how]:.0f} % where {how}"
    )
    columns = {WIND[0]: np.abs(wind), WIND[1]: np.angle(wind)}
    return [Fault(said, WIND, columns=columns, statistic=float((present / max(errors[how], 1e-3)) ** 2))]


def _unsteady(wind: np.ndarray) -> float:
    """Root mean square deviation of a wind (N,) north + i east from its mean, as a share of its root mean square."""
    known = wind[np.isfinite(wind)]
    return float(np.std(known) / max(np.sqrt(np.mean(np.abs(known) ** 2)), 1e-12))


class EarthFrameVelocity(ColumnCheck):
    """The surge and sway columns hold velocities along north and east."""

    id, rank = "earth_frame_velocity", 56
    separate_by = "the logger's list of channels"

    def find(self, record: Record) -> list[Fault]:
        return reread(record, self.id)


BACKWARDS = "the compass is mounted or read backwards, both positions have the other sign, or the craft went astern"
TURNED = "the heading counts from another direction, the positions' axes are turned, or the craft moved sideways"
REVERSED = "; or time runs backwards, which a yaw rate would show"


class HeadingZero(ColumnCheck):
    """The heading counts from another direction, or is read astern: recorded = true + a, a beyond what a compass may
    err, as the positions show against heading and velocities, or, without velocities, against the heading alone."""

    id, rank = "heading_zero", 57
    separate_by = "the mounting and the zero of the compass, and whether the ship went astern"

    def find(self, record: Record) -> list[Fault]:
        return reread(record, self.id) or _off_the_course(record)


class HeadingLag(ColumnCheck):
    """A heading that its instrument smooths: it follows the true one with a lag of tau s, as a damped compass does."""

    id, rank, unit = "heading_lag", 58, "s"
    separate_by = "the damping that the compass is set to, or a gyro compass beside it"

    def find(self, record: Record) -> list[Fault]:
        if not record.has(*TURN):
            return []
        lag_s = heading_lag(record)
        if not has_lag(record, lag_s):
            return []
        early = early_heading(record, lag_s)
        before, after = (100.0 * rate_error(one, TURN[1]) for one in (record, record.with_channels(heading_rad=early)))
        said = (
            f"heading_rad lags behind the yaw rate by {lag_s:.3g} s: {before:.0f} % of its changes disagree with the "
            f"rate as it is, {after:.0f} % without the lag"
        )
        return [Fault(said, (HEADING,), (exact("tau", lag_s, "s"),), columns={HEADING: early})]


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


def to_other_side(record: Record) -> dict[str, np.ndarray]:
    """The rudder columns of a record with the other sign."""
    return scaled(record, **{name: -1.0 for name in RUDDERS if record.has(name)})


class RudderSign(Check):
    """The rudder column's sign contradicts the side to which the record says that it turns the ship: the response of
    the yaw rate to it (`datasets.yaw_response`) has the other sign; or all of a turn goes against its rudder."""

    id, stage, is_cause = "rudder_sign", ColumnCheck.stage, True
    separate_by = "one rudder order and the side to which the ship turns"

    def find(self, records: Sequence[Record]) -> dict[str, Fault]:
        """Name of a record -> its fault, of records that say the same side: those that contradict it, and where none
        confirms it also those in which nothing tells."""
        told = {r.name: steering_side(r) for r in records}
        sides = {r.name: r.meta.positive_rudder for r in records}
        wrong = {name: one for name, one in told.items() if one is not None and one[0] != sides[name]}
        if not wrong:
            return {}
        confirmed = any(one is not None for name, one in told.items() if name not in wrong)
        share = min(share for _, share in wrong.values())
        said = (
            f"a positive rudder is to turn the ship to {sides[records[0].name]}, and it turns to the other side "
            f"({100.0 * share:.0f} % of the yaw rate follow it there): the sign is wrong, or port and starboard (left "
            "and right thrust) are exchanged"
        )
        clear = FEWEST * share / max(1.0 - share, LEAST)
        return {
            r.name: Fault(
                said,
                RUDDERS,
                columns=to_other_side(r),
                statistic=clear,
                instruments={"rudder_reversed": 1.0},
            )
            for r in records
            if r.name in wrong or not confirmed
        }
