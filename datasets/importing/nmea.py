"""NMEA 0183 logs: sentences by kind and talker, read by pynmeagps; only numbers are kept of them.  Sentences of one
make among them (iXblue, Seatex, Furuno, Trimble, RDI), and the ASCII logs of NovAtel, are cut into cells."""

from __future__ import annotations

import datetime
import re
import zlib
from array import array
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cache, partial, reduce
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from ...models.errors import BadInput
from .formats.fields import StatedField, stated_fields
from .moments import start_of_week, time_in, utc_of_gps
from .raw import RawColumn, RawTable, Rejected, with_faults

SENTENCE = re.compile(r"[$!](?:[A-Z]{2}[A-Z]{3}|P[A-Z]{3,4})[A-Z0-9]*,[^$!\\\"]*")
SUM = re.compile(r"[$!]([^*]*)\*([0-9A-Fa-f]{2})")
CELLS = re.compile(
    r"^(?P<stamp>.{0,200}?)[,;\t]?\s*\"?(?P<talker>[A-Z]{2})\"?[,;\t ]?\s*\"?(?P<kind>[A-Z]{3})\"?[,;\t](?P<data>.*)$"
)
TAG = re.compile(r"\\([^\\]*)\\")
TAG_TIME = re.compile(r"(?:^|,)c:(\d+(?:\.\d+)?)")
FEWEST = 3
"""Sentences of a kind and talker below which they are strays, as from a disturbed line."""
DATED = 1e8
"""Seconds above which a time holds a date."""
FIELD = re.compile(r"(?P<value>\w+)(?: - (?P<letter>\w) in (?P<side>\w+))?(?P<conditions>(?: if \w+ (?:is|in) \w+)*)")
CONDITION = re.compile(r" if (\w+) (is|in) (\w+)")
STANDARD, TRANSDUCER = "NMEA 0183", "transducer "

Read: TypeAlias = Callable[[Any], Any]


@cache
def sentence_kinds() -> dict[str, tuple[str, tuple[tuple[StatedField, Read], ...]]]:
    """Address of a sentence without its talker, or name of a log of NovAtel -> who states what it holds: NMEA 0183, of
    which several talkers send the same, makers or NovAtel; and its fields, each with the function that reads it."""
    return {
        kind: (program, tuple((field, _reader(rule)) for rule, field in fields.items()))
        for program in (STANDARD, "Makers", "NovAtel")
        for kind, fields in stated_fields(program).items()
    }


def _reader(rule: str) -> Read:
    """The function that reads a field from a message, by its rule in `fields.yaml`; nothing where it does not count."""
    if rule.startswith(TRANSDUCER):
        return partial(_transducer, rule.removeprefix(TRANSDUCER))
    parts = FIELD.fullmatch(rule)
    assert parts is not None, rule
    value, letter, side = parts["value"], parts["letter"], parts["side"]
    conditions = [(name, {*letters, ""} if how == "in" else {*letters}) for name, how, letters in
                  CONDITION.findall(parts["conditions"])]  # fmt: skip

    def read(message: Any) -> Any:
        if not all(str(_cell(message, name)) in letters for name, letters in conditions):
            return None
        found = _cell(message, value)
        return -float(found) if letter and found not in (None, "") and _cell(message, side) == letter else found

    return read


def _cell(message: Any, name: str) -> Any:
    """An attribute of a message of pynmeagps, or the text of a cell by its place; '' where there is none."""
    if not name.isdigit():
        return getattr(message, name, "")
    return message.cells[int(name)] if int(name) < len(message.cells) else ""


def _transducer(name: str, message: Any) -> Any:
    """The angle of the transducer in whose name a word stands."""
    found = (i for i in range(1, 10) if name in str(getattr(message, f"tdrid_{i:02d}", "")).lower())
    place = next((i for i in found if getattr(message, f"tdrtype_{i:02d}", "") == "A"), 0)
    return getattr(message, f"data_{place:02d}") if place else None


