"""Readings of a record's columns: how well heading, rates, velocities and positions agree, as they are or exchanged."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from ...datasets.axes import Track, goes_astern, track_of
from ...datasets.columns import HEADING, POSITIONS, TRACK, TURN, VELOCITIES
from ...datasets.geometry import body_velocities, position_over_ground, velocity_over_ground
from ...datasets.signals import integral
from .averages import averages_of
from .ratios import WINDOW_S, whole_windows
from .wraps import continuous

if TYPE_CHECKING:
    from ...datasets.record import Record

BETTER = 0.5
"""Share of the present disagreement below which another reading of the columns is believed."""
FEWEST = 20
"""Samples with all channels below which nothing is compared."""
LEAST = 0.02
"""Disagreement, as a share of the way made, from which another reading is looked for."""
ASKEW = float(np.deg2rad(17.0))
"""Angle, rad, beyond which the heading has another zero."""
MOST = 0.35
"""Disagreement from which no reading is the right one."""
Reread = Callable[["Record"], "Record"]


def exchanged(first: str, second: str) -> Reread:
    """A record with two columns exchanged."""

    def reading(record: Record) -> Record:
        return record.with_channels(**{first: record.column(second), second: record.column(first)})

    return reading


def to_body(record: Record) -> Record:
    """Velocities along north and east turned into body axes."""
    psi, north, east = record.heading_unwrapped(), record.column("surge_m_s"), record.column("sway_m_s")
    surge, sway = body_velocities(north, east, psi)
    return record.with_channels(surge_m_s=surge, sway_m_s=sway)


def about_track(record: Record) -> Record:
    """The heading turned by the mean angle between the way made and the way that heading and velocities give, where
    that is beyond what a compass may err."""
    given, moved = _ways(record)
    angle = float(np.angle(np.sum(given * np.conj(moved)))) if given.size else 0.0
    return record if abs(angle) < ASKEW else record.with_channels(heading_rad=record.heading_unwrapped() - angle)


def heading_in_degrees(record: Record) -> Record:
    """The heading, without its wraps, as the degrees that its radians were taken for.

    The other way round, a heading that hardly turns any more, would read velocities along north and east as right.
    """
    heading = record.column("heading_rad")
    few = np.isfinite(heading).sum() < 2
    return record if few else record.with_channels(heading_rad=np.rad2deg(continuous(heading)))


class Reading(NamedTuple):
    """Another reading of heading, velocities and positions: the check that names it, the columns that it concerns, and
    the record read so."""

    check: str
    columns: tuple[str, ...]
    read: Reread


class Better(NamedTuple):
    """A reading that agrees far better, with the present and its own disagreement (shares of the way made)."""

    reading: Reading
    present: float
    own: float

    @property
    def statistic(self) -> float:
        """Square of the ratio of both disagreements."""
        return (self.present / max(self.own, 1e-6)) ** 2

    def evidence(self, how: str) -> str:
        """What agrees better: how the columns are read, in words."""
        return f"the track disagrees with the velocities by {self.present:.3f} of the way made, by {self.own:.3f} {how}"


READINGS = (
    Reading("earth_frame_velocity", VELOCITIES, to_body),
    Reading("heading_zero", (HEADING,), about_track),
    Reading("wrong_unit", TURN, heading_in_degrees),
    *(Reading("channel_swap", pair, exchanged(*pair)) for pair in (VELOCITIES, POSITIONS)),
)


_KNOWN_ERRORS: WeakKeyDictionary[Record, tuple[float, ...]] = WeakKeyDictionary()


def better_reading(records: Sequence[Record]) -> Better | None:
    """The reading of velocities and positions that agrees far better than the present one; None without any."""
    usable = [r for r in records if r.has(*TRACK)]
    if not usable:
        return None
    present, *errors = (float(np.mean(each)) for each in zip(*map(_errors, usable), strict=True))
    best = int(np.argmin(errors))
    sure = errors[best] < min(BETTER * present, MOST) and present > LEAST
    return Better(READINGS[best], present, errors[best]) if sure else None


def _errors(record: Record) -> tuple[float, ...]:
    """The track's error as a record's columns are read now, and in each of the other readings: several checks ask."""
    if record not in _KNOWN_ERRORS:
        short = averages_of(record)
        _KNOWN_ERRORS[record] = tuple(track_error(r) for r in (short, *(reading.read(short) for reading in READINGS)))
    return _KNOWN_ERRORS[record]


def course_askew(record: Record) -> Track | None:
    """The track of a record without velocities that stands at an angle to its heading which no drift or current
    explains; None for any other, and for a craft whose log says that it goes astern."""
    track = None if record.has(*TRACK) or goes_astern(record) else track_of(averages_of(record))
    return track if track is not None and track.askew else None


def read_as(records: Sequence[Record], reading: Reading) -> list[Record]:
    """The records with another reading of the track's columns, where they have them."""
    return [reading.read(r) if r.has(*TRACK) else r for r in records]


def rate_error(record: Record, name: str) -> float:
    """Share of the heading's changes over windows that a rate column does not give; nan for too few samples."""
    psi, rate, time = record.heading_unwrapped(), record.column(name), record.time_s
    known = np.isfinite(psi) & np.isfinite(rate)
    if known.sum() < FEWEST:
        return float("nan")
    psi, rate, time = psi[known], rate[known], time[known]
    step = min(max(2, round(WINDOW_S / 8.0 / np.median(np.diff(time)))), time.size // 2)
    turned = psi[step:] - psi[:-step]
    given = integral(rate, time)
    error = turned - (given[step:] - given[:-step])
    return float(np.sqrt(np.mean(error**2) / max(np.mean(turned**2), 1e-300)))


def track_error(record: Record) -> float:
    """Error of the displacement over windows that heading and velocities give, as a share of the way made; nan for too
    few samples."""
    given, moved = _ways(record)
    if not given.size:
        return float("nan")
    return float(np.sqrt(np.mean(np.abs(moved - given) ** 2) / max(np.mean(np.abs(moved) ** 2), 1e-300)))


def _ways(record: Record) -> tuple[np.ndarray, np.ndarray]:
    """Ways (M,) north + i east over windows, as heading and velocities give them and as positions show them; empty for
    too few samples."""
    velocity, place, time = velocity_over_ground(record), position_over_ground(record), record.time_s
    known = np.isfinite(velocity) & np.isfinite(place)
    if known.sum() < FEWEST:
        return np.zeros(0, complex), np.zeros(0, complex)
    time, place = time[known], place[known]
    step = int(np.clip(round(WINDOW_S / np.median(np.diff(time))), 2, time.size // 2))
    way = integral(velocity[known], time)
    whole = whole_windows(time, step)
    return (way[step:] - way[:-step])[whole], (place[step:] - place[:-step])[whole]
