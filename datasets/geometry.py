"""Angles without jumps, positions and velocities over ground, velocities in body axes, positions on a plane."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .record import Record

# ---- Angles without jumps of a full turn.

LARGE = 0.8
"""Step between samples, rad, from which a heading may have turned to a gross error."""
ALIKE, MOST = 3, 7
"""Large steps in turn that gross errors make: of one sign, and of both."""


def unwrapped(angle: np.ndarray) -> np.ndarray:
    """Angles (N,), rad, without jumps of a full turn; gaps stay nan and are bridged by the shorter way round.

    Without the full turns that gross errors leave behind them: large steps to, between and from them that add up to a
    turn, between small ones.  More than `ALIKE` steps of one sign are a turn of the ship.
    """
    if np.all(np.abs(np.diff(angle)) < np.pi):  # neither jumps nor gaps
        return angle.copy()
    out, known = angle.copy(), np.isfinite(angle)
    whole = np.unwrap(angle[known])
    steps = np.diff(whole)
    large = np.abs(steps) > LARGE
    edges = np.flatnonzero(np.diff(np.concatenate([[False], large, [False]])))
    for first, behind in edges.reshape(-1, 2).tolist():
        own = steps[first:behind]
        turns = round(float(np.sum(own)) / (2.0 * np.pi))
        left = abs(float(np.sum(own)) - 2.0 * np.pi * turns)
        most = MOST if own.min() < 0.0 < own.max() else ALIKE
        if turns and left < LARGE and 2 <= own.size <= most:
            steps[behind - 1] -= 2.0 * np.pi * turns
    out[known] = np.concatenate([whole[:1], whole[0] + np.cumsum(steps)]) if large.any() else whole
    return out


def over_ground(surge: np.ndarray, sway: np.ndarray, heading: np.ndarray | float) -> NDArray[np.complex128]:
    """Velocities north + i east (N,), m/s, from surge and sway and the heading (N,) or one for all, rad."""
    return (surge + 1j * sway) * np.exp(1j * heading)


def position_over_ground(record: Record) -> NDArray[np.complex128]:
    """Position north + i east (N,), m."""
    return record.column("north_m") + 1j * record.column("east_m")


def velocity_over_ground(record: Record) -> NDArray[np.complex128]:
    """Velocity north + i east (N,), m/s, from surge, sway and heading."""
    return over_ground(record.column("surge_m_s"), record.column("sway_m_s"), record.heading_unwrapped())


def body_velocities(
    speed_north: np.ndarray, speed_east: np.ndarray, heading: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Surge and sway (N,), m/s, from velocities to north and east and the heading (N,), rad."""
    cos, sin = np.cos(heading), np.sin(heading)
    return speed_north * cos + speed_east * sin, speed_east * cos - speed_north * sin


# ---- Positions on a plane.

RADIUS_M, FLATTENING = 6378137.0, 1.0 / 298.257223563
"""The ellipsoid WGS 84."""
MOST_STEPS, CLOSE_RAD = 50, 1e-14


@dataclass(frozen=True)
class Plane:
    """A plane that touches the ellipsoid at its origin, rad.

    scale_error : largest relative error of distances;  convergence_rad : largest angle between the plane's north and
    true north, both within the positions of the log.
    """

    latitude_rad: float
    longitude_rad: float
    scale_error: float
    convergence_rad: float


def on_plane(latitude: np.ndarray, longitude: np.ndarray) -> tuple[np.ndarray, np.ndarray, Plane]:
    """North and east (N,), m, of positions (N,), rad; azimuthal equidistant projection of WGS 84 about the first.

    Snyder 1987, Map Projections: A Working Manual, USGS PP 1395, ch. 25: distance and course of the geodesic, scale
    across it eq. 25-2.  nan stays nan.
    """
    first = int((np.isfinite(latitude) & np.isfinite(longitude)).argmax())
    origin = (float(latitude[first]), float(longitude[first]))
    distance, course, course_there, arc = geodesics(*origin, latitude, longitude)
    across = np.where(arc > 0.0, arc / np.where(arc > 0.0, np.sin(arc), 1.0), 1.0)
    north_there = course - np.arctan2(across * np.sin(course_there), np.cos(course_there))
    turned = np.abs(np.remainder(north_there + math.pi, 2.0 * math.pi) - math.pi)
    plane = Plane(*origin, float(np.nanmax(across)) - 1.0, float(np.nanmax(turned)))
    return distance * np.cos(course), distance * np.sin(course), plane


def geodesics(
    latitude: float, longitude: float, latitudes: np.ndarray, longitudes: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Distance, m, course here and there, rad, and arc, rad, of the geodesics of WGS 84 from a place to others (N,).

    Vincenty 1975, Direct and inverse solutions of geodesics on the ellipsoid, Survey Review 23(176), eqs. 10 to 21;
    within 1e-4 m, but for places on the other side of the earth.
    """
    own, others = math.atan((1.0 - FLATTENING) * math.tan(latitude)), np.arctan((1.0 - FLATTENING) * np.tan(latitudes))
    sin1, cos1, sin2, cos2 = math.sin(own), math.cos(own), np.sin(others), np.cos(others)
    east = np.remainder(longitudes - longitude + math.pi, 2.0 * math.pi) - math.pi
    angle = east
    for _ in range(MOST_STEPS):
        across, along = cos2 * np.sin(angle), np.sin(others - own) + 2.0 * sin1 * cos2 * np.sin(0.5 * angle) ** 2
        sin_arc, cos_arc = np.hypot(across, along), sin1 * sin2 + cos1 * cos2 * np.cos(angle)
        arc = np.arctan2(sin_arc, cos_arc)
        sin_azimuth = cos1 * across / np.where(sin_arc > 0.0, sin_arc, 1.0)
        square = 1.0 - sin_azimuth**2
        middle = cos_arc - 2.0 * sin1 * sin2 / np.where(square > 1e-15, square, np.inf)
        c = FLATTENING / 16.0 * square * (4.0 + FLATTENING * (4.0 - 3.0 * square))
        more = arc + c * sin_arc * (middle + c * cos_arc * (2.0 * middle**2 - 1.0))
        former, angle = angle, east + (1.0 - c) * FLATTENING * sin_azimuth * more
        if np.nanmax(np.abs(angle - former)) < CLOSE_RAD:
            break
    u = square * ((1.0 / (1.0 - FLATTENING)) ** 2 - 1.0)
    a = 1.0 + u / 16384.0 * (4096.0 + u * (-768.0 + u * (320.0 - 175.0 * u)))
    b = u / 1024.0 * (256.0 + u * (-128.0 + u * (74.0 - 47.0 * u)))
    third = b / 6.0 * middle * (4.0 * sin_arc**2 - 3.0) * (4.0 * middle**2 - 3.0)
    less = b * sin_arc * (middle + b / 4.0 * (cos_arc * (2.0 * middle**2 - 1.0) - third))
    there = np.arctan2(cos1 * np.sin(angle), np.sin(others - own) - 2.0 * cos1 * sin2 * np.sin(0.5 * angle) ** 2)
    return (1.0 - FLATTENING) * RADIUS_M * a * (arc - less), np.arctan2(across, along), there, arc
