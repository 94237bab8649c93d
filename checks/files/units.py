"""Checks of the scale of a record's columns: units, signs, and a scale that goes with the side."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...datasets.axes import track_of
from ...datasets.columns import POSITIONS, RUDDERS, TRACK, TURN, TWIN, VELOCITIES
from ...datasets.instruments import REVOLUTIONS
from ...datasets.plausibility import straight_speed
from ...datasets.signals import sensor_sd
from ...datasets.yaw_response import steering_side
from ...models.linear_algebra import lstsq
from ..base import Fault, FileCheck, cleaned, exact, scaled, without
from ..integrity.averages import SMALL_TURN, averages_of, wraps_at_small_turn
from ..integrity.readings import (
    AGREE,
    AGREE_AS_RUDDER,
    ANGLES,
    NEAR_IN_CURRENT,
    PLACES,
    SPEEDS,
    Ratio,
    better_reading,
    course_askew,
    course_ratio,
    heading_ratio,
    known_together,
    over_windows,
    reread,
    speed_ratio,
    speed_ratio_in_current,
    track_error,
    turns_back,
    unit_of,
)

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from ...datasets.record import Record

DEGREE = np.pi / 180.0
TURNS_OF = {2.0 * np.pi: "rad/s", 60.0: "revolutions in a minute", 360.0: "deg/s"}
"""Factor on revolutions in a second -> their unit."""
ALIKE = 1.3
"""Factor by which revolutions for the speed may differ between records of one ship, and the ratio of ways beside a
current from that without."""
TOGETHER = 0.7
"""Correlation of course and heading from which their ratio is believed."""
ALL_ANGLES = 20.0
"""Times that the course turns as far as the heading, from which no drift explains it."""
LARGEST_RUDDER = 1.6
"""Rudder angle (rad) above which the column must hold degrees."""
FAR = 1.3
"""Factor from which a time that all channels show is wrong."""
ODD_TURN, ODD_WAY = 1.6, 5.0
"""Factors from which no scale error of a rate gyro, or of a log, explains a ratio."""
ONE_FACTOR = 0.1
"""Share by which two ratios of one time may differ."""


class WrongUnit(FileCheck):
    """A column in another unit than its name says: degrees for radians, knots for metres per second, feet for metres,
    or a time that runs faster or slower than rates and velocities show."""

    id, rank = "wrong_unit", 40
    ends = of_logger = True
    separate_by = "the logger's list of channels"

    def find(self, record: Record) -> list[Fault]:
        turn, way = heading_ratio(record), speed_ratio(record)
        time = self._time(turn, way)
        if time is not None:
            return [time]
        angles = self._angle(record, turn) or self._all_angles(record, turn)
        return [f for f in (angles, self._speed(record, way), *self._rudders(record)) if f]

    def _time(self, turn: Ratio | None, way: float | None) -> Fault | None:
        """Heading against yaw rate and positions against velocities differ by one factor, which is that of the time."""
        if turn is None or way is None or not (turn.slope > 0.0 and turn.correlation > AGREE):
            return None
        if abs(turn.slope * way - 1.0) > ONE_FACTOR or 1.0 / FAR < way < FAR:
            return None
        said = (
            f"time_s runs {way:.4g} times as fast as both heading and yaw rate, and positions and velocities, show: "
            "another unit, or another sampling rate"
        )
        return Fault(said, ("time_s",), (exact("ratio", way, "1"),), standing=True)

    def _angle(self, record: Record, ratio: Ratio | None) -> Fault | None:
        if ratio is None or abs(ratio.correlation) < AGREE:
            return None
        if unit_of(ratio.slope, ANGLES) is None:
            said = f"heading_rad changes {ratio.slope:.4g} times as much as yaw_rate_rad_s and the time give"
            return _odd(said, ratio.slope, ODD_TURN, TURN)
        name, other = TURN if abs(ratio.slope) > 1.0 else TURN[::-1]
        times = max(abs(ratio.slope), 1.0 / abs(ratio.slope))
        said = f"{name} holds degrees: its changes are {times:.4g} times what {other} gives"
        return Fault(said, (name,), (exact("ratio", ratio.slope, "1"),), columns=scaled(record, **{name: DEGREE}))

    def _all_angles(self, record: Record, turn: Ratio | None) -> Fault | None:
        """Heading and yaw rate together in another unit, which the track shows, or the heading's own wraps."""
        if not record.has("heading_rad"):
            return None
        better, ratio = better_reading(record), course_ratio(record)
        if better is not None and better.reading.check == self.id:
            said = better.evidence
        elif ratio is not None and abs(ratio.correlation) > TOGETHER and 1.0 < abs(ratio.slope) / ALL_ANGLES < 5.0:
            said = f"the course of the positions turns {abs(ratio.slope):.3g} times as far as heading_rad: another unit"
        elif _wraps(record, turn):
            said = f"heading_rad wraps at {SMALL_TURN:.4g} rad: it holds radians that were taken for degrees"
        else:
            return None
        return Fault(said, TURN, standing=True)

    def _speed(self, record: Record, ratio: float | None) -> Fault | None:
        if ratio is None:
            return None
        names, units, unit = VELOCITIES, SPEEDS, unit_of(ratio, SPEEDS)
        if unit is None:
            names, units, unit = POSITIONS, PLACES, unit_of(1.0 / ratio, PLACES)
        in_current = speed_ratio_in_current(record) if unit is None else None
        if in_current is not None and 1.0 / ALIKE < ratio / in_current < ALIKE:
            names, units, unit = VELOCITIES, SPEEDS, unit_of(in_current, SPEEDS, NEAR_IN_CURRENT)
        if unit is None:
            said = f"the way of the velocities is {ratio:.4g} times that of the positions"
            return _odd(said, ratio, ODD_WAY, (*VELOCITIES[:1], *POSITIONS))
        factor, columns = 1.0 / next(k for k, v in units.items() if v == unit), [n for n in names if record.has(n)]
        readings = [dict.fromkeys(columns, factor), *({name: factor} for name in columns)]
        factors = min(readings, key=lambda reading: _disagreement(record, reading))
        said = f"{' and '.join(factors)} seem to hold {unit}: the velocities' way is {ratio:.4g} times the positions'"
        return Fault(said, tuple(factors), (exact("ratio", ratio, "1"),), columns=scaled(record, **factors))

    def _rudders(self, record: Record) -> list[Fault]:
        faults = []
        for name in RUDDERS if not record.has(*TWIN) else ():  # the order of two thrusters is their difference, N
            most = float(np.nanmax(np.abs(record.column(name)), initial=0.0)) if record.has(name) else 0.0
            if most > LARGEST_RUDDER:
                said = f"{name} reaches {most:.4g} rad: it holds degrees"
                fixed = scaled(record, **{name: DEGREE})
                faults.append(Fault(said, (name,), (exact("largest", most, "rad"),), columns=fixed))
        return faults


