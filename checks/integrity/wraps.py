"""Wraps of a heading, whatever its unit is."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ...datasets.record import Record

SMALL_TURN = 2.0 * np.pi * np.pi / 180.0
"""A full turn in radians that was taken for degrees, rad."""


def without_wraps(heading: np.ndarray) -> np.ndarray:
    """Heading (N,) without its wraps: at a full turn in radians, in degrees, or in radians taken for degrees."""
    turn, step, span = 2.0 * np.pi, float(np.max(np.abs(np.diff(heading)))), float(np.ptp(heading))
    if span > 3.0 * turn and step > 0.5 * 360.0:
        turn = 360.0
    elif wraps_at_small_turn(heading):
        turn = SMALL_TURN
    return np.unwrap(heading, period=turn) if span < 1.2 * turn else heading


def swing(record: Record) -> float:
    """Range of a record's headings, rad; 0 where none is known."""
    heading = record.heading_unwrapped() if record.has("heading_rad") else np.zeros(1)
    return float(np.nanmax(heading) - np.nanmin(heading)) if np.isfinite(heading).any() else 0.0


def continuous(heading: np.ndarray) -> np.ndarray:
    """Heading (N,) without its wraps, gaps as they are."""
    known, out = np.isfinite(heading), heading.copy()
    if known.sum() > 1:
        out[known] = without_wraps(heading[known])
    return out


def wraps_at_small_turn(heading: np.ndarray) -> bool:
    """Whether a heading (N,) without gaps wraps at a full turn in radians that was taken for degrees."""
    span, step = float(np.ptp(heading)), float(np.max(np.abs(np.diff(heading))))
    return span < 1.01 * SMALL_TURN and step > 0.9 * SMALL_TURN