@dataclass
class SentenceGroup:
    """Sentences of a kind of one talker: lines, places in the log, stamps beside them, and numbers field by field."""

    kind: str
    talker: str
    lines: array[int] = field(default_factory=lambda: array("q"))
    places: array[int] = field(default_factory=lambda: array("q"))
    stamps: list[str] = field(default_factory=list)
    numbers: list[array[float]] = field(default_factory=list)


@dataclass
class Sentences:
    """The sentences of a log by group, the times that they state, and what is not used.

    clocks, days : of every sentence that is kept the time of day, s, and the day in seconds since 1970; nan where it
    states none.
    """

    groups: dict[str, SentenceGroup] = field(default_factory=dict)
    clocks: array[float] = field(default_factory=lambda: array("d"))
    days: array[float] = field(default_factory=lambda: array("d"))
    faults: list[Rejected] = field(default_factory=list)
    others: Counter[str] = field(default_factory=Counter)
    stamped: int = 0

    def add(self, line: int, stamp: str, kind: str, talker: str, message: Any) -> None:
        """Keep a sentence."""
        program, fields = sentence_kinds()[kind]
        name = talker + kind if program == STANDARD and kind != "PASHR" else kind
        if kind == "RPM":  # one table for every shaft and engine
            name += f" {message.source}{message.engineshaftnum}"
        if name not in self.groups:
            self.groups[name] = SentenceGroup(kind, talker, numbers=[array("d") for _ in fields])
        # the data are void, the time is not: status V, or the mode of every receiver is N
        mode = str(getattr(message, "posMode", "") or "")
        invalid = message.msgID in ("RMC", "GLL") and getattr(message, "status", "") == "V"
        void, group = message.msgID == "lost" or invalid or set(mode) == {"N"}, self.groups[name]
        self.others[f"{kind} with status V or mode N"] += void
        self.stamped += bool(stamp)
        group.lines.append(line)
        group.places.append(len(self.clocks))
        group.stamps.append(stamp)
        for numbers, (_, read) in zip(group.numbers, fields, strict=True):
            numbers.append(np.nan if void else _number(read, message))
        # (time of day, s; day, seconds since 1970) that a sentence states; nan where it states none
        clock, date = getattr(message, "utctime" if kind == "PASHR" else "time", None), getattr(message, "date", None)
        if kind == "ZDA":
            with suppress(TypeError, ValueError):
                date = datetime.date(int(message.year), int(message.month), int(message.day))
        seconds = day = np.nan
        if isinstance(clock, datetime.time):
            seconds = clock.hour * 3600.0 + clock.minute * 60.0 + clock.second + clock.microsecond * 1e-6
        if isinstance(date, datetime.date):
            day = datetime.datetime(date.year, date.month, date.day, tzinfo=datetime.UTC).timestamp()
        self.clocks.append(seconds)
        self.days.append(day)


def _sentence(line: str) -> tuple[str, str] | None:
    """(stamp beside the sentence, the sentence) of a line; None where it holds none."""
    found = SENTENCE.search(line) or NOVATEL.search(line)
    if found:
        end = SUM.match(found[0])
        if end is not None:  # what stands behind the checksum is no part of the sentence
            return _stamp(line[: found.start()], line[found.start() + end.end() :]), end[0]
        return _stamp(line[: found.start()], line[found.end() :]), found[0].strip().rstrip("\"'")
    cells = CELLS.match(line)
    if cells and cells["kind"] in sentence_kinds():
        data = re.sub(r"[;\t]", ",", cells["data"].strip().strip('"'))
        return _stamp(cells["stamp"], ""), f"${cells['talker']}{cells['kind']},{data}"
    return None


def _stamp(before: str, behind: str) -> str:
    tag = TAG.search(before)
    time = TAG_TIME.search(tag[1].split("*")[0]) if tag else None
    if time:
        return time[1]
    before, behind = (side.strip(" ,;\t\"'[](){}<>|:") for side in (TAG.sub("", before), behind))
    return time_in(before)[0] or time_in(behind)[0] or before or behind


