"""Times that are written in words of their own: dates with 年, 月 and 日, and durations such as `0 days 00:00:01.5`."""

from __future__ import annotations

import re
from dataclasses import replace

from .cell_texts import Texts
from .raw import RawColumn

SECOND = r"(?:(?P<s>\d{1,2}(?:[.,]\d+)?)[秒초])?"
CLOCK = (
    rf"(?:(?P<half>上午|下午|午前|午後|오전|오후)?\s*(?P<h>\d{{1,2}})[時时点시]\s*(?P<m>\d{{1,2}})[分분]\s*{SECOND})"
)
DATE = r"(?P<year>\d{4})[年년]\s*(?P<month>\d{1,2})[月월]\s*(?P<day>\d{1,2})[日일]"
FAR_EAST = re.compile(rf"(?:{DATE})?\s*{CLOCK}?")
DURATION = re.compile(r"(?P<sign>-)?(?P<days>\d+) days?(?:,?\s+\+?(?P<h>\d{1,2}):(?P<m>\d{2}):(?P<s>\d{2}(?:\.\d+)?))?")
AFTER_NOON = ("下午", "午後", "오후")


def with_plain_stamps(column: RawColumn) -> RawColumn:
    """The column with such times as those of ISO 8601, and such durations as seconds; others as they are."""
    first = next(iter(column.first(1)), "") if column.texts is not None else ""
    if not first or (first.isascii() and " day" not in first):
        return column
    if DURATION.fullmatch(first):
        return replace(column, values=Texts(map(_seconds, column.texts or ())), unit=column.unit or "s")
    return replace(column, values=Texts(map(_stamp, column.texts or ()))) if _stamp(first) != first else column


def _seconds(text: str) -> str:
    """The seconds of a duration; the text where it is none."""
    found = DURATION.fullmatch(text.strip())
    if found is None:
        return text
    clock = 3600.0 * int(found["h"] or 0) + 60.0 * int(found["m"] or 0) + float(found["s"] or 0.0)
    return f"{86400.0 * int(found['days']) * (-1.0 if found['sign'] else 1.0) + clock:.9g}"


def _stamp(text: str) -> str:
    """A date and time of day with dashes and colons; the text where it is none."""
    found = FAR_EAST.fullmatch(text.strip())
    if found is None or not (found["year"] or found["h"]):
        return text
    date = f"{found['year']}-{int(found['month']):02d}-{int(found['day']):02d}" if found["year"] else ""
    if not found["h"]:
        return date
    hour = int(found["h"]) % 12 + (12 if found["half"] in AFTER_NOON else 0) if found["half"] else int(found["h"])
    return f"{date} {hour:02d}:{found['m']:>02}:{(found['s'] or '00').zfill(2)}".strip()
