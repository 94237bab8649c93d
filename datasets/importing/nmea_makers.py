"""Sentences of one make among NMEA 0183: iXblue, Seatex, Furuno, Trimble, RDI, and the ASCII logs of NovAtel."""

from __future__ import annotations

import datetime
import re
import zlib
from dataclasses import dataclass, replace

from .gps_time import start_of_week, utc_of_gps

SUBTYPED = ("PSXN", "PIXSE", "PSAT", "PTNL", "PFEC", "PSTM", "PUBX")
"""Addresses whose first field says which sentence it is."""
NOVATEL = re.compile(r"[#%][A-Z][A-Z0-9]{3,24}A,[^;#%$]{3,200};[^*#%$]{1,1000}\*[0-9a-fA-F]{8}")
"""A log of NovAtel, and of receivers that write the same form."""
NO_SOLUTION = ("INS_INACTIVE", "INS_ALIGNING", "INSUFFICIENT_OBS", "NO_CONVERGENCE", "COLD_START", "NONE", "PENDING")
"""States, or kinds of a position, in which a log of NovAtel holds no measurement."""


@dataclass(frozen=True)
class SentenceParts:
    """A sentence as its fields; `time` and `date` where it states them."""

    msgID: str
    cells: tuple[str, ...]
    time: datetime.time | None = None
    date: datetime.date | None = None


def maker_kind(address: str, body: str) -> str:
    """The kind of a sentence of one make: its address, with its first field where that says which one it is."""
    subtype = body.split(",", 2)[1] if address in SUBTYPED and "," in body else ""
    return f"{address}{subtype}"


def maker_message(kind: str, body: str) -> SentenceParts:
    """The fields of a sentence of one make, behind its address and kind.

    Raises
    ------
    IndexError : it has none.
    """
    cells = body.split(",")
    cells = cells[2 if kind != cells[0] else 1 :]
    if not any(cells):
        raise IndexError(kind)
    return SentenceParts(kind, tuple(cells))


def novatel_message(sentence: str) -> SentenceParts | None:
    """The fields of a log of NovAtel with its time; None where its header is not one."""
    head, _, data = sentence[1:].partition("*")[0].partition(";")
    header, cells = head.split(","), data.split(",")
    place = (5, 6) if sentence[0] == "#" else (1, 2)
    try:
        week, seconds = (float(header[i]) for i in place)
    except (ValueError, IndexError):
        return None
    timed = 0.0 < week < 5000.0 and 0.0 <= seconds <= 604800.0 and header[4:5] != ["UNKNOWN"]
    lost = any(cell in NO_SOLUTION for cell in (*cells[:2], *cells[-1:]))
    parts = SentenceParts("lost" if lost else novatel_kind(sentence), tuple(cells))
    if not timed:
        return parts
    moment = datetime.datetime.fromtimestamp(float(utc_of_gps(start_of_week(week) + seconds)), datetime.UTC)
    return replace(parts, time=moment.time(), date=moment.date())


def novatel_kind(sentence: str) -> str:
    """The name of a log of NovAtel without the A of the ASCII form."""
    return sentence[1:].split(",", 1)[0].removesuffix("A")


def novatel_sound(sentence: str) -> bool:
    """Whether the checksum of a log of NovAtel is right: CRC-32 that begins at zero and is not turned round."""
    body, _, said = sentence[1:].rpartition("*")
    return zlib.crc32(body.encode(errors="replace"), 0xFFFFFFFF) ^ 0xFFFFFFFF == int(said, 16)
