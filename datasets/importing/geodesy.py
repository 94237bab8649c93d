"""Positions on a plane, and the course of a track."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np


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

    pyproj; Snyder 1987, Map Projections: A Working Manual, USGS PP 1395, ch. 25.  nan stays nan.
    """
    import pyproj

    known = np.isfinite(latitude) & np.isfinite(longitude)
    first = int(known.argmax())
    origin = (float(latitude[first]), float(longitude[first]))
    text = f"+proj=aeqd +lat_0={math.degrees(origin[0])!r} +lon_0={math.degrees(origin[1])!r} +ellps=WGS84 +units=m"
    project = pyproj.Proj(text)
    north, east = np.full(latitude.size, np.nan), np.full(latitude.size, np.nan)
    east[known], north[known] = project(np.degrees(longitude[known]), np.degrees(latitude[known]))
    far = int(np.nanargmax(np.hypot(north, east)))
    factors = project.get_factors(np.degrees(longitude[far]), np.degrees(latitude[far]))
    scale = max(abs(factors.tissot_semimajor - 1.0), abs(factors.tissot_semiminor - 1.0))
    return north, east, Plane(*origin, scale, abs(float(np.radians(factors.meridian_convergence))))


def headings_of_track(north: np.ndarray, east: np.ndarray, time: np.ndarray, least_m_s: float) -> np.ndarray:
    """Course (N,), rad, of a track; nan where it is slower than `least_m_s`."""
    speed_north, speed_east = np.gradient(north, time), np.gradient(east, time)
    course = np.arctan2(speed_east, speed_north)
    return np.where(np.hypot(speed_north, speed_east) > least_m_s, course, np.nan)
