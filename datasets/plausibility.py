"""Plausibility of records: units, sizes, other ships, other scales, frozen samples, jumps, runs given twice.

`doubts` says all that is doubtful about a record; `check_plausible` refuses records with a fatal doubt and returns the
others, for the pages of results.  What a diagnosis can name as a sensor's fault is never fatal here.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..models.data_file import load
from ..models.errors import BadInput
from .axes import ACROSS, goes_astern, lever_arm, track_of
from .columns import HEADING, POSITIONS, RUDDERS, TRACK, TURN, TWIN
from .copies import check_no_copies
from .geometry import over_ground, unwrapped
from .instruments import REVOLUTIONS
from .record import Record
from .signals import NEAR, changes, integral_over_gaps, median_ratio
from .time_faults import time_fault

if TYPE_CHECKING:
    from ..models.model import Model

DEGREE, GRAVITY = np.pi / 180.0, 9.81
LARGEST_RUDDER, MOVED = 1.6, 0.02
"""Rudder angle, rad, that no rudder reaches, and the range of angles over which a ship turns."""
FAINTEST = 1e-9
"""Range of headings (rad) or yaw rates (rad/s) that no sensor resolves."""
FASTEST, FASTEST_M_S, FASTEST_RAD_S = 10.0, 150.0, 7.0
"""Times the model's speed (yaw rate: its speed over its length) that no record of its ship reaches, and the speed and
yaw rate of anything afloat, for models without a speed or length."""
UNIT_SHARE, ODD = 0.02, 5.0
"""How near a ratio must be to a unit's factor, and the ratio from which on it is no error of a sensor."""
OTHER_LENGTH = 0.05
"""Relative difference of lengths from which on two vessels are not the same ship."""
SCALE_SPEED, SCALE_TURN, SCALE_FROUDE = 2.5, 2.5, 0.7
"""Ratio of speeds from which on scales are compared; yaw rate times the model's length over speed, and Froude number
with the model's length, that no ship reaches."""
SLIPPING = 1.7
"""Factor on the revolutions that a model turns at a speed, from which recorded ones are doubtful."""


@dataclass(frozen=True)
class Doubt:
    """What is doubtful about a record: message, column, what to do, and whether the record is refused for it.

    concerns : columns of which one that is wrong gives rise to the doubt, beside `column`.
    """

    record: str
    message: str
    hint: str
    column: str | None = None
    fatal: bool = True
    concerns: tuple[str, ...] = ()

    def is_about(self, columns: Collection[str]) -> bool:
        """Whether one of the columns gives rise to it."""
        return not {self.column, *self.concerns}.isdisjoint(columns)

    def error(self) -> BadInput:
        """The doubt as an error."""
        return BadInput(self.message, file=self.record, column=self.column, hint=self.hint)

    def __str__(self) -> str:
        return str(self.error())


class PlausibilityWarning(UserWarning):
    """A record is usable, but something about it is doubtful."""


def check_plausible(records: Sequence[Record], model: Model) -> list[Doubt]:
    """Refuse records that hold the same run twice, or whose numbers cannot be what their columns say; the doubts that
    are left.

    Raises
    ------
    BadInput : naming record, row and column where there are any, and the unit that the numbers are likely in.
    """
    check_no_copies(records)
    found = [doubt for record in records for doubt in doubts(record, model)]
    for doubt in found:
        if doubt.fatal:
            raise doubt.error()
    return found


def doubts(record: Record, model: Model | None = None) -> list[Doubt]:
    """All that is doubtful about a record, on its own and as a record of the model's ship."""
    units = [*_rudder(record), *_turned(record), *_way(record)]
    known = [doubt for doubt in units if doubt.fatal and doubt.column is not None]
    others = [doubt for doubt in units if doubt not in known]
    ship = list(_vessel(record, model)) if model is not None else []
    sizes = [] if known else [*_speed(record, model), *_rate(record, model)]
    scale = [*_scale(record, model), *_revolutions(record, model)] if model and not (known or ship or sizes) else []
    axes = [] if units else [*_track(record, model), *_point(record, model)]
    wrong = time_fault(record.time_s)
    times = [] if wrong is None else [
        Doubt(record.name, f"{wrong.message} (sample {wrong.index})", wrong.hint, "time_s")
    ]  # fmt: skip
    return [*ship, *known, *_alive(record), *sizes, *scale, *others, *axes, *times]


