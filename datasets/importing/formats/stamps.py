"""Times as formats of one make state them: GPS weeks, dates without a zone."""

from __future__ import annotations

import numpy as np

WEEK_S = 604800.0
GPS_EPOCH = 315964800.0
"""Seconds since 1970 of the first GPS week, 1980-01-06."""
LEAPS = (1981.5, 1982.5, 1983.5, 1985.5, 1988.0, 1990.0, 1991.0, 1992.5, 1993.5, 1994.5, 1996.0, 1997.5, 1999.0, 2006.0,
         2009.0, 2012.5, 2015.5, 2017.0)  # fmt: skip
"""Years at whose begin or middle a leap second was added since the GPS epoch (IERS bulletin C)."""


def utc_of_gps(week: np.ndarray | float, seconds: np.ndarray | float) -> np.ndarray:
    """Seconds since 1970 (UTC) of GPS weeks and seconds of the week, (N,) each."""
    epoch = GPS_EPOCH + WEEK_S * np.asarray(week, dtype=float) + np.asarray(seconds, dtype=float)
    years = np.array([_moment(year) for year in LEAPS])
    return epoch - np.searchsorted(years, epoch, side="right")


def _moment(year: float) -> float:
    """Seconds since 1970 of the begin of a year or of its July."""
    month = "07" if year % 1.0 else "01"
    return float(np.datetime64(f"{int(year)}-{month}-01", "s").astype(np.int64))


def without_zone(epoch: np.ndarray) -> tuple[str, ...]:
    """Seconds (N,) since 1970 of a clock whose zone is not stated as texts of date and time."""
    known = np.where(np.isfinite(epoch) & (np.abs(epoch) < 1e11), epoch, 0.0)
    texts = np.datetime_as_string(np.round(1e6 * known).astype(np.int64).astype("datetime64[us]"))
    return tuple(np.where(known == epoch, texts, "").tolist())
