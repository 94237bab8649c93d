"""Check `wrong_unit`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...datasets.record import RUDDERS
from ..base import FileCheck
from ..fault import Fault, exact
from ..integrity.ratios import (
    AGREE,
    ANGLES,
    PLACES,
    SPEEDS,
    TURN,
    Ratio,
    course_ratio,
    heading_ratio,
    speed_ratio,
    turns_back,
    unit_of,
)
from ..integrity.readings import better_reading
from ..integrity.wraps import SMALL_TURN, wraps_at_small_turn

if TYPE_CHECKING:
    from ...datasets.record import Record

DEGREE = np.pi / 180.0
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
PLACE_COLUMNS = ("north_m", "east_m")
SPEED_COLUMNS = ("surge_m_s", "sway_m_s")


class WrongUnit(FileCheck):
    """A column in another unit than its name says: degrees for radians, knots for metres per second, feet for metres,
    or a time that runs faster or slower than rates and velocities show."""

    id = "wrong_unit"
    rank = 40
    ends = True
    of_logger = True
    separate_by = "the logger's list of channels"

    def find(self, record: Record) -> list[Fault]:
        turn, way = heading_ratio(record), speed_ratio(record)
        time = self._time(turn, way)
        if time is not None:
            return [time]
        angles = self._angle(turn) or self._all_angles(record, turn)
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

    def _angle(self, ratio: Ratio | None) -> Fault | None:
        if ratio is None or abs(ratio.correlation) < AGREE:
            return None
        if unit_of(ratio.slope, ANGLES) is None:
            said = f"heading_rad changes {ratio.slope:.4g} times as much as yaw_rate_rad_s and the time give"
            return _odd(said, ratio.slope, ODD_TURN, TURN)
        name, other = TURN if abs(ratio.slope) > 1.0 else TURN[::-1]
        times = max(abs(ratio.slope), 1.0 / abs(ratio.slope))
        said = f"{name} holds degrees: its changes are {times:.4g} times what {other} gives"
        return Fault(said, (name,), (exact("ratio", ratio.slope, "1"),), factors={name: DEGREE})

    def _all_angles(self, record: Record, turn: Ratio | None) -> Fault | None:
        """Heading and yaw rate together in another unit, which the track shows, or the heading's own wraps."""
        if not record.has("heading_rad"):
            return None
        better, ratio = better_reading([record]), course_ratio(record)
        if better is not None and better.reading.check == self.id:
            said = better.evidence("with heading_rad in another unit: radians were taken for degrees")
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
        names, units, unit = SPEED_COLUMNS, SPEEDS, unit_of(ratio, SPEEDS)
        if unit is None:
            names, units, unit = PLACE_COLUMNS, PLACES, unit_of(1.0 / ratio, PLACES)
        if unit is None:
            said = f"the way of the velocities is {ratio:.4g} times that of the positions"
            return _odd(said, ratio, ODD_WAY, (*SPEED_COLUMNS[:1], *PLACE_COLUMNS))
        factors = {name: 1.0 / next(k for k, v in units.items() if v == unit) for name in names if record.has(name)}
        said = f"{' and '.join(factors)} seem to hold {unit}: the velocities' way is {ratio:.4g} times the positions'"
        return Fault(said, tuple(factors), (exact("ratio", ratio, "1"),), factors=factors)

    def _rudders(self, record: Record) -> list[Fault]:
        found = []
        for name in RUDDERS:
            most = float(np.nanmax(np.abs(record.column(name)), initial=0.0)) if record.has(name) else 0.0
            if most > LARGEST_RUDDER:
                said = f"{name} reaches {most:.4g} rad: it holds degrees"
                found.append(Fault(said, (name,), (exact("largest", most, "rad"),), factors={name: DEGREE}))
        return found


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