# ------------------------------------------------------------------------------------------------ sizes


def _rudder(record: Record) -> Iterator[Doubt]:
    for name in RUDDERS:
        if not record.has(name) or record.has(*TWIN):
            continue
        angle = np.nan_to_num(np.abs(record.column(name)))
        largest = float(angle.max())
        if largest > LARGEST_RUDDER:
            degrees = largest * DEGREE <= LARGEST_RUDDER
            hint = f"degrees? then call the column {name.replace('_rad', '_deg')}" if degrees else "check the column"
            when = record.time_s[int(angle.argmax())]
            message = f"a rudder angle of {largest:.4g} rad at {when:.6g} s, beyond {LARGEST_RUDDER} rad"
            yield Doubt(record.name, message, hint, name)


def _speed(record: Record, model: Model | None) -> Iterator[Doubt]:
    known = model is not None and np.isfinite(model.speed_m_s)
    most = FASTEST * model.speed_m_s if known and model is not None else FASTEST_M_S
    for name in ("surge_m_s", "sway_m_s"):
        speed = _usual_size(record, name)
        if speed > most:
            said = f"{most:.0f} m/s"
            if known and model is not None:
                said = f"{FASTEST:.0f} times the {model.speed_m_s:.4g} m/s of {model.id}"
            hint = "check its unit, its scale (model or full scale) and that the model is that of the ship"
            yield Doubt(record.name, f"a speed of {speed:.4g} m/s, above {said}", hint, name)


def _rate(record: Record, model: Model | None) -> Iterator[Doubt]:
    length, speed = (model.particulars.get("L"), model.speed_m_s) if model is not None else (None, np.nan)
    most = FASTEST * speed / length if length is not None and np.isfinite(speed) else FASTEST_RAD_S
    rate = _usual_size(record, "yaw_rate_rad_s")
    if rate > most:
        degrees = rate * DEGREE <= most
        hint = "degrees per second? then call the column yaw_rate_deg_s" if degrees else "check its unit and its scale"
        message = f"a yaw rate of {rate:.4g} rad/s, beyond {most:.3g} rad/s"
        yield Doubt(record.name, message, hint, "yaw_rate_rad_s")


def _usual_size(record: Record, name: str) -> float:
    """Size below which 99 of 100 samples of a channel are (single gross errors do not count); 0 without samples."""
    values = np.abs(record.column(name)) if record.has(name) else np.zeros(0)
    values = values[np.isfinite(values)]
    return float(np.quantile(values, 0.99)) if values.size else 0.0


# ------------------------------------------------------------------------------------------------ ship and scale


def _vessel(record: Record, model: Model) -> Iterator[Doubt]:
    """The sidecar names a vessel whose length is not the model's."""
    from ..models.model import list_vessels, resolve

    said, length = record.meta.vessel, model.particulars.get("L")
    if said is None or length is None or said == model.id or said not in list_vessels():
        return
    own = resolve(said).particulars.get("L")
    if own is not None and abs(own / length - 1.0) > OTHER_LENGTH:
        message = f"is a record of {said} ({own:.4g} m), the model {model.id} is {length:.4g} m long"
        hint = f"give the model of {said}, or correct 'vessel' in the record's sidecar"
        yield Doubt(record.name, message, hint)


def _scale(record: Record, model: Model) -> Iterator[Doubt]:
    """Speed and yaw rate are those of another scale than the model's."""
    length, speed = model.particulars.get("L"), straight_speed(record)
    if length is None or speed is None or not np.isfinite(model.speed_m_s):
        return
    ratio = speed / model.speed_m_s
    turn = _usual_size(record, "yaw_rate_rad_s") * length / speed
    froude = speed / np.sqrt(GRAVITY * length)
    smaller = ratio < 1.0 / SCALE_SPEED and turn > SCALE_TURN
    larger = ratio > SCALE_SPEED and froude > SCALE_FROUDE and model.speed_m_s < 0.5 * np.sqrt(GRAVITY * length)
    if not smaller and not larger:
        return
    scale = max(ratio, 1.0 / ratio) ** 2
    which = "smaller" if smaller else "larger"
    message = (
        f"speed {speed:.3g} m/s and yaw rate are those of a ship about {scale:.0f} times {which} than {model.id} "
        f"({length:.4g} m, {model.speed_m_s:.3g} m/s)"
    )
    hint = "model scale against full scale? scale the record by Froude's law, or give a model of its scale"
    yield Doubt(record.name, message, hint)


