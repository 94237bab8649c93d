"""Positions and velocities over ground, velocities in body axes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .record import Record


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
