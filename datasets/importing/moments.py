"""Moments as texts: dates with times of day, and durations; GPS time."""

from __future__ import annotations

import datetime
import math
import re
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import starmap

import numpy as np

from .cells import Texts
from .raw import RawColumn

MOMENT = re.compile(
    r"(\d{4}[-/. ]\d{1,2}[-/. ]\d{1,2}|\d{8}|\d{1,2}[-/. ](?:\d{1,2}|[A-Za-z]{3,9})[-/. ](?:\d{4}|\d{2}))"
    r"(?:[T ,;_-]\s*(\d{1,2})(?::?(\d{2})(?::?(\d{2})(?:[.,:](\d+))?)?)?"
    r"\s*([AaPp][Mm])?\s*(?:Z|UTC|GMT|LT|([+-]\d{2}):?(\d{2})?(?: [A-Z]{3,4})?)?)?"
)
"""Date, hour, minute, second, decimals, half of the day, hours and minutes of the zone: 2024-05-03T08:00:00.1+02:00,
20240503 0800, 03.05.2024 08:00:00,1, 5/3/24 8:00 PM, 03-May-2024 08:00, 2024-05-03 08:00:00 +0200 CEST."""
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


def days_since_1970(year: np.ndarray, month: np.ndarray, day: np.ndarray) -> np.ndarray:
    """Days (N,) since 1970 of whole numbers (N,)."""
    months = (12 * (year - 1970) + month - 1).astype(np.int64).astype("datetime64[M]")
    return months.astype("datetime64[D]").astype(np.int64) + day - 1


# ---- Times in words of their own: dates with 年, 月 and 日, 22h01m30s, 8:00 p. m., and durations: `0 days 00:00:01.5`.

IN_WORDS = (
    r"(?P<half>上午|下午|午前|午後|오전|오후)?\s*(?P<h>\d{1,2})\s?[時时点시h]\s?(?P<m>\d{1,2})\s?(?:[分분'\u2032m]|mi?n)?\s?"
    r"(?:(?P<s>\d{1,2}(?:[.,]\d+)?)\s?(?:[秒초s\"\u2033]|sec)?)?"
)
DAY_IN_WORDS = r"(?P<year>\d{4})[年년]\s*(?P<month>\d{1,2})[月월]\s*(?P<day>\d{1,2})[日일]"
WORDED = re.compile(rf"(?:{DAY_IN_WORDS}|(?P<date>\d+[-/.]\d+[-/.]\d+))?\s*(?:{IN_WORDS})?", re.IGNORECASE)
HALF = re.compile(r"\s*([ap])\.\s?m\.?$", re.IGNORECASE)
"""Half of the day with points, as Spanish writes it."""
DURATION = re.compile(r"(?P<sign>-)?(?P<days>\d+) days?(?:,?\s+\+?(?P<h>\d{1,2}):(?P<m>\d{2}):(?P<s>\d{2}(?:\.\d+)?))?")
DOTTED = re.compile(r"\d{1,2}\.[0-5]\d\.([0-5]\d)")
"""A time of day with dots; or a date, of which the last part is the year."""
FEWEST_YEARS = 4
"""Years of a log from which on they are seconds."""
AFTER_NOON = ("下午", "午後", "오후")


def with_plain_stamps(column: RawColumn) -> RawColumn:
    """The column with such times as those of ISO 8601, and such durations as seconds; others as they are."""
    first = next(iter(column.first(1)), "") if column.texts is not None else ""
    # texts with dots are times of day where they are, as dates, of more years than a log lasts
    dotted = [DOTTED.fullmatch(text) for text in column.first(200)] if DOTTED.fullmatch(first) else []
    if dotted and all(dotted) and len({match[1] for match in dotted if match}) >= FEWEST_YEARS:
        return replace(column, values=Texts(text.strip().replace(".", ":") for text in column.texts or ()))
    if DURATION.fullmatch(first):
        return replace(column, values=Texts(map(_duration, column.texts or ())), unit=column.unit or "s")
    return replace(column, values=Texts(map(_stamp, column.texts or ()))) if _stamp(first) != first else column