def read_nmea(text: str, path: Path) -> list[RawTable] | None:
    """One table for every kind of sentence of every talker, timed by stamps beside the sentences or by RMC, GGA, ZDA;
    None where most of the first lines hold no sentence.

    Raises
    ------
    BadInput : no known sentence, or no time in the log.
    """
    # most of the first lines hold a sentence
    lines = [line for line in text[:20000].splitlines()[:200] if line.strip()]
    if not (len(lines) > 0 and sum(_sentence(line) is not None for line in lines) > 0.5 * len(lines)):
        return None
    found = _parsed(text)
    kinds = sentence_kinds()
    if not any(kinds[group.kind][1] for group in found.groups.values()):
        raise BadInput("no NMEA sentence that can be used", file=path, hint=f"read are {', '.join(kinds)}")
    beside = {place: stamp for g in found.groups.values() for place, stamp in zip(g.places, g.stamps, strict=True)}
    numbers = [int(stamp) if stamp.isdecimal() and len(stamp) < 12 else -1 for _, stamp in sorted(beside.items())]
    counted = len(numbers) > 1 and bool(np.mean(np.diff(numbers) == 1) > 0.95)  # the sentences: it is no time
    stamped = found.stamped > 0.9 * len(found.clocks) and not counted
    times = None if stamped else _times(found, path)
    done = "timed by the stamps beside the sentences" if stamped else (
        "timed by sentences that state it (RMC, GGA, GLL, ZDA, NovAtel); others evenly between, to about a period"
    )  # fmt: skip
    few = {name: group for name, group in found.groups.items() if len(group.lines) < FEWEST}
    if len(few) < len(found.groups):
        found.others.update({name: len(group.lines) for name, group in few.items()})
        found.groups = {name: group for name, group in found.groups.items() if name not in few}
    others = +found.others
    skipped = ", ".join(f"{kind} ({n})" for kind, n in others.most_common())
    notes = (STANDARD, done, *((f"sentences not used: {skipped}",) if skipped else ()))
    tables = [_table(path, name, group, times) for name, group in found.groups.items() if kinds[group.kind][1]]
    tables[0] = replace(tables[0], done=(*tables[0].done, *notes))
    return with_faults(tables, found.faults, len(found.clocks) + len(found.faults) + others.total())


def _parsed(text: str) -> Sentences:
    """Sentences, lines that hold no sound one, and kinds that are not used; of AIS only the checksums are read."""
    out = Sentences()
    # a program that rewrites NovAtel's logs may leave wrong checksums in all
    checked = any(novatel_sound(found[0]) for found in NOVATEL.finditer(text))
    for number, match in enumerate(re.finditer(r"[^\r\n]*(?:\r\n|\r|\n|$)", text), start=1):  # no copy of the text
        if not (line := match[0].strip()):
            continue
        found = _sentence(line)
        if found is None:
            out.faults += [(number, "no NMEA sentence", line)] if not line.lstrip().startswith("#") else []
            continue
        stamp, sentence = found
        kind = _kind(sentence)
        if not (_sound(sentence) if sentence[0] in "$!" else not checked or novatel_sound(sentence)):
            out.faults.append((number, "the checksum of the sentence is wrong", line))
        elif kind not in sentence_kinds():
            out.others[kind] += 1
        elif (message := _message(sentence)) is None:
            out.faults.append((number, "the form of the sentence is wrong", line))
        else:
            out.add(number, stamp, kind, sentence[1:3], message)
    return out


def _kind(sentence: str) -> str:
    address = sentence[1:].split(",", 1)[0]
    if sentence[0] in "#%":
        return novatel_kind(sentence)
    if not address.startswith("P"):
        return address[2:]
    body = sentence.split("*")[0]  # of a maker: the first field may say which one it is
    return address + (body.split(",", 2)[1] if address in SUBTYPED and "," in body else "")


