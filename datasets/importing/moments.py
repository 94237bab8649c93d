"""Moments: dates with times of day in one text."""

from __future__ import annotations

import datetime
import math
import re
from functools import lru_cache

MOMENT = re.compile(
    r"(\d{4}[-/. ]\d{1,2}[-/. ]\d{1,2}|\d{8}|\d{1,2}[-/. ](?:\d{1,2}|[A-Za-z]{3,9})[-/. ](?:\d{4}|\d{2}))"
    r"(?:[T ,;_-]\s*(\d{1,2})(?::?(\d{2})(?::?(\d{2})(?:[.,:](\d+))?)?)?"
    r"\s*([AaPp][Mm])?\s*(?:Z|UTC|GMT|LT|([+-]\d{2}):?(\d{2})?)?)?"
)
"""Date, hour, minute, second, decimals, half of the day, hours and minutes of the zone: 2024-05-03T08:00:00.1+02:00,
20240503 0800, 03.05.2024 08:00:00,1, 5/3/24 8:00 PM, 03-May-2024 08:00."""
COMPACT = re.compile(r"^(\d{8})(\d{6}(?:\.\d+)?)$")
"""Date and time of day of fourteen digits."""
MONTHS = "jan feb mar apr may jun jul aug sep oct nov dec"
SEPARATORS = re.compile("[-/. ]")
EPOCH, DAY = datetime.date(1970, 1, 1).toordinal(), 86400
PIVOT = 69
"""Least year of two digits of the twentieth century, as POSIX has it."""


def moment(text: str, month_first: bool = False) -> float:
    """Seconds since 1970 of a moment, in UTC unless the text states a shift of its zone; nan where the text is none."""
    found = MOMENT.fullmatch(text) or MOMENT.fullmatch(COMPACT.sub(r"\1 \2", text))
    if found is None:
        return math.nan
    date, hour, minute, second, decimals, half, zone, zone_minutes = found.groups("0")
    days, full, ahead = _days(date, month_first), int(hour), 60 * int(zone)
    if half != "0":
        full = full % 12 + (12 if half[0] in "Pp" else 0)
    if math.isnan(days) or full > 23 or int(minute) > 59 or int(second) > 60:
        return math.nan
    ahead += -int(zone_minutes) if zone[0] == "-" else int(zone_minutes)
    return days * DAY + 3600 * full + 60 * (int(minute) - ahead) + int(second) + float(f"0.{decimals}")


@lru_cache(maxsize=64)
def _days(date: str, month_first: bool) -> float:
    """Days since 1970 of a date that begins or ends with its year, or of eight digits; nan where it is none."""
    compact = len(date) == 8 and date.isdigit()
    year, month, day = (date[:4], date[4:6], date[6:]) if compact else SEPARATORS.split(date)
    if len(year) < 3:
        year, day = day, year
        if month_first and month.isdigit():
            month, day = day, month
    number = int(month) if month.isdigit() else MONTHS.find(month[:3].lower()) // 4 + 1
    full = int(year) + (0 if len(year) > 2 else 1900 if int(year) >= PIVOT else 2000)
    try:
        return float(datetime.date(full, number, int(day)).toordinal() - EPOCH)
    except ValueError:
        return math.nan