def revolutions_units(records: Sequence[Record]) -> dict[str, Fault]:
    """Name of a record -> its fault, of records whose revolutions for their speed are those of the others in another
    unit; none where fewer than two others tell, or half of the records or more differ."""
    each = {r.name: x for r in records if (x := _turns_of_a_metre(r)) is not None}
    faults = dict[str, Fault]()
    for record in (r for r in records if r.name in each):
        usual = float(np.median([x for name, x in each.items() if name != record.name])) if len(each) > 2 else 0.0
        ratio = each[record.name] / usual if usual else 1.0
        factor = next((f for f in TURNS_OF if 1.0 / ALIKE < ratio / f < ALIKE), None)
        if factor is not None:
            said = f"{REVOLUTIONS} seems to hold {TURNS_OF[factor]}: for the speed it is {ratio:.3g} times the others'"
            columns = scaled(record, **{REVOLUTIONS: 1.0 / factor})
            faults[record.name] = Fault(said, (REVOLUTIONS,), (exact("ratio", ratio, "1"),), columns=columns)
    return faults if 2 * len(faults) < len(each) else {}


def _turns_of_a_metre(record: Record) -> float | None:
    """Revolutions over the speed on a straight course, 1/m; None where one of them is not known."""
    speed = straight_speed(record)
    turns = np.abs(record.column(REVOLUTIONS)) if record.has(REVOLUTIONS) else np.zeros(0)
    usual = float(np.nanmedian(turns)) if np.isfinite(turns).any() else 0.0
    return usual / speed if speed is not None and usual > 0.0 else None


