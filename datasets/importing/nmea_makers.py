"""Sentences of one make among NMEA 0183: iXblue, Seatex, Furuno, Trimble, RDI, and the ASCII logs of NovAtel."""

from __future__ import annotations

import datetime
import re
import zlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

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


Read = Callable[[Any], Any]


class Field(NamedTuple):
    """A column of a sentence: its name, the quantity that it is ('' : the name tells), unit, and how it is read."""

    name: str
    quantity: str
    unit: str
    read: Read


def number(place: int) -> Read:
    """The number in a field."""
    return lambda m: m.cells[place] if place < len(m.cells) else None


def lettered(place: int, negative: str) -> Read:
    """The number in a field, negative where the field behind it is that letter."""

    def read(m: SentenceParts) -> object:
        value, letter = number(place)(m), number(place + 1)(m)
        return None if not value or not letter else float(str(value)) * (-1.0 if letter == negative else 1.0)

    return read


def _heading(place: int) -> tuple[Field, ...]:
    return (Field("true heading", "heading", "deg", number(place)),)


def _attitude(heading: int, roll: int) -> tuple[Field, ...]:
    return *_heading(heading), Field("roll", "roll", "deg", number(roll))


def _position(latitude: int) -> tuple[Field, ...]:
    return (
        Field("latitude", "latitude", "deg", number(latitude)),
        Field("longitude", "longitude", "deg", number(latitude + 1)),
    )


def _velocity(north: int) -> tuple[Field, ...]:
    return (
        Field("velocity north", "velocity_north", "m/s", number(north)),
        Field("velocity east", "velocity_east", "m/s", number(north + 1)),
    )


MAKERS: dict[str, tuple[Field, ...]] = {
    # iXblue: Octans, Phins.  Roll T: port side up, B: port side down.
    "PHTRO": (Field("roll", "roll", "deg", lettered(2, "B")),),
    "PHSPD": (Field("surge speed", "surge", "m/s", number(0)), Field("sway speed", "not used", "m/s", number(1))),
    "PIXSEPOSITI": _position(0),
    "PIXSESPEED_": (
        Field("velocity east", "velocity_east", "m/s", number(0)),
        Field("velocity north", "velocity_north", "m/s", number(1)),
    ),
    "PSXN23": _attitude(2, 0),  # Kongsberg Seatex: roll positive with port up
    "PFECGPatt": _heading(0),  # Furuno
    "PRDID": _heading(2),  # RDI: pitch, roll, heading
    "PSATHPR": _heading(1),  # Hemisphere: time, heading, pitch, roll
    "PTNLAVR": _heading(1),  # Trimble: time, yaw, Yaw, tilt
}
"""Address, with the kind of those that have several -> its entries."""
_INS = (*_position(2), *_velocity(5), *_attitude(10, 8))
_FIX, _TRACK = _position(2), (
    Field("speed over ground", "speed_over_ground", "m/s", number(4)),
    Field("course over ground", "course_over_ground", "deg", number(5)),
)  # fmt: skip
_ANTENNAS = _heading(3)
LOGS: dict[str, tuple[Field, ...]] = {
    "INSPVA": _INS, "INSPVAS": _INS, "INSPVAX": (*_position(2), *_velocity(6), *_attitude(11, 9)),
    "INSATT": _attitude(4, 2), "INSATTS": _attitude(4, 2), "INSATTX": _attitude(4, 2),
    "INSVEL": _velocity(2), "INSVELS": _velocity(2), "INSVELX": _velocity(2),
    "INSPOS": _position(2), "INSPOSS": _position(2), "INSPOSX": _position(2),
    "INSSPD": (Field("course over ground", "course_over_ground", "deg", number(2)),
               Field("speed over ground", "speed_over_ground", "m/s", number(3))),
    **dict.fromkeys(("BESTPOS", "BESTGNSSPOS", "GPSPOS", "RTKPOS", "PSRPOS", "PPPPOS", "BESTNAV"), _FIX),
    **dict.fromkeys(("BESTVEL", "BESTGNSSVEL", "GPSVEL", "RTKVEL", "PSRVEL", "PPPVEL"), _TRACK),
    "BESTUTM": (Field("northing", "north", "m", number(4)), Field("easting", "east", "m", number(5))),
    **dict.fromkeys(("HEADING", "HEADING2", "DUALANTENNAHEADING", "UNIHEADING"), _ANTENNAS),
}  # fmt: skip
"""Log of NovAtel without the A at its end -> its entries.  Azimuths count clockwise, roll to starboard."""


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
