"""Smoothed best estimates of a trajectory (SBET): rows of 17 binary numbers without a header."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from ..raw import RawColumn, RawTable, usable
from .fields import stated_fields, table_of_fields

FIELDS = 17
TIME, LATITUDE, LONGITUDE, X_SPEED, Y_SPEED, ROLL, HEADING, WANDER, YAW_RATE = 0, 1, 2, 4, 5, 7, 9, 10, 16
ROW = np.dtype(("<f8", FIELDS))
HEAD = 50
"""Rows that tell whether a file is of this form."""
LONGEST_STEP, FASTEST = 60.0, 100.0
"""Seconds between rows, and m/s, that such a file holds at most."""
RADIUS, AGREES = 6.371e6, 0.1
"""Radius of the earth, m, and the share of the speed within which velocities and positions agree."""
BY = "the SBET form states it"


def looks_like_sbet(data: bytes) -> bool:
    """Whether a binary file begins with rows of times, positions and angles."""
    size = min(len(data) // ROW.itemsize, HEAD)
    if size < 3 or len(data) % ROW.itemsize:
        return False
    rows = np.frombuffer(data, dtype=ROW, count=size)
    if not np.isfinite(rows).all():
        return False
    steps = np.diff(rows[:, TIME])
    limits = {LATITUDE: np.pi / 2.0, LONGITUDE: 7.0, X_SPEED: FASTEST, Y_SPEED: FASTEST, ROLL: 4.0, HEADING: 7.0}
    inside = all(np.abs(rows[:, place]).max() <= most for place, most in limits.items())
    return inside and bool((steps > 0.0).all() and steps.max() < LONGEST_STEP and np.ptp(rows[:, LATITUDE]) < 0.1)


def read_sbet(data: bytes, path: Path) -> list[RawTable]:
    """The rows of an SBET file: times in seconds of the GPS week, angles in radians.

    The heading counts from the wander azimuth frame, which is turned by the wander angle from north.
    """
    rows = np.frombuffer(data, dtype=ROW)
    values = {str(place): rows[:, place].copy() for place in range(FIELDS)}
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        values[str(HEADING)] = (rows[:, HEADING] - rows[:, WANDER]) % (2.0 * np.pi)
        values |= _velocity(rows, values[str(HEADING)])
    fields = stated_fields("SBET")["row"] | stated_fields("SBET")["velocity"]
    time = RawColumn("GPS seconds of week", "s", values[str(TIME)], "", BY)
    return usable([table_of_fields(path, fields, values, time, f"SBET, {len(rows)} rows")], path, "no rows of numbers")


def _velocity(rows: np.ndarray, heading: np.ndarray) -> dict[str, np.ndarray]:
    """Velocities to north and east: of the axes that programs use the ones that agree with the positions, or none."""
    north, east = (RADIUS * np.gradient(rows[:, place], rows[:, TIME]) for place in (LATITUDE, LONGITUDE))
    track = np.stack([north, east * np.cos(rows[:, LATITUDE])])
    tried = [_turned(rows[:, X_SPEED], rows[:, Y_SPEED], angle)
             for angle in (rows[:, WANDER], -rows[:, WANDER], heading)]  # fmt: skip
    misfits = [float(np.nanmedian(np.abs(own - track))) for own in tried]
    best = int(np.argmin(misfits))
    agrees = misfits[best] < AGREES * float(np.nanmedian(np.hypot(*track)))
    return dict(zip(("north", "east"), tried[best], strict=True)) if agrees else {}


def _turned(x: np.ndarray, y: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """(2, N) to north and east of a vector along axes that are turned clockwise by an angle."""
    return np.stack([x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)])


# ---- Text of Applanix's POS Export Utility: what its axes state of the roll.

POSPAC_TITLE = "POS Export Utility"


def with_pospac(table: RawTable) -> RawTable:
    """A table of that program: its axes are forward, right, down."""
    if not any(POSPAC_TITLE in note for note in table.notes):
        return table
    return table.told(
        lambda c: replace(c, said=(*c.said, "positive to starboard")) if c.name.strip().lower() == "roll" else c,
        f"{POSPAC_TITLE}: axes forward, right, down",
    )
