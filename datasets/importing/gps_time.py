"""GPS time: weeks and seconds of them, and the leap seconds by which it is ahead of UTC."""

from __future__ import annotations

import datetime
import re
from collections.abc import Sequence
from itertools import starmap

import numpy as np

WEEK_S = 604800.0
EPOCH_S = 315964800.0
"""Begin of GPS time, 1980-01-06 00:00:00 UTC, in seconds since 1970."""
LEAP_SECONDS: tuple[tuple[int, int, int], ...] = (
    (1981, 7, 1), (1982, 7, 2), (1983, 7, 3), (1985, 7, 4), (1988, 1, 5), (1990, 1, 6), (1991, 1, 7), (1992, 7, 8),
    (1993, 7, 9), (1994, 7, 10), (1996, 1, 11), (1997, 7, 12), (1999, 1, 13), (2006, 1, 14), (2009, 1, 15),
    (2012, 7, 16), (2015, 7, 17), (2017, 1, 18),
)  # fmt: skip
"""(year, month, GPS time minus UTC from its first day on, s); IERS Bulletin C, by way of IANA's `leap-seconds.list`.

The last entry is that of 2017-01-01; none later was announced up to Bulletin C 70 of July 2025.
"""
STARTS = np.array([datetime.datetime(y, m, 1, tzinfo=datetime.UTC).timestamp() for y, m, _ in LEAP_SECONDS])
AHEAD = np.array([0, *(ahead for *_, ahead in LEAP_SECONDS)])
WEEK = re.compile(r"\bweek\s*(?:no\.?|number|nr\.?)?\s*[:=#]?\s*([12]\d{3})\b", re.IGNORECASE)
DAY = re.compile(r"\b((?:19|20)\d{2})[-/.](\d{1,2})[-/.](\d{1,2})\b")


def leap_seconds(time: np.ndarray | float) -> np.ndarray:
    """GPS time minus UTC, s, at times (N,) in seconds since 1970; 0 where a time is not known."""
    return AHEAD[np.searchsorted(STARTS, np.nan_to_num(time, nan=-np.inf), side="right")].astype(float)


def utc_of_gps(time: np.ndarray | float) -> np.ndarray:
    """Times (N,) in UTC of those in GPS time, both in seconds since 1970."""
    return time - leap_seconds(time - leap_seconds(time))


def start_of_week(week: float) -> float:
    """Begin of a GPS week, counted from 1980 on, in GPS time as seconds since 1970."""
    return EPOCH_S + WEEK_S * week


def week_of(time: float) -> int:
    """The GPS week of a time in GPS time, s since 1970."""
    return int((time - EPOCH_S) // WEEK_S)


def week_stated(notes: Sequence[str], seconds: np.ndarray) -> int | None:
    """The GPS week that lines above a table state, by its number or by a date on whose day of the week the seconds
    (N,) of the week lie; None where none is stated, or several are."""
    weeks = {int(match[1]) for note in notes for match in WEEK.finditer(note)}
    if not weeks:
        days = [day for note in notes for day in starmap(_day, DAY.findall(note)) if day is not None]
        known = seconds[np.isfinite(seconds)]
        weeks = {week_of(day) for day in days if known.size and _holds(day, float(known[0]))}
    return weeks.pop() if len(weeks) == 1 else None


def _day(year: str, month: str, day: str) -> float | None:
    try:
        return datetime.datetime(int(year), int(month), int(day), tzinfo=datetime.UTC).timestamp()
    except ValueError:
        return None


def _holds(day: float, second: float) -> bool:
    """Whether a second of the week lies on that day."""
    since = start_of_week(week_of(day)) + second - day
    return 0.0 <= since < 86400.0
