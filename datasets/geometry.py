"""Angles and axes: angles without jumps of a full turn, velocities in body axes."""

from __future__ import annotations

import numpy as np


def unwrapped(angle: np.ndarray) -> np.ndarray:
    """Angles (N,), rad, without jumps of a full turn; gaps stay nan and are bridged by the shorter way round."""
    if np.all(np.abs(np.diff(angle)) < np.pi):  # neither jumps nor gaps
        return angle.copy()
    out, known = angle.copy(), np.isfinite(angle)
    out[known] = np.unwrap(angle[known])
    return out


def body_velocities(
    speed_north: np.ndarray, speed_east: np.ndarray, heading: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Surge and sway (N,), m/s, from velocities to north and east and the heading (N,), rad."""
    cos, sin = np.cos(heading), np.sin(heading)
    return speed_north * cos + speed_east * sin, speed_east * cos - speed_north * sin
