"""NMEA 0183 logs: sentences with rudder, heading, rate of turn, speed, course and position, by pynmea2."""

from __future__ import annotations

import datetime
import re
from collections import Counter, defaultdict
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ...models.errors import BadInput
from .raw import RawColumn, RawTable

SENTENCE = re.compile(r"[$!][A-Z]{2,5}[A-Z0-9]*,[^$!]*")
Fields = dict[str, tuple[str, Callable[[Any], Any]]]


def _signed(value: str, side: str, negative: str) -> Callable[[Any], Any]:
    """A field with its letter of direction as a signed number."""

    def read(m: Any) -> Any:
        number = getattr(m, value)
        return None if number in (None, "") else float(number) * (-1.0 if getattr(m, side) == negative else 1.0)

    return read


def _plain(name: str) -> Callable[[Any], Any]:
    return lambda m: getattr(m, name)


def _position(name: str) -> Callable[[Any], Any]:
    return lambda m: getattr(m, name) if getattr(m, name[:3]) else None


KINDS: dict[str, Fields] = {
    "RMC": {
        "latitude": ("deg", _position("latitude")),
        "longitude": ("deg", _position("longitude")),
        "speed over ground": ("kn", _plain("spd_over_grnd")),
        "course over ground": ("deg", _plain("true_course")),
        "magnetic variation": ("deg", _signed("mag_variation", "mag_var_dir", "W")),
    },
    "GGA": {"latitude": ("deg", _position("latitude")), "longitude": ("deg", _position("longitude"))},
    "VTG": {
        "course over ground": ("deg", _plain("true_track")),
        "speed over ground": ("kn", _plain("spd_over_grnd_kts")),
    },
    "HDT": {"true heading": ("deg", _plain("heading"))},
    "HDG": {
        "magnetic heading": ("deg", _plain("heading")),
        "magnetic deviation": ("deg", _signed("deviation", "dev_dir", "W")),
        "magnetic variation": ("deg", _signed("variation", "var_dir", "W")),
    },
    "ROT": {"rate of turn": ("deg/min", _plain("rate_of_turn"))},
    "RSA": {"rudder angle": ("deg", _plain("rsa_starboard"))},
}
"""Sentence -> column -> (unit, how it is read)."""
TIMED, DATED = ("RMC", "GGA"), 1e8
"""Sentences that state the time, and seconds above which a time holds a date."""


def looks_like_nmea(text: str) -> bool:
    """Whether most of the first lines hold a sentence."""
    lines = [line for line in text[:20000].splitlines()[:200] if line.strip()]
    return len(lines) > 0 and sum(bool(SENTENCE.search(line)) for line in lines) > 0.5 * len(lines)


def read_nmea(text: str, path: Path) -> list[RawTable]:
    """One table for every kind of sentence, timed by stamps before the sentences or by the times in RMC and GGA.

    Raises
    ------
    BadInput : no known sentence, or no time in the log.
    """
    parsed, faults, others = _parsed(text)
    if not parsed:
        raise BadInput("no NMEA sentence that can be used", file=path, hint=f"read are {', '.join(KINDS)}")
    stamped = sum(bool(stamp) for _, stamp, _ in parsed) > 0.9 * len(parsed)
    times = [stamp for _, stamp, _ in parsed] if stamped else _times(parsed, path)
    done = (
        "timed by the stamps before the sentences"
        if stamped
        else "timed by RMC and GGA; other sentences evenly between, to about one of their periods"
    )
    skipped = ", ".join(f"{kind} ({n})" for kind, n in others.most_common())
    notes = ("NMEA 0183", done, *((f"sentences not used: {skipped}",) if skipped else ()))
    groups: dict[str, list[int]] = defaultdict(list)
    for i, (_, _, message) in enumerate(parsed):
        groups[message.sentence_type].append(i)
    tables = [_table(path, kind, own, parsed, times) for kind, own in groups.items()]
    first = tables[0]
    return [replace(first, faults=tuple(faults), done=(*first.done, *notes)), *tables[1:]]


