"""NMEA 0183 logs: sentences by kind and talker, read by pynmeagps."""

from __future__ import annotations

import datetime
import re
from collections import Counter, defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from pathlib import Path
from typing import Any

import numpy as np

from ...models.errors import BadInput
from .raw import RawColumn, RawTable, Rejected

SENTENCE = re.compile(r"[$!](?:[A-Z]{2}[A-Z]{3}|P[A-Z]{3,4})[A-Z0-9]*,[^$!\\\"]*")
SUM = re.compile(r"[$!]([^*]*)\*([0-9A-Fa-f]{2})")
CELLS = re.compile(
    r"^(?P<stamp>.*?)[,;\t]?\s*\"?(?P<talker>[A-Z]{2})\"?[,;\t ]?\s*\"?(?P<kind>[A-Z]{3})\"?[,;\t](?P<data>.*)$"
)
TAG = re.compile(r"\\([^\\]*)\\")
TAG_TIME = re.compile(r"(?:^|,)c:(\d+(?:\.\d+)?)")
Read = Callable[[Any], Any]


@dataclass(frozen=True)
class Field:
    """A column of a sentence: its name, the quantity that it is ('' : the name tells), unit, and how it is read."""

    name: str
    quantity: str
    unit: str
    read: Read


def _plain(name: str) -> Read:
    return lambda m: getattr(m, name)


def _if(name: str, status: str, good: str = "A") -> Read:
    """A field that counts where its status does."""
    return lambda m: getattr(m, name) if getattr(m, status, "") in (*good, "") else None


def _west(name: str, side: str) -> Read:
    """A field with its letter of direction as a number that is positive to east."""

    def read(m: Any) -> Any:
        number = getattr(m, name)
        return None if number in (None, "") else float(number) * (-1.0 if getattr(m, side) == "W" else 1.0)

    return read


def _revolutions(source: str) -> Read:
    return lambda m: m.rpm if m.source == source and m.status in ("A", "") else None


def _wind(name: str) -> Read:
    return lambda m: getattr(m, name) if m.reference == "T" and m.status in ("A", "") else None


def _wind_speed(m: Any) -> Any:
    factor = {"N": 1852.0 / 3600.0, "K": 1.0 / 3.6, "M": 1.0}.get(m.speedu)
    return None if m.reference != "T" or m.status not in ("A", "") or factor is None else float(m.speed) * factor


NOT = "not used"
POSITION = (Field("latitude", "latitude", "deg", _plain("lat")), Field("longitude", "longitude", "deg", _plain("lon")))
FIX = (
    Field("latitude", "latitude", "deg", lambda m: m.lat if m.quality else None),
    Field("longitude", "longitude", "deg", lambda m: m.lon if m.quality else None),
)
KINDS: dict[str, tuple[Field, ...]] = {
    "RMC": (
        *POSITION,
        Field("speed over ground", "speed_over_ground", "kn", _plain("spd")),
        Field("course over ground", "course_over_ground", "deg", _plain("cog")),
        Field("magnetic variation", "magnetic_variation", "deg", _west("mv", "mvEW")),
    ),
    "GGA": FIX,
    "GLL": POSITION,
    "GNS": POSITION,
    "VTG": (
        Field("course over ground", "course_over_ground", "deg", _plain("cogt")),
        Field("speed over ground", "speed_over_ground", "kn", _plain("sogn")),
    ),
    "HDT": (Field("true heading", "heading", "deg", _plain("headingT")),),
    "THS": (Field("true heading", "heading", "deg", _if("headt", "mi", "AE")),),
    "HDM": (Field("magnetic heading", "heading_magnetic", "deg", _plain("headingM")),),
    "HDG": (
        Field("magnetic heading", "heading_magnetic", "deg", _plain("headingM")),
        Field("magnetic deviation", "magnetic_deviation", "deg", _west("deviation", "deviationEW")),
        Field("magnetic variation", "magnetic_variation", "deg", _west("variation", "variationEW")),
    ),
    "ROT": (Field("rate of turn", "yaw_rate", "deg/min", _if("rot", "valid")),),
    "RSA": (
        Field("rudder, starboard or single", "rudder", "deg", _if("stbdangle", "stbdstatus")),
        Field("rudder, port", "rudder", "deg", _if("portangle", "portstatus")),
    ),
    "RPM": (
        Field("shaft revolutions", "propeller", "rpm", _revolutions("S")),
        Field("engine revolutions", NOT, "rpm", _revolutions("E")),
        Field("propeller pitch", NOT, "%", _plain("pitch")),
    ),
    "VHW": (
        Field("true heading", "heading", "deg", _plain("hdgT")),
        Field("magnetic heading", "heading_magnetic", "deg", _plain("hdgM")),
        Field("speed through water", "speed_through_water", "kn", _plain("spdN")),
    ),
    "VBW": (
        Field("longitudinal ground speed", "surge", "kn", _if("longgroundspd", "groundspdstatus")),
        Field("transverse ground speed", "sway", "kn", _if("transgroundspd", "groundspdstatus")),
        Field("longitudinal water speed", NOT, "kn", _if("longwaterspd", "waterspdstatus")),
        Field("transverse water speed", NOT, "kn", _if("transwaterspd", "waterspdstatus")),
    ),
    "MWD": (
        Field("true wind direction", "wind_direction", "deg", _plain("dirT")),
        Field("wind speed", "wind_speed", "m/s", _plain("speedM")),
    ),
    "MWV": (
        Field("true wind speed", "wind_speed", "m/s", _wind_speed),
        Field("true wind angle from the bow", NOT, "deg", _wind("angle")),
    ),
    "PASHR": (Field("true heading", "heading", "deg", _plain("trueHdg")), Field("roll", "", "deg", _plain("roll"))),
    "ZDA": (),
}  # fmt: skip
"""Sentence -> its columns.  The standard states units and signs: turns, rudder and sway positive to starboard."""
TIMED, DATED = ("RMC", "GGA", "GLL", "GNS", "ZDA", "PASHR"), 1e8
"""Sentences that state the time, and seconds above which a time holds a date."""
VOID = {"RMC": "status", "GLL": "status"}


