"""Angles and axes: angles without jumps of a full turn, velocities in body axes."""

from __future__ import annotations

import numpy as np

LARGE = 0.8
"""Step between samples, rad, from which a heading may have turned to a gross error."""


def unwrapped(angle: np.ndarray) -> np.ndarray:
    """Angles (N,), rad, without jumps of a full turn; gaps stay nan and are bridged by the shorter way round."""
    if np.all(np.abs(np.diff(angle)) < np.pi):  # neither jumps nor gaps
        return angle.copy()
    out, known = angle.copy(), np.isfinite(angle)
    out[known] = _without_slips(np.unwrap(angle[known]))
    return out


def _without_slips(angle: np.ndarray) -> np.ndarray:
    """Unwrapped angles (N,), rad, less the full turns that a gross error, or two in turn, leave behind them: large
    steps to, between and from them that add up to a turn, between small ones."""
    steps = np.diff(angle)
    large = np.abs(steps) > LARGE
    if not large.any():
        return angle
    for count in (2, 3):
        for k in np.flatnonzero(large[: large.size - count + 1]).tolist():
            inside, beside = slice(k, k + count), [i for i in (k - 1, k + count) if 0 <= i < large.size]
            turns = round(float(np.sum(steps[inside])) / (2.0 * np.pi))
            left = abs(float(np.sum(steps[inside])) - 2.0 * np.pi * turns)
            if turns and large[inside].all() and left < LARGE and not large[beside].any():
                steps[k + count - 1] -= 2.0 * np.pi * turns
    return np.concatenate([angle[:1], angle[0] + np.cumsum(steps)])


def body_velocities(
    speed_north: np.ndarray, speed_east: np.ndarray, heading: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Surge and sway (N,), m/s, from velocities to north and east and the heading (N,), rad."""
    cos, sin = np.cos(heading), np.sin(heading)
    return speed_north * cos + speed_east * sin, speed_east * cos - speed_north * sin