def _parsed(text: str) -> tuple[list[tuple[int, str, Any]], list[tuple[int, str]], Counter[str]]:
    """[(line, stamp before the sentence, message)], lines that are no sound sentence, sentences that are not used."""
    import pynmea2

    good: list[tuple[int, str, Any]] = []
    faults: list[tuple[int, str]] = []
    others: Counter[str] = Counter()
    for number, line in enumerate(text.splitlines(), start=1):
        found = SENTENCE.search(line)
        if not found:
            faults += [(number, "no NMEA sentence")] if line.strip() and not line.lstrip().startswith("#") else []
            continue
        try:
            message = pynmea2.parse(found[0].strip(), check=False)
        except (pynmea2.ParseError, ValueError, IndexError):
            faults.append((number, "checksum or form of the sentence is wrong"))
            continue
        kind = getattr(message, "sentence_type", "?")
        if kind in KINDS and getattr(message, "status", "A") != "V":
            good.append((number, line[: found.start()].strip(" ,;\t"), message))
        else:
            others[kind] += 1
    return good, faults, others


def _stamps(parsed: list[tuple[int, str, Any]], path: Path) -> tuple[np.ndarray, np.ndarray]:
    """(indices of the messages that state a new time, their epoch seconds; seconds of the first day without a date)."""
    known: dict[int, float] = {}
    day, last = 0.0, -1.0
    for i, (_, _, message) in enumerate(parsed):
        clock = getattr(message, "timestamp", None)
        if not isinstance(clock, datetime.time):
            continue
        seconds = clock.hour * 3600.0 + clock.minute * 60.0 + clock.second + clock.microsecond * 1e-6
        date = getattr(message, "datestamp", None)
        if isinstance(date, datetime.date):
            day = datetime.datetime(date.year, date.month, date.day, tzinfo=datetime.UTC).timestamp()
        elif seconds < last - 43200.0:
            day += 86400.0
        last = seconds
        known[i] = day + seconds
    dated = {i: value for i, value in known.items() if value > DATED}
    index = np.array(list(dated or known), dtype=int)
    value = np.array(list((dated or known).values()))
    new = np.concatenate([[True], np.diff(value) > 0.0]) if value.size else np.zeros(0, dtype=bool)
    if new.sum() < 2:
        hint = "log RMC or GGA as well, or put a time stamp before every sentence"
        raise BadInput("the sentences have no time", file=path, hint=hint)
    return index[new], value[new]


def _times(parsed: list[tuple[int, str, Any]], path: Path) -> np.ndarray:
    """(N,) seconds: sentences of a kind that follow a stated time are spread evenly until the next stated time."""
    index, value = _stamps(parsed, path)
    usual = float(np.median(np.diff(value)))
    kinds = np.array([message.sentence_type for _, _, message in parsed])
    out = np.full(len(parsed), np.nan)
    edges = [*index.tolist(), len(parsed)]
    for start, stop, at, after in zip(edges[:-1], edges[1:], value, [*value[1:], value[-1] + usual], strict=True):
        for kind in np.unique(kinds[start:stop]):
            own = start + np.flatnonzero(kinds[start:stop] == kind)
            out[own] = at if kind in TIMED else at + np.arange(own.size) / own.size * (after - at)
    return out


def _table(path: Path, kind: str, own: list[int], parsed: Any, times: Any) -> RawTable:
    stamps = [times[i] for i in own]
    values: Any = tuple(stamps) if isinstance(stamps[0], str) else np.array(stamps, dtype=float)
    columns = [RawColumn("time", "", values)]
    for name, (unit, read) in KINDS[kind].items():
        numbers = np.array([_number(read, parsed[i][2]) for i in own])
        if np.isfinite(numbers).any():
            columns.append(RawColumn(f"{kind} {name}", unit, numbers))
    rows = np.array([parsed[i][0] for i in own])
    return RawTable(path.name, tuple(columns), rows, kind, path.name, (f"{len(own)} sentences {kind}",))


def _number(read: Callable[[Any], Any], message: Any) -> float:
    try:
        value = read(message)
        return float(value) if value not in (None, "") else np.nan
    except (TypeError, ValueError, AttributeError):
        return np.nan