def _disagreement(record: Record, factors: Mapping[str, float]) -> float:
    """Disagreement of the track with the velocities where columns are multiplied by factors; 0 where none is told."""
    if not record.has(*TRACK):
        return 0.0
    error = track_error(averages_of(record.with_channels(**scaled(record, **factors))))
    return 0.0 if np.isnan(error) else error


def _odd(said: str, ratio: float, odd: float, columns: tuple[str, ...]) -> Fault | None:
    """A ratio that neither a scale error nor a turned sign explains."""
    if 1.0 / odd < ratio < odd or turns_back(ratio):
        return None
    return Fault(
        f"{said}: another unit, quantity or sampling rate", columns, (exact("ratio", ratio, "1"),), standing=True
    )


def _wraps(record: Record, turn: Ratio | None) -> bool:
    """Whether the heading wraps as radians taken for degrees do, and then goes with the yaw rate."""
    heading = record.column("heading_rad")
    heading = heading[np.isfinite(heading)]
    alike = turn is None or (turn.correlation > AGREE and abs(turn.slope - 1.0) < 1.0 - AGREE)
    return heading.size > 1 and alike and wraps_at_small_turn(heading)


class ChannelSign(FileCheck):
    """A column with the other sign: yaw rate against heading, sway or east against the track, the track's turns against
    the heading's, revolutions against the way."""

    id, rank = "channel_sign", 50
    ends = True
    separate_by = "the logger's list of channels and its axes"

    def find(self, record: Record) -> list[Fault]:
        rate = self._of_rate(record)
        if rate is not None:
            record = cleaned(record, [rate])
            better = better_reading(record)
            backwards = better.reading.check == "heading_zero" if better else course_askew(record) is not None
            if rate.channels == ("yaw_rate_rad_s",) and backwards:
                said = "the yaw rate turns against the heading, and the ship goes astern: time runs backwards"
                return [Fault(said, ("time_s",), rate.sizes, standing=True)]
        better = better_reading(record)
        track = self._of_course(record) if better is None and not (rate and rate.standing) else None
        if better is not None and better.reading.check == self.id:  # of another reading another check tells
            size = exact("disagreement", better.present, "1")
            track = replace(reread(record, self.id)[0], sizes=(size,), statistic=0.0)
        return [f for f in (rate, track, self._of_revolutions(record)) if f]

    def _of_revolutions(self, record: Record) -> Fault | None:
        """Revolutions astern wherever the ship makes way ahead: one that stops has them at the end only."""
        speed = straight_speed(record) if record.has(REVOLUTIONS) else None
        if speed is None:
            return None
        turns = record.column(REVOLUTIONS)[record.column("surge_m_s") > WAY * speed]
        if turns.size < FEWEST or not np.nanmean(turns < 0.0) > NEARLY_ALL:
            return None
        said = f"{REVOLUTIONS} are astern while the ship makes way ahead: the sign is wrong"
        return Fault(said, (REVOLUTIONS,), columns=scaled(record, **{REVOLUTIONS: -1.0}))

    def _of_rate(self, record: Record) -> Fault | None:
        ratio = heading_ratio(record)
        if ratio is None or ratio.correlation > -AGREE_AS_RUDDER or not turns_back(ratio.slope):
            return None
        side = steering_side(record) if record.meta.positive_rudder else None
        against = side is not None and side[0] != record.meta.positive_rudder
        if ratio.correlation > -AGREE and not against:
            return None
        said = f"yaw_rate_rad_s turns against the heading (correlation {ratio.correlation:.3f})"
        size, track = (exact("ratio", ratio.slope, "1"),), track_of(averages_of(record))
        with_rate, what = (track is not None and track.mirrored), "track turns"
        if track is None:
            with_rate, what = not against, "rudder turns the ship"
            if side is None:
                said += "; without positions nothing tells which of the two is wrong"
                return Fault(said, ("heading_rad", "yaw_rate_rad_s"), size, standing=True)
        wrong = "heading_rad" if with_rate else "yaw_rate_rad_s"
        said += f"; the {what} with {'the yaw rate' if with_rate else 'the heading'}"
        return Fault(said, (wrong,), size, columns=scaled(record, **{wrong: -1.0}))

    def _of_course(self, record: Record) -> Fault | None:
        """Positions alone, without velocities or together with them: their track turns to the other side."""
        track = track_of(averages_of(record))
        if track is None or not track.mirrored:
            return None
        said = f"the track turns against the heading, as if {track.reading}; or the heading counts anticlockwise"
        return Fault(said, POSITIONS, standing=True)


