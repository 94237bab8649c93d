"""What is said of a column elsewhere: in lines above the header, in a file beside the log, in a column of sides."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ...models.data_file import load
from ...models.errors import BadInput
from ..columns import ACCEPTED, QUANTITIES
from ..sidecar_file import SidecarFile
from .cells import GAPS, Texts, sides_of
from .headers import read_header
from .names import joined, named, words
from .quantities import UNITS, quantities, tidy, unit_of, word_groups
from .raw import RawColumn, RawTable

SUFFIXES = (".yaml", ".yml", ".json")
FEW = 100
"""Cells that are looked at before a whole column is."""
SENTENCE, FEWEST_UNITS = re.compile(r"\bin\s+([A-Za-z°/]+(?:\s+per\s+[a-z]+)?)", re.IGNORECASE), 2
"""A unit in a sentence, and how many make it a sentence of units."""
ANGLE = r"\d[\d.,°\s:'\"\u2032\u2033-]*"
PLACE = re.compile(
    rf"(?P<lat>{ANGLE}[NSns])[\s,;/]*(?P<lon>{ANGLE}[EWew])|(?P<north>[NSns]\s*{ANGLE})[\s,;/]*(?P<east>[EWew]\s*{ANGLE})"
    r"|POINT\s*Z?\s*\((?P<x>-?[\d.]+)\s+(?P<y>-?[\d.]+)[^)]*\)"
)
"""A latitude and a longitude in one cell, the letters behind them or before them; or a point, as databases write
it."""
DEGREES, MINUTES = frozenset({"deg", "degrees", "°", "grad"}), frozenset({"min", "minutes", "'", "minuten"})
"""Units of the two parts of an angle."""
MOST_WORDS = 16
"""Words of a line that says something of one column; longer ones are prose."""


def with_notes(columns: Sequence[RawColumn], notes: Sequence[str]) -> list[RawColumn]:
    """Columns with the lines above the header that begin with their name, or that list one unit a column."""
    parts = [part for note in notes if len(note.split()) <= MOST_WORDS for part in re.split(r"[;|]", note)]
    named_parts = [place for part in parts if (place := _named(columns, part)) is not None]
    said = [*named_parts, *(place for note in notes for place in _by_sentence(columns, note))]
    return [replace(c, said=(*c.said, *(text for at, text in said if at == i))) for i, c in enumerate(columns)]


def _by_sentence(columns: Sequence[RawColumn], note: str) -> list[tuple[int, str]]:
    """(column, its unit) by a sentence of units: `(position in Meters, angles in Degrees, velocity in Meter/Sec)`.

    A unit counts for all columns of its dimension, where the sentence states one of that dimension only.
    """
    stated = [unit for text in SENTENCE.findall(note) if (unit := unit_of(text)) is not None]
    units = {unit.dimension: unit.name for unit in stated}
    if len(stated) < FEWEST_UNITS or len({unit.name for unit in stated}) > len(units):
        return []
    kinds = [{quantities()[q].dimension for q in named(words(column.name)).may_be} for column in columns]
    told = [(i, next((units[kind] for kind in sorted(own) if kind in units), "")) for i, own in enumerate(kinds)]
    return [(i, unit) for i, unit in told if unit and not columns[i].unit]


def _named(columns: Sequence[RawColumn], note: str) -> tuple[int, str] | None:
    """(the column that a text begins with, what it says of it)."""
    text = note.strip().lstrip("#%/*! ").strip()
    for i, column in sorted(enumerate(columns), key=lambda pair: -len(pair[1].name)):
        rest = text[len(column.name) :]
        if text.lower().startswith(column.name.lower()) and column.name and not re.match(r"\w", rest):
            said = re.sub(r"^\s*(?:[:=,]|\bis\b|\bare\b|\bin\b|\bist\b|-\s)*\s*", "", rest).strip()
            said = re.sub(r"^(?:in|unit|units|einheit)\b[:= ]*", "", said, flags=re.IGNORECASE)
            return (i, said) if said else None
    label, _, said = text.partition(":")
    own = words(label) if said.strip() and label.strip() else ()
    # a column's words, whole and without those that spell a unit at its end
    headers = [read_header(column.name, column.unit) for column in columns] if own else []
    able = [i for i, h in enumerate(headers) if own in (h.words, *(head for head, _ in h.suffixes))]
    return (able[0], said.strip()) if len(able) == 1 else None


def with_places(columns: Sequence[RawColumn]) -> list[RawColumn]:
    """Columns of which each cell holds a latitude and a longitude with their letters as two columns."""
    out: list[RawColumn] = []
    for column in columns:
        found = [PLACE.fullmatch(text) for text in column.first(FEW)] if column.texts is not None else []
        if not found or not all(found) or column.texts is None:
            out.append(column)
            continue
        places = [PLACE.fullmatch(text.strip()) for text in column.texts]
        for name, *keys in (("latitude", "lat", "north", "y"), ("longitude", "lon", "east", "x")):
            own = Texts(next(match[k] for k in keys if match[k]).strip() if match else "" for match in places)
            out.append(replace(column, name=f"{column.name} {name}", called=name, unit="", values=own))
    return out


def with_minutes(columns: Sequence[RawColumn]) -> list[RawColumn]:
    """Columns of the whole degrees of a latitude or longitude with the minutes of the column behind them."""
    out = list(columns)
    for i in range(1, len(out)):
        whole, minutes = out[i - 1], out[i]
        if _place_in(whole, DEGREES) != _place_in(minutes, MINUTES) or not _place_in(minutes, MINUTES):
            continue
        degrees, rest = whole.numbers, minutes.numbers
        in_full = np.array_equal(degrees, np.round(degrees), equal_nan=True)
        if in_full and 0.0 <= np.nanmin(rest) <= np.nanmax(rest) < 60:
            signed = Texts(f"{number:.9f}" for number in (degrees + np.copysign(rest / 60.0, degrees)).tolist())
            minutes = replace(minutes, known="not used", source=f"the minutes of column {whole.name}, added to it")
            out[i - 1 : i + 1] = [minutes, replace(whole, values=signed)]  # before the letters of a hemisphere
    return out


def _place_in(column: RawColumn, units: frozenset[str]) -> str:
    """The latitude or longitude that a column of numbers is a part of, in one of some units; '' where it is none."""
    own = [word for word in words(column.name) if not word.isdigit()]
    spelt = tidy(column.unit) if column.unit else own[-1] if own else ""
    name = named(tuple(word for word in own if word not in DEGREES | MINUTES)).may_be
    return name[0] if name in (("latitude",), ("longitude",)) and spelt in units and column.numeric else ""


def with_sides(columns: Sequence[RawColumn]) -> list[RawColumn]:
    """Columns with the sign of a column of sides behind them: P and S, N and S, E and W."""
    out = list(columns)
    for i in range(1, len(out)):
        before, letters = out[i - 1], out[i]
        if letters.texts is None or before.texts is None or letters.known or not _sides(letters.texts, before):
            continue
        if not before.numeric or (before.finite < 0.0).any():
            continue
        # numbers with the letters beside them, nothing where there is no number
        sides = np.where(letters.texts.among(GAPS), "", np.strings.upper(letters.texts.trimmed))
        numbers = before.texts.trimmed
        out[i - 1] = replace(before, values=Texts(np.where(numbers == "", "", numbers + " " + sides)))
        out[i] = replace(letters, known="not used", source=f"the side of column {before.name}")
    return out


def with_halves(columns: Sequence[RawColumn]) -> list[RawColumn]:
    """Columns of the angle to one side and to the other, one of them zero at any time, as one signed column."""
    out = list(columns)
    starboard, port = (of_side(columns, side) for side in ("starboard", "port"))
    pairs = [(places, port[key]) for key, places in starboard.items() if key in port]
    for (i, *more), (j, *others) in pairs:
        if more or others:
            continue
        one, other = out[i], out[j]
        a, b = np.nan_to_num(one.numbers), np.nan_to_num(other.numbers)
        if (a >= 0.0).all() and (b >= 0.0).all() and a.any() and b.any() and np.mean((a > 0.0) & (b > 0.0)) < 0.05:
            out[i] = replace(one, values=one.numbers - other.numbers, said=(*one.said, "positive to starboard"))
            out[j] = replace(other, known="not used", source=f"the other side of column {one.name}, taken off it")
    return out


def of_side(columns: Sequence[RawColumn], side: str) -> dict[tuple[frozenset[str], str], list[int]]:
    """(The other words of a name, its unit) -> places of the columns that have a word of that side."""
    found: dict[tuple[frozenset[str], str], list[int]] = {}
    for place, column in enumerate(columns):
        own = frozenset(words(column.name))
        if own & word_groups("sides")[side]:
            found.setdefault((own - word_groups("sides")[side], column.unit), []).append(place)
    return found


def _sides(letters: Texts, before: RawColumn) -> bool:
    """Whether a column of texts names sides; a few of its cells tell of most columns that they are none."""

    def may_be(texts: Sequence[str]) -> bool:
        kinds = {text.strip().lower() for text in texts} - GAPS
        return len(kinds) <= 3 and kinds <= sides_of(before.name).keys()

    return may_be(letters[:FEW]) and may_be(kinds := letters.unique()) and not GAPS.issuperset(map(str.lower, kinds))


def with_sidecar(tables: Sequence[RawTable], path: Path) -> list[RawTable]:
    """Tables with what a YAML or JSON file beside the log says of their columns; an unreadable one says nothing."""
    places = [path.with_suffix(suffix) for suffix in SUFFIXES] + [path.with_name(path.name + s) for s in SUFFIXES]
    found = next((place for place in places if place != path and place.is_file()), None)
    if found is None:
        return list(tables)
    try:
        content = load(found)
    except BadInput:
        return list(tables)
    content = content if isinstance(content, Mapping) else {}
    said, out = dict(_statements(content)), []
    by, side = f"a record: its sidecar {found.name} lies beside it", str(content.get("positive_rudder") or "")
    for table in tables:
        of_record = bool(content) and set(content) <= set(SidecarFile.model_fields)
        if of_record and all(column.name in ACCEPTED for column in table.columns):  # its format states units and signs
            table = table.told(lambda column: _as_channel(column, by, side))
        if any(said.get(joined(c.name)) for c in table.columns):
            done = f"units and signs by {found.name}"
            table = table.told(lambda c: replace(c, said=(*c.said, *said.get(joined(c.name), ()))), done)
        out.append(table)
    return out


def _as_channel(column: RawColumn, by: str, side: str) -> RawColumn:
    quantity = next(key for key, names in QUANTITIES.items() if column.name in names)
    suffix = column.name.removeprefix(f"{quantity}_")
    if quantity == "time":
        return replace(column, unit=suffix, known="time", source=by)
    unit = next(u.name for u in UNITS.values() if unit_of(suffix.replace("_", "/"), u.dimension) is u
                and u.dimension == quantities()[quantity].dimension)  # fmt: skip
    own = side if quantity in ("rudder", "rudder_command") else ""
    return replace(column, unit=unit, known=quantity, source=by, side=own)


def _statements(content: Mapping[str, Any], depth: int = 0) -> list[tuple[str, list[str]]]:
    """(name, statements) of all keys: `rot: deg/min`, `rudder: {unit: deg, positive: port}`."""
    out: list[tuple[str, list[str]]] = []
    for key, value in content.items():
        name = str(key)
        if isinstance(value, str):
            positive = re.fullmatch(r"positive[_ ](\w+)", name)
            out.append((joined(positive[1]), [f"positive to {value}"]) if positive else (joined(name), [value]))
        elif isinstance(value, Mapping):
            own = [_statement(str(k), v) for k, v in value.items() if isinstance(v, str)]
            out.append((joined(name), [text for text in own if text]))
            out += _statements(value, depth + 1) if depth < 3 else []
        elif isinstance(value, list) and depth < 3:
            for entry in value:
                if isinstance(entry, Mapping) and (label := entry.get("name") or entry.get("column")):
                    own = [_statement(str(k), v) for k, v in entry.items() if isinstance(v, str) and v != label]
                    out.append((joined(str(label)), [text for text in own if text]))
    return out


def _statement(key: str, value: str) -> str:
    if key.lower() in ("positive", "sign", "positive_to", "positive_side", "direction"):
        return value if "positive" in value.lower() or "+" in value else f"positive to {value}"
    return value if key.lower() in ("unit", "units", "description", "comment", "note", "einheit", "convention") else ""
