"""The time in a text that stands beside a sentence or an object, among names of channels and instruments."""

from __future__ import annotations

import datetime
import re

DATE = r"(?:\d{4}[-/.]\d\d[-/.]\d\d|\d\d?[-/.]\d\d?[-/.]\d{2,4}|\d\d?[- ][A-Za-z]{3}[- ]\d{2,4}|\d{8})"
CLOCK = r"\d\d?:\d\d:\d\d(?:[.,]\d+)?(?:\s?(?:Z|[AaPp][Mm]|UTC|[+-]\d\d:?\d\d)\b)?"
DATED = re.compile(rf"(?<![\w.])({DATE})[T ,;_\t-]\s?({CLOCK})")
DAY_OF_YEAR = re.compile(r"(?<![\d:])(\d{4}):(\d{3}):(\d\d:\d\d:\d\d(?:\.\d+)?)")
OTHERS = (
    re.compile(rf"(?<![\d:]){CLOCK}"),
    re.compile(r"(?<![\w.])\d{9,19}(?:\.\d+)?(?![\w.])"),
    re.compile(r"(?<![\w.])\d+\.\d+(?![\w.])"),
)
"""A time of day; seconds, or parts of them, since 1970; seconds."""


def time_in(text: str) -> tuple[str, str]:
    """(the time in a text, the rest of it); the time is '' where there is none.

    A day of the year (`2026:073:10:00:00`) becomes a date.
    """
    if found := DATED.search(text):
        return f"{found[1]} {found[2]}", _without(text, found)
    found = DAY_OF_YEAR.search(text)
    if found and 0 < int(found[2]) <= 366 and int(found[1]) > 0:
        day = datetime.date(int(found[1]), 1, 1) + datetime.timedelta(days=int(found[2]) - 1)
        return f"{day} {found[3]}", _without(text, found)
    found = next((match for form in OTHERS if (match := form.search(text))), None)
    return (found[0], _without(text, found)) if found else ("", text)


def _without(text: str, found: re.Match[str]) -> str:
    return f"{text[: found.start()]} {text[found.end() :]}"