WAY, NEARLY_ALL = 0.3, 0.95
"""Share of the speed on a straight course from which a ship makes way, and share of the samples that nearly all are."""
CHANNEL, SIDES = "yaw_rate_rad_s", ("starboard", "port")
WHOLE, LOST = 1.3, 0.5
"""Factor by which the scale of the right side may differ from one, and scale below which the other side is wrong."""
TURNS, USUAL = 0.4, 0.95
"""Share of the usual turn in a window, which is this quantile of all, from which a window turns to a side."""
CLEAR = 10.0
"""Standard deviations of the heading's noise that the turn in a window must exceed."""
FEWEST, MANOEUVRES = 30, 0.1
"""Samples and windows below which nothing is compared, and share of the windows that must turn to each side."""
EXPLAINED, TWO_SCALES = 0.25, 0.5
"""Share of the yaw rate's spread that two scales may leave, and share of what one scale leaves that they may."""


class OneSidedChannel(FileCheck):
    """The yaw rate is right in turns to one side, and lost, or without its sign, in turns to the other:
    recorded = s r with s = 1 for one sign of r and s < 0.5 for the other, as the heading shows."""

    id, rank = "one_sided_channel", 20
    separate_by = "the raw output of the sensor, and the type of number (signed or unsigned) that the logger reads"

    def find(self, record: Record) -> list[Fault]:
        sides = _side_scales(record) if record.has(*TURN) else None
        if sides is None:
            return []
        (low, wrong), (high, right) = sorted(zip(sides, SIDES, strict=True))
        if not (low < LOST and 1.0 / WHOLE < high < WHOLE):
            return []
        how = "its sign is lost" if low < -LOST else "one side of it is lost"
        said = (
            f"{CHANNEL} is {low:.3g} times what the heading shows in turns to {wrong}, and {high:.3g} times in turns "
            f"to {right}: {how}; leave the column out, the heading remains, or export it again as a signed number"
        )
        sizes = tuple(exact(side, value, "1") for side, value in zip(SIDES, sides, strict=True))
        return [Fault(said, (CHANNEL,), sizes, columns=without(record, CHANNEL, True))]


def _side_scales(record: Record) -> list[float] | None:
    """Scales of the yaw rate to starboard and to port, where they describe it and one scale does not; None else.

    An offset is estimated along: it, too, makes turns to one side too small.
    """
    time, heading, rate = known_together(record, record.heading_unwrapped(), record.column(CHANNEL))
    if time.size < FEWEST:
        return None
    turned, by_rate = over_windows(time, heading, rate)
    if turned.size < FEWEST:
        return None
    least = max(TURNS * float(np.quantile(np.abs(turned), USUAL)), CLEAR * np.sqrt(2.0) * sensor_sd(heading))
    if min(np.mean(turned > least), np.mean(turned < -least)) < MANOEUVRES:
        return None
    clear = np.abs(turned) > least
    return _fitted(turned[clear], by_rate[clear])


def _fitted(turned: np.ndarray, by_rate: np.ndarray) -> list[float] | None:
    """Scales of the changes (M,) that the yaw rate gives over those of the heading, rad."""
    offset = np.ones(turned.size)
    one = np.stack([turned, offset], axis=1)
    two = np.stack([np.maximum(turned, 0.0), np.minimum(turned, 0.0), offset], axis=1)
    left, before = (float(np.std(by_rate - x @ lstsq(x, by_rate))) for x in (two, one))
    if not left < min(EXPLAINED * float(np.std(by_rate)), TWO_SCALES * before):
        return None
    return lstsq(two, by_rate).tolist()[:2]
