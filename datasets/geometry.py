"""Angles without jumps, positions and velocities over ground, velocities in body axes."""

from __future__ import annotations

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
    """Angles (N,), rad, without jumps of a full turn; gaps stay nan and are bridged by the shorter way round."""
    if np.all(np.abs(np.diff(angle)) < np.pi):  # neither jumps nor gaps
        return angle.copy()
    out, known = angle.copy(), np.isfinite(angle)
    out[known] = _without_slips(np.unwrap(angle[known]))
    return out


def _without_slips(angle: np.ndarray) -> np.ndarray:
    """Unwrapped angles (N,), rad, less the full turns that gross errors leave behind them: large steps to, between and
    from them that add up to a turn, between small ones.  More than `ALIKE` steps of one sign are a turn of the ship."""
    steps = np.diff(angle)
    large = np.abs(steps) > LARGE
    edges = np.flatnonzero(np.diff(np.concatenate([[False], large, [False]])))
    for first, behind in edges.reshape(-1, 2).tolist():
        own = steps[first:behind]
        turns = round(float(np.sum(own)) / (2.0 * np.pi))
        left = abs(float(np.sum(own)) - 2.0 * np.pi * turns)
        most = MOST if own.min() < 0.0 < own.max() else ALIKE
        if turns and left < LARGE and 2 <= own.size <= most:
            steps[behind - 1] -= 2.0 * np.pi * turns
    return np.concatenate([angle[:1], angle[0] + np.cumsum(steps)]) if large.any() else angle


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