@dataclass(frozen=True)
class Parsed:
    """A sentence: line, stamp before it, kind, talker, and its fields."""

    line: int
    stamp: str
    kind: str
    talker: str
    message: Any

    @property
    def group(self) -> str:
        """Kind with its talker."""
        return self.kind if self.kind == "PASHR" else self.talker + self.kind


def looks_like_nmea(text: str) -> bool:
    """Whether most of the first lines hold a sentence."""
    lines = [line for line in text[:20000].splitlines()[:200] if line.strip()]
    return len(lines) > 0 and sum(_sentence(line) is not None for line in lines) > 0.5 * len(lines)


def _sentence(line: str) -> tuple[str, str] | None:
    """(stamp beside the sentence, the sentence) of a line; None where it holds none."""
    found = SENTENCE.search(line)
    if found:
        return _stamp(line[: found.start()], line[found.end() :]), found[0].strip().rstrip("\"'")
    cells = CELLS.match(line)
    if cells and cells["kind"] in KINDS:
        data = re.sub(r"[;\t]", ",", cells["data"].strip().strip('"'))
        return _stamp(cells["stamp"], ""), f"${cells['talker']}{cells['kind']},{data}"
    return None


def _stamp(before: str, behind: str) -> str:
    tag = TAG.search(before)
    time = TAG_TIME.search(tag[1].split("*")[0]) if tag else None
    if time:
        return time[1]
    text = TAG.sub("", before).strip(" ,;\t\"'[](){}<>|:")
    return text or behind.strip(" ,;\t\"'[]")


def read_nmea(text: str, path: Path) -> list[RawTable]:
    """One table for every kind of sentence of every talker, timed by stamps beside the sentences or by RMC, GGA, ZDA.

    Raises
    ------
    BadInput : no known sentence, or no time in the log.
    """
    parsed, faults, others = _parsed(text)
    if not any(KINDS[p.kind] for p in parsed):
        raise BadInput("no NMEA sentence that can be used", file=path, hint=f"read are {', '.join(KINDS)}")
    stamped = sum(bool(p.stamp) for p in parsed) > 0.9 * len(parsed)
    times = [p.stamp for p in parsed] if stamped else _times(parsed, path)
    done = "timed by the stamps beside the sentences" if stamped else (
        "timed by RMC, GGA, GLL or ZDA; other sentences evenly between, to about one of their periods"
    )  # fmt: skip
    skipped = ", ".join(f"{kind} ({n})" for kind, n in others.most_common())
    notes = ("NMEA 0183", done, *((f"sentences not used: {skipped}",) if skipped else ()))
    groups: dict[str, list[int]] = defaultdict(list)
    for i, p in enumerate(parsed):
        groups[p.group].append(i)
    tables = [_table(path, kind, own, parsed, times) for kind, own in groups.items() if KINDS[parsed[own[0]].kind]]
    total = len(parsed) + len(faults) + others.total()
    return [replace(tables[0], faults=tuple(faults), done=(*tables[0].done, *notes), lines=total), *tables[1:]]


def _parsed(text: str) -> tuple[list[Parsed], list[Rejected], Counter[str]]:
    """Sentences, lines that hold no sound one, and kinds that are not used; AIS is only checked."""
    good: list[Parsed] = []
    faults: list[Rejected] = []
    others: Counter[str] = Counter()
    for number, line in enumerate(text.splitlines(), start=1):
        found = _sentence(line)
        if found is None:
            faults += [(number, "no NMEA sentence", line)] if line.strip() and not line.lstrip().startswith("#") else []
            continue
        stamp, sentence = found
        if not _sound(sentence):
            faults.append((number, "the checksum of the sentence is wrong", line))
            continue
        kind = _kind(sentence)
        if kind not in KINDS:
            others[kind] += 1
            continue
        message = _message(sentence)
        if message is None:
            faults.append((number, "the form of the sentence is wrong", line))
        elif kind in VOID and getattr(message, VOID[kind], "A") == "V":
            others[f"{kind} with status V"] += 1
        else:
            good.append(Parsed(number, stamp, kind, sentence[1:3], message))
    return good, faults, others