def _revolutions(record: Record, model: Model) -> Iterator[Doubt]:
    """The propeller turns at another rate than the model's does at this speed."""
    speed, own = straight_speed(record), model.n0_rps
    if speed is None or not own or not np.isfinite(model.speed_m_s) or not record.has(REVOLUTIONS):
        return
    rate = float(np.nanmedian(np.abs(record.column(REVOLUTIONS))))
    usual = own * speed / model.speed_m_s
    if rate > 0.0 and not 1.0 / SLIPPING < rate / usual < SLIPPING:
        message = (
            f"{rate:.3g} rps is {rate / usual:.3g} times what {model.id} turns at {speed:.3g} m/s ({usual:.3g} rps)"
        )
        in_minutes = 1.0 / SLIPPING < rate / usual / 60.0 < SLIPPING
        other = "of the engine before the gear, or in another unit? else the model's n0_rps is wrong"
        hint = f"revolutions {'in a minute, not in a second?' if in_minutes else other}"
        yield Doubt(record.name, message, hint, REVOLUTIONS, fatal=in_minutes)


def straight_speed(record: Record) -> float | None:
    """Speed, m/s, that a tenth of the samples exceed; None where no speed is recorded."""
    if not record.has("surge_m_s"):
        return None
    known = np.abs(record.column("surge_m_s"))
    known = known[np.isfinite(known)]
    speed = float(np.quantile(known, 0.9)) if known.size else 0.0
    return speed if speed > 0.0 else None


# ------------------------------------------------------------------------------------------------ channels


def _alive(record: Record) -> Iterator[Doubt]:
    """A heading or a yaw rate that stays the same while the rudder moves."""
    rudder = record.rudder() if record.has(RUDDERS[0]) or record.has(RUDDERS[1]) else np.zeros(1)
    rudder = rudder[np.isfinite(rudder)]
    if not rudder.size or np.ptp(rudder) < MOVED:
        return
    for name in ("heading_rad", "yaw_rate_rad_s"):
        values = record.column(name) if record.has(name) else np.zeros(0)
        values = values[np.isfinite(values)]
        if values.size > 1 and np.ptp(values) < FAINTEST:
            message = f"stays at {values[0]:.4g} while the rudder moves by {np.ptp(rudder):.3g} rad"
            yield Doubt(record.name, message, "a dead sensor? leave the column out", name)


def _turned(record: Record) -> Iterator[Doubt]:
    """Compare the heading's changes with the yaw rate's integral."""
    ratio = _turn_ratio(record)
    if ratio is None and record.has(*TURN):
        turned = changes(record, unwrapped(record.column("yaw_rate_rad_s")))
        given = changes(record, integral_over_gaps(record.column("heading_rad"), record.time_s))
        exchanged = median_ratio(turned, given)
        if exchanged is not None and abs(exchanged - 1.0) < NEAR:
            message = "changes as the integral of heading_rad does"
            yield Doubt(record.name, message, "exchange the names of the two columns", "yaw_rate_rad_s")
    yield from _ratio(record, ratio, _wrong_units()["turn"], ("headings", "heading, yaw rate and time"), TURN)


def _turn_ratio(record: Record) -> float | None:
    """Median ratio of the heading's changes to those that the yaw rate and the time give."""
    if not record.has(*TURN):
        return None
    given = changes(record, integral_over_gaps(record.column("yaw_rate_rad_s"), record.time_s))
    ratio = median_ratio(changes(record, record.heading_unwrapped()), given)
    # Full turns of a heading in degrees are no multiples of 2 pi.
    return median_ratio(changes(record, record.column("heading_rad")), given) if ratio is None else ratio