def _sound(sentence: str) -> bool:
    """Whether the checksum is right, or there is none."""
    match = SUM.match(sentence)
    if match is None:
        return "*" not in sentence
    return reduce(lambda a, b: a ^ b, match[1].encode(errors="replace"), 0) == int(match[2], 16)


def _message(sentence: str) -> Any:
    from pynmeagps import NMEAMessageError, NMEAParseError, NMEAReader, NMEATypeError

    body = sentence[1:].split("*")[0]
    if sentence[0] in "#%":
        return novatel_message(sentence)
    try:
        if (kind := _kind(sentence)) in stated_fields("Makers"):  # its fields behind address and kind
            first, *cells = body.split(",")
            cells = cells[int(kind != first) :]
            return SentenceParts(kind, tuple(cells)) if any(cells) else None
        return NMEAReader.parse(f"${body}*00\r\n".encode(), validate=0)
    except (NMEAMessageError, NMEAParseError, NMEATypeError, ValueError, TypeError, LookupError, AttributeError):
        return None


def _times(found: Sentences, path: Path) -> np.ndarray:
    """(N,) seconds: sentences of a kind that follow a stated time are spread evenly until the next stated time."""
    # (places of the sentences that state a new time, their epoch seconds; seconds of the first day without a date)
    clocks, days = np.array(found.clocks), np.array(found.days)
    index = np.flatnonzero(np.isfinite(clocks))
    value, day, last = np.empty(index.size), 0.0, -1.0
    for k, (seconds, date) in enumerate(zip(clocks[index].tolist(), days[index].tolist(), strict=True)):
        if date == date:
            day = date
        elif seconds < last - 43200.0:
            day += 86400.0
        last = seconds
        value[k] = day + seconds
    dated = value > DATED
    index, value = (index[dated], value[dated]) if dated.any() else (index, value)
    new = np.diff(np.maximum.accumulate(value), prepend=-np.inf) > 0.0
    if new.sum() < 2:
        hint = "log RMC or GGA as well, or put a time stamp before every sentence"
        raise BadInput("the sentences have no time", file=path, hint=hint)
    index, value = index[new], value[new]
    usual = float(np.median(np.diff(value)))
    after = np.minimum(np.append(value[1:], value[-1] + usual), value + 3.0 * usual)
    out, stating = np.full(len(found.clocks), np.nan), np.isfinite(np.array(found.clocks))
    for group in found.groups.values():
        places = np.array(group.places)
        spans = np.searchsorted(index, places, side="right") - 1
        places, spans = places[spans >= 0], spans[spans >= 0]
        _, first, count = np.unique(spans, return_index=True, return_counts=True)
        order = np.arange(spans.size) - np.repeat(first, count)
        timed = places.size > 0 and stating[places].mean() > 0.5
        share = 0.0 if timed else order / np.repeat(count, count)
        out[places] = value[spans] + share * (after[spans] - value[spans])
    return out


def _table(path: Path, name: str, group: SentenceGroup, times: np.ndarray | None) -> RawTable:
    talker = "" if name == group.kind else f" of talker {group.talker}"
    program, fields = sentence_kinds()[group.kind]
    by = f"{program if program == 'NovAtel' else STANDARD} states it: {group.kind}{talker}"
    values: Any = tuple(group.stamps) if times is None else times[np.array(group.places)]
    columns = [RawColumn("time", "", values, "" if times is None else "time", by)]
    for ((called, quantity, unit), _), series in zip(fields, group.numbers, strict=True):
        numbers = np.array(series)
        if np.isfinite(numbers).any():
            side = "starboard" if quantity == "rudder" else ""
            columns.append(RawColumn(called, unit, numbers, quantity, by, side=side))
    return RawTable.of(path, columns, f"{len(group.lines)} sentences {name}", name, group.lines)


def _number(read: Read, message: Any) -> float:
    try:
        value = read(message)
        return float(value) if value not in (None, "") else np.nan
    except (TypeError, ValueError, AttributeError):
        return np.nan


# ---- Sentences of one make, and the logs of NovAtel.

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