def _kind(sentence: str) -> str:
    address = sentence[1:].split(",", 1)[0]
    return address if address.startswith("P") else address[2:]


def _sound(sentence: str) -> bool:
    """Whether the checksum is right, or there is none."""
    match = SUM.match(sentence)
    if match is None:
        return "*" not in sentence
    return reduce(lambda a, b: a ^ b, match[1].encode(errors="replace"), 0) == int(match[2], 16)


def _message(sentence: str) -> Any:
    from pynmeagps import NMEAMessageError, NMEAParseError, NMEAReader, NMEATypeError

    body = sentence[1:].split("*")[0]
    check = reduce(lambda a, b: a ^ b, body.encode(errors="replace"), 0)
    try:
        return NMEAReader.parse(f"${body}*{check:02X}\r\n".encode(), validate=1)
    except (
        NMEAMessageError,
        NMEAParseError,
        NMEATypeError,
        ValueError,
        TypeError,
        IndexError,
        KeyError,
        AttributeError,
    ):
        return None


# ------------------------------------------------------------------------------------------------ times


def _stamps(parsed: Sequence[Parsed], path: Path) -> tuple[np.ndarray, np.ndarray]:
    """(indices of the messages that state a new time, their epoch seconds; seconds of the first day without a date)."""
    known: dict[int, float] = {}
    day, last = 0.0, -1.0
    for i, p in enumerate(parsed):
        clock = getattr(p.message, "utctime" if p.kind == "PASHR" else "time", None)
        if not isinstance(clock, datetime.time):
            continue
        seconds = clock.hour * 3600.0 + clock.minute * 60.0 + clock.second + clock.microsecond * 1e-6
        date = _date(p)
        if date is not None:
            day = datetime.datetime(date.year, date.month, date.day, tzinfo=datetime.UTC).timestamp()
        elif seconds < last - 43200.0:
            day += 86400.0
        last = seconds
        known[i] = day + seconds
    dated = {i: value for i, value in known.items() if value > DATED}
    index = np.array(list(dated or known), dtype=int)
    value = np.array(list((dated or known).values()))
    new = (
        np.concatenate([[True], np.diff(np.maximum.accumulate(value)) > 0.0]) if value.size else np.zeros(0, dtype=bool)
    )
    if new.sum() < 2:
        hint = "log RMC or GGA as well, or put a time stamp before every sentence"
        raise BadInput("the sentences have no time", file=path, hint=hint)
    return index[new], value[new]


def _date(p: Parsed) -> datetime.date | None:
    if p.kind == "ZDA":
        try:
            return datetime.date(int(p.message.year), int(p.message.month), int(p.message.day))
        except (TypeError, ValueError):
            return None
    date = getattr(p.message, "date", None)
    return date if isinstance(date, datetime.date) else None


def _times(parsed: Sequence[Parsed], path: Path) -> np.ndarray:
    """(N,) seconds: sentences of a kind that follow a stated time are spread evenly until the next stated time."""
    index, value = _stamps(parsed, path)
    usual = float(np.median(np.diff(value)))
    kinds = np.array([p.group for p in parsed])
    timed = np.array([p.kind in TIMED for p in parsed])
    out = np.full(len(parsed), np.nan)
    edges = [*index.tolist(), len(parsed)]
    for start, stop, at, after in zip(edges[:-1], edges[1:], value, [*value[1:], value[-1] + usual], strict=True):
        after = min(after, at + 3.0 * usual)
        for kind in np.unique(kinds[start:stop]):
            own = start + np.flatnonzero(kinds[start:stop] == kind)
            out[own] = at if timed[own[0]] else at + np.arange(own.size) / own.size * (after - at)
    return out


def _table(path: Path, group: str, own: list[int], parsed: Sequence[Parsed], times: Any) -> RawTable:
    stamps = [times[i] for i in own]
    values: Any = tuple(stamps) if isinstance(stamps[0], str) else np.array(stamps, dtype=float)
    first = parsed[own[0]]
    by = f"NMEA 0183 states it: {first.kind}" + (f" of talker {first.talker}" if first.kind != "PASHR" else "")
    columns = [RawColumn("time", "", values, "" if isinstance(stamps[0], str) else "time", by)]
    for entry in KINDS[first.kind]:
        numbers = np.array([_number(entry.read, parsed[i].message) for i in own])
        if np.isfinite(numbers).any():
            side = "starboard" if entry.quantity == "rudder" else ""
            columns.append(RawColumn(entry.name, entry.unit, numbers, entry.quantity, by, side=side))
    rows = np.array([parsed[i].line for i in own])
    return RawTable(path.name, tuple(columns), rows, group, path.name, done=(f"{len(own)} sentences {group}",))


def _number(read: Read, message: Any) -> float:
    try:
        value = read(message)
        return float(value) if value not in (None, "") else np.nan
    except (TypeError, ValueError, AttributeError):
        return np.nan