def _way(record: Record) -> Iterator[Doubt]:
    """Compare the way made by the positions with that by the speeds; the time is right where heading and yaw rate say
    so."""
    if record.has("surge_m_s", "sway_m_s", "north_m", "east_m"):
        with np.errstate(all="ignore"):
            way = np.hypot(changes(record, record.column("north_m")), changes(record, record.column("east_m")))
            surge, sway = record.column("surge_m_s"), record.column("sway_m_s")
            heading = record.column("heading_rad") if record.has("heading_rad") else np.full(record.n, np.nan)
        path = changes(record, integral_over_gaps(np.hypot(surge, sway), record.time_s))
        turned = np.abs(changes(record, integral_over_gaps(over_ground(surge, sway, heading), record.time_s)))
        ratio = median_ratio(way, turned)  # of a craft that turns about, the path is longer than the way
        ratio = median_ratio(way, path) if ratio is None else ratio
        turn = _turn_ratio(record)
        timed = turn is not None and abs(turn - 1.0) < NEAR
        units = {unit: place for unit, place in _wrong_units()["way"].items() if not (timed and place[0] == "time_s")}
        yield from _ratio(record, ratio, units, ("positions", "positions, speeds and time"), TRACK)


@cache
def _wrong_units() -> dict[str, dict[str, tuple[str, float]]]:
    """Kind of changes -> unit -> the column, and how many times as much it then changes as the others say."""
    return load(Path(__file__).with_name("wrong_units.yaml"))


def _ratio(
    record: Record,
    ratio: float | None,
    units: Mapping[str, tuple[str, float]],
    said: tuple[str, str],
    concerns: tuple[str, ...],
) -> Iterator[Doubt]:
    """A ratio of changes that only another unit can make, or another direction."""
    if ratio is None:
        return
    what, columns = said
    if ratio < 0.0:
        message = f"{what} change against the direction of the rates of change"
        yield Doubt(record.name, message, f"check the signs of {columns}", fatal=False, concerns=concerns)
        return
    message = f"{what} change {ratio:.4g} times as much as the rates of change and the time say"
    for unit, (column, factor) in units.items():
        if abs(ratio / factor - 1.0) < UNIT_SHARE:
            hint = unit if "?" in unit else f"{unit}? convert it; 'helmbench import' converts units"
            yield Doubt(record.name, message, hint, column)
            return
    if not 1.0 / ODD < ratio < ODD:
        yield Doubt(record.name, message, f"check the units of {columns}")


# ------------------------------------------------------------------------------------------------ axes


def _track(record: Record, model: Model | None) -> Iterator[Doubt]:
    """The positions turn against the heading, or lie across it.

    With velocities a diagnosis can name it; without, nothing tells how a hull's model would be compared with it.
    """
    found = track_of(record)
    if found is None:
        return
    needed = model is not None and model.is_3dof and not record.has("surge_m_s", "sway_m_s")
    if found.mirrored:
        hint = f"mirrored axes? as if {found.reading}; or the heading counts anticlockwise"
        yield Doubt(record.name, "the track turns against the heading", hint, "north_m", needed, (HEADING, *POSITIONS))
    elif abs(found.angle) > ACROSS and not goes_astern(record):
        message = f"the track runs at {np.degrees(found.angle):.0f} deg to the heading"
        hint = "check that the heading counts from north_m to east_m, and that the axes are in this order"
        yield Doubt(record.name, message, hint, "north_m", needed, (HEADING, *POSITIONS))


def _point(record: Record, model: Model | None) -> Iterator[Doubt]:
    """The sway is that of a point far from midship: an antenna's velocities, not the ship's."""
    length = model.particulars.get("L") if model is not None else None
    found = lever_arm(record, length)
    if found is None:
        return
    ahead, place = found
    where = f", as that of a point {abs(place):.3g} m {'ahead of' if place > 0.0 else 'abaft'} midship"
    message = (
        f"turns about a point {abs(ahead):.3g} m {'ahead of' if ahead > 0.0 else 'abaft'} the one recorded"
        f"{where if np.isfinite(place) else ''}"
    )
    hint = "an antenna's velocities? take its distance ahead of midship times yaw rate off the sway; else check signs"
    if length is not None and abs(place) > 0.5 * length:
        hint = "no point of the ship: the sway counts to the other side, or it is no sway"
    yield Doubt(record.name, message, hint, "sway_m_s", fatal=False, concerns=TURN[1:])