def _duration(text: str) -> str:
    """The seconds of a duration; the text where it is none."""
    found = DURATION.fullmatch(text.strip())
    if found is None:
        return text
    clock = 3600.0 * int(found["h"] or 0) + 60.0 * int(found["m"] or 0) + float(found["s"] or 0.0)
    return f"{86400.0 * int(found['days']) * (-1.0 if found['sign'] else 1.0) + clock:.9g}"


def _stamp(text: str) -> str:
    """A date and time of day with dashes and colons; the text where it is none."""
    text = HALF.sub(r" \1m", text.strip())
    found = WORDED.fullmatch(text)
    if found is None or not (found["year"] or found["h"]):
        return text
    parts, date = found.groupdict(), found["date"] or ""
    date = "{year}-{month:>02}-{day:>02}".format_map(parts) if found["year"] else date
    if not found["h"]:
        return date
    hour = int(found["h"]) % 12 + (12 if found["half"] in AFTER_NOON else 0) if found["half"] else int(found["h"])
    return f"{date} {hour:02d}:{found['m']:>02}:{(found['s'] or '00').zfill(2)}".strip()


# ---- The time in a text that stands beside a sentence or an object, among names of channels and instruments.

STAMP_DATE = r"(?:\d{4}[-/.]\d\d[-/.]\d\d|\d\d?[-/.]\d\d?[-/.]\d{2,4}|\d\d?[- ][A-Za-z]{3}[- ]\d{2,4}|\d{8})"
STAMP_CLOCK = r"\d\d?:\d\d:\d\d(?:[.,]\d+)?(?:\s?(?:Z|[AaPp][Mm]|UTC|[+-]\d\d:?\d\d)\b)?"
STAMP = re.compile(rf"(?<![\w.])({STAMP_DATE})[T ,;_\t-]\s?({STAMP_CLOCK})")
STAMP_DAY_OF_YEAR = re.compile(r"(?<![\d:])(\d{4}):(\d{3}):(\d\d:\d\d:\d\d(?:\.\d+)?)")
OTHER_STAMPS = (
    re.compile(rf"(?<![\d:]){STAMP_CLOCK}"),
    re.compile(r"(?<![\w.])\d{9,19}(?:\.\d+)?(?![\w.])"),
    re.compile(r"(?<![\w.])\d+\.\d+(?![\w.])"),
)
"""A time of day; seconds, or parts of them, since 1970; seconds."""


def time_in(text: str) -> tuple[str, str]:
    """(the time in a text, the rest of it); the time is '' where there is none.

    A day of the year (`2026:073:10:00:00`) becomes a date.
    """
    if found := STAMP.search(text):
        return f"{found[1]} {found[2]}", _without(text, found)
    found = STAMP_DAY_OF_YEAR.search(text)
    if found and 0 < int(found[2]) <= 366 and int(found[1]) > 0:
        day = datetime.date(int(found[1]), 1, 1) + datetime.timedelta(days=int(found[2]) - 1)
        return f"{day} {found[3]}", _without(text, found)
    found = next((match for form in OTHER_STAMPS if (match := form.search(text))), None)
    return (found[0], _without(text, found)) if found else ("", text)


def _without(text: str, found: re.Match[str]) -> str:
    return f"{text[: found.start()]} {text[found.end() :]}"


def without_zone(epoch: np.ndarray) -> tuple[str, ...]:
    """Seconds (N,) since 1970 of a clock whose zone is not stated as texts of date and time."""
    known = np.where(np.isfinite(epoch) & (np.abs(epoch) < 1e11), epoch, 0.0)
    texts = np.datetime_as_string(np.round(1e6 * known).astype(np.int64).astype("datetime64[us]"))
    return tuple(np.where(known == epoch, texts, "").tolist())


# ---- GPS time: weeks and seconds of them, and the leap seconds by which it is ahead of UTC.

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
STATED_DAY = re.compile(r"\b((?:19|20)\d{2})[-/.](\d{1,2})[-/.](\d{1,2})\b")


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
        days = [day for note in notes for day in starmap(_day, STATED_DAY.findall(note)) if day is not None]
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
