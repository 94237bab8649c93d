"""Axes of positions and velocities: the track against the heading, and the sway of a point that is not midship."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .record import Record
from .signals import FEWEST, changes, integral_over_gaps, over_short_gaps

MIRRORED = 0.25
"""How much less the course must scatter about the mirrored heading than about the heading."""
TURNED = 0.005
"""Scatter (1 - length of the mean unit vector) about one of the two below which the ship has not turned enough."""
STEADY = 0.1
"""Scatter from which a course says nothing."""
ACROSS = np.pi / 3.0
"""Angle of the track to the heading, rad, that no drift explains."""
FOLLOWS, EVEN = 0.35, 0.5
"""How far from one the course's turn may be, as a share of the heading's, and how much the logarithm of the speed may
change with the heading, 1/rad, where only the zero of the heading is wrong.

Speed u and current c make w = u exp(i psi) + c, so that d ln w / d psi = (u / |w|) (i cos a + sin a), where a is the
angle from heading to course: beyond 90 deg the course turns back, and below the speed changes by tan(a) times the turn.
"""
SPREAD = 0.1
"""Standard deviation of the heading, rad, below which nothing is said of how the course turns with it."""
UNDER_WAY = 0.3
"""Share of the usual way made in a window from which it has a course."""
ALIKE, OFF = 0.8, 0.3
"""The point about which a ship turns is told where sway and yaw rate are correlated so well, or where what it leaves of
the sway is below this share of the ship's length times the yaw rate."""
PIVOTS = (0.1, 0.75)
"""How far ahead of the recorded point, in ship lengths, a ship's point without sway lies: .24 to .63 in all vessels and
measured records of this distribution that are recorded midship or at the centre of gravity."""
USUAL_PIVOT = 0.4
LEAST_TURN = np.pi / 18.0
"""Range of headings, rad, below which a run is straight."""


@dataclass(frozen=True)
class Track:
    """The course of the positions against the heading.

    mirrored : whether it turns to the other side;  angle : rad, mean of the course less the heading, or, where it is
    mirrored, of their sum;  scatter : about it, 1 - length of the mean unit vector;  turn, faster : slopes of the
    course and of the logarithm of the speed, 1/rad, over the heading, nan where the ship turns too little.
    """

    mirrored: bool
    angle: float
    scatter: float
    turn: float
    faster: float

    @property
    def askew(self) -> bool:
        """Whether the course stands at an angle to all headings that neither drift nor current explains."""
        follows = abs(self.turn - 1.0) < FOLLOWS and abs(self.faster) < EVEN
        return not self.mirrored and abs(self.angle) > ACROSS and follows

    @property
    def reading(self) -> str:
        """What would make a mirrored track right."""
        quarter = round(self.angle / (np.pi / 2.0)) % 4
        return (
            "east_m has the other sign",
            "north_m and east_m are exchanged",
            "north_m has the other sign",
            "north_m and east_m are exchanged and both have the other sign",
        )[quarter]


def track_of(record: Record) -> Track | None:
    """How positions and heading agree, without any velocity; None where they do not tell."""
    if not record.has("heading_rad", "north_m", "east_m"):
        return None
    psi, north, east = (
        over_short_gaps(x) for x in (record.heading_unwrapped(), record.column("north_m"), record.column("east_m"))
    )
    north, east = changes(record, north), changes(record, east)
    window = record.n - north.size
    heading = psi[window // 2 : window // 2 + north.size]
    way = np.hypot(north, east)
    known = np.isfinite(way) & np.isfinite(heading)
    if known.sum() < FEWEST:
        return None
    known &= np.nan_to_num(way) > UNDER_WAY * np.quantile(way[known], 0.9)
    if known.sum() < FEWEST:
        return None
    course = np.arctan2(east[known], north[known])
    same, other = (complex(np.mean(np.exp(1j * (course + side * heading[known])))) for side in (-1.0, 1.0))
    plain, mirror = 1.0 - abs(same), 1.0 - abs(other)
    mirrored = mirror < MIRRORED * plain and plain > TURNED
    if min(plain, mirror) > STEADY:
        return None
    angle = float(np.angle(other if mirrored else same))
    own, turn, faster = heading[known] - np.mean(heading[known]), float("nan"), float("nan")
    if np.std(own) > SPREAD:  # slopes over the heading; of the course that of its difference from it, and 1
        off = np.exp(1j * (course - heading[known]))
        off = np.angle(off * np.conj(np.mean(off)))
        turn, faster = (float(np.mean(own * x) / np.mean(own**2)) for x in (off, np.log(way[known])))
        turn += 1.0
    return Track(bool(mirrored), angle, mirror if mirrored else plain, turn, faster)


def goes_astern(record: Record, faster_than_m_s: float = 0.0) -> bool:
    """Whether a record's log says that the craft goes astern most of the time, faster than at a speed."""
    return record.has("surge_m_s") and float(np.nanmedian(record.column("surge_m_s"))) < -faster_than_m_s


def lever_arm(record: Record, length_m: float | None) -> tuple[float, float] | None:
    """Distance, m, from the recorded point ahead to the point that has no sway in turns, and how far the recorded point
    would stand ahead of midship; None where that is not outside what ships have, or where nothing tells it.

    length_m : the ship's length; None: only a distance clearly below 0 is outside, the second number is nan.
    """
    if not record.has("sway_m_s", "yaw_rate_rad_s"):
        return None
    sway, rate = record.column("sway_m_s"), record.column("yaw_rate_rad_s")
    known = np.isfinite(sway) & np.isfinite(rate)
    sway, rate = sway[known], rate[known]
    heading = integral_over_gaps(record.column("yaw_rate_rad_s"), record.time_s)
    if not np.isfinite(heading).any() or np.nanmax(heading) - np.nanmin(heading) < LEAST_TURN:
        return None
    with np.errstate(over="ignore"):
        turning, drifting = float(np.sum(rate**2)), float(np.sum(sway**2))
    if known.sum() < FEWEST or not 0.0 < turning < np.inf or not 0.0 < drifting < np.inf:
        return None
    ahead = -float(np.sum(sway * rate)) / turning
    if length_m is None:
        alike = -ahead * np.sqrt(turning / drifting)
        return (ahead, float("nan")) if alike > ALIKE else None
    low, high = PIVOTS
    if float(np.sum((sway + ahead * rate) ** 2)) > (OFF * length_m) ** 2 * turning:
        return None
    return None if low * length_m < ahead < high * length_m else (ahead, USUAL_PIVOT * length_m - ahead)
