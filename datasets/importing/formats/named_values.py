"""Logs of lines that name each value: logfmt, such as `ts=2026-03-14T10:00:00Z hdg=271.4 rudder_deg=-3`, InfluxDB's
line protocol, and MAVLink messages as text."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

from ....models.number_texts import DECIMAL
from ..headers import says_unit
from ..moments import time_in
from ..names import is_time
from ..raw import RawTable, usable
from .object_tables import tables_of_rows

Values: TypeAlias = dict[str, Any]
NUMBER = re.compile(DECIMAL)
FEWEST, LONGEST, HEAD, FIRST = 2, 5000, 20000, 60
"""Pairs of a line, its characters, and characters and lines by which a log is told."""
STAMP = "timestamp"


def read_named_values(text: str, path: Path) -> list[RawTable] | None:
    """The tables of a log of named values, one for each kind of line; None where the text is no such log.

    Raises
    ------
    BadInput : no line holds numbers.
    """
    lines = [line for line in text[:HEAD].splitlines()[:FIRST] if line.strip()][:-1]
    values_of = next((read for looks_like, read in FORMS if len(lines) > 2 and looks_like(lines)), None)
    if values_of is None:
        return None
    numbered = ((number, line) for number, line in enumerate(text.splitlines(), start=1) if len(line) <= LONGEST)
    rows = [(number, values) for number, line in numbered if (values := values_of(line))]
    return usable(tables_of_rows(rows, path), path, "no line of named values with numbers found")


# ---- Pairs of names and values with a sign of equality, or a colon, between them.

SIZED = re.compile(rf"({DECIMAL})([A-Za-z°%][A-Za-z°/%]*)?")
"""A number with a unit or without."""
SIDED = re.compile(rf"[A-Za-z]{DECIMAL}|{DECIMAL}[A-Za-z]")
"""A number with the letter of a side."""
PAIR = re.compile(r'(?<![^\s,;|])([^\W\d][\w.\-/]*)\s?[=:]\s?("[^"]*"|[^\s,;|"=]+)(?=[\s,;|]|$)')


def _are_pairs(lines: Sequence[str]) -> bool:
    """Whether most lines hold numbers, each behind its name and a sign of equality, or behind a colon, the same names
    in all."""
    named = [_names(line) for line in lines]
    usual = max(named, key=named.count)
    equal = [sum(sign == "=" for _, sign in own) >= FEWEST for own in named]
    alike = [len(own) >= FEWEST and own == usual for own in named]
    return any(sum(fits) > 0.8 * len(lines) for fits in (equal, alike))


def _names(line: str) -> list[tuple[str, str]]:
    """(name, sign) of the numbers of a line."""
    found = PAIR.finditer(line[:LONGEST])
    pairs = (match for match in found if _number_and_unit(match[2]) is not None or SIDED.fullmatch(match[2]))
    return [(match[1], "=" if "=" in match[0] else ":") for match in pairs]


def _of_pairs(line: str) -> Values:
    """The values of a line, with a time that stands before them; nothing where they are few."""
    pairs = list(PAIR.finditer(line))
    values: Values = {pair[1]: _sized_value(pair[2]) for pair in pairs}
    if len(values) < FEWEST:
        return {}
    stamp, _ = time_in(line[: pairs[0].start()])
    return ({STAMP: stamp} if stamp and not any(map(is_time, values)) else {}) | values


def _number_and_unit(text: str) -> tuple[str, str] | None:
    """(number, unit) of a text such as `13.5kn` or `-3`; None where it is none."""
    match = SIZED.fullmatch(text)
    return (match[1], match[2]) if match and (not match[2] or says_unit(match[2])) else None


def _sized_value(text: str) -> float | str | dict[str, float | str]:
    """The value of a text, with the unit that stands behind it."""
    sized = _number_and_unit(text)
    if sized and sized[1]:
        return {"value": float(sized[0]), "unit": sized[1]}
    return float(text) if NUMBER.fullmatch(text) else text.strip('"')


# ---- InfluxDB's line protocol: a measurement with tags, its fields, and the nanoseconds since 1970.

PROTOCOL_LINE = re.compile(
    r"(?P<series>[^\s=]{1,200}(?:,[^\s,=]+=[^\s,=]+)*) (?P<fields>[^\s=,]+=\S.*) (?P<time>\d{10,19})\s*$"
)
PROTOCOL_FIELD = re.compile(rf"(?P<name>[^\s=,]+)=(?:(?P<number>{DECIMAL})[iu]?|\"[^\"]*\"|[a-zA-Z]+)(?:,|$)")


def _of_protocol(line: str) -> Values:
    match = PROTOCOL_LINE.match(line)
    if match is None:
        return {}
    fields = {f["name"]: float(f["number"]) for f in PROTOCOL_FIELD.finditer(match["fields"]) if f["number"]}
    measurement, _, tags = match["series"].partition(",")
    return {"measurement": f"{tags}/{measurement}".strip("/"), "time": int(match["time"])} | fields


# ---- MAVLink messages: as mavlogdump prints them, a stamp, the name of the message, its fields in braces; as Mission
# Planner writes them, a stamp, the name among other cells, then names and values in turn.

MESSAGE = re.compile(
    r"(?P<stamp>\d{4}-\d\d-\d\d \d\d:\d\d:\d\d(?:\.\d+)?): (?P<name>[A-Z][A-Z0-9_]+) \{(?P<fields>.*)\}\s*$"
)
MESSAGE_CELLS = re.compile(
    r"(?P<stamp>\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(?:\.\d+)?),.{0,80}?,mavlink_(?P<name>\w+?)_t,(?P<fields>.*)"
)
MESSAGE_FIELD = re.compile(rf"(\w+) : ({DECIMAL})(?=,|$)")


def _of_message(line: str) -> Values:
    match = MESSAGE.match(line) or MESSAGE_CELLS.match(line)
    if match is None:
        return {}
    cells = match["fields"].split(",")
    turns = [
        (name, text) for name, text in zip(cells[::2], cells[1::2], strict=False) if name and NUMBER.fullmatch(text)
    ]
    pairs = MESSAGE_FIELD.findall(match["fields"]) if match.re is MESSAGE else turns
    fields = {name: float(text) for name, text in pairs}
    return {STAMP: match["stamp"], "type": match["name"].upper()} | fields


def _most(read: Callable[[str], Values], lines: Sequence[str]) -> bool:
    """Whether more than four of five lines, comments aside, are of a form."""
    own = [line for line in lines if not line.startswith("#")]
    return sum(map(bool, map(read, own))) > 0.8 * len(own)


FORMS: tuple[tuple[Callable[[Sequence[str]], bool], Callable[[str], Values]], ...] = (
    (partial(_most, _of_message), _of_message),
    (partial(_most, _of_protocol), _of_protocol),
    (_are_pairs, _of_pairs),
)
"""Whether first lines are of a form, and the values of a line of it."""
