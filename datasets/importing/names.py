"""Names of columns: cut into words and compared with the names of quantities."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache, lru_cache
from itertools import accumulate

from .quantities import name_list, names_in, quantities, vague_names, vocabulary, word_groups, word_list

LETTERS = str.maketrans(
    {"ä": "ae", "ö": "oe", "ü": "ue", "ß": "ss", "Ä": "Ae", "Ö": "Oe", "Ü": "Ue", "ø": "o", "Ø": "O", "æ": "ae",
     "Æ": "Ae", "å": "a", "Å": "A", "ł": "l", "Ł": "L", "ı": "i", "đ": "d",
     "ψ": "psi", "δ": "delta", "φ": "phi", "Ψ": "psi", "Δ": "delta"}
)  # fmt: skip
HAN = "\u3040-\u30ff\u3400-\u9fff\uac00-\ud7a3"
"""Japanese, Chinese and Korean letters, of which words stand together without spaces."""
ALPHABETS = "\u0370-\u03ff\u0400-\u04ff"
"""Greek and Cyrillic letters."""
WORD = re.compile(rf"[a-z]+\d?(?![a-z])|[a-z]+|\d+|[{HAN}]+|[{ALPHABETS}]+")
ZONES = ("utc", "gps", "gnss", "local")
"""Words before the part of a time: `UTC_Hour`."""
OF_ANY_NORTH = ("heading", "hdg", "head")
"""Words for a heading that do not say from which north."""
AXES = {"north", "east"}
YEAR_FIRST = frozenset({"ja", "zh", "ko"})
"""Languages whose dates begin with the year."""
FEWEST = 3
"""Letters of a name that may stand among other words."""


@dataclass(frozen=True)
class Named:
    """What a name says: the quantities that it may mean, likeliest first; other words in it that are not known; why
    it is none."""

    may_be: tuple[str, ...] = ()
    extra: tuple[str, ...] = ()
    why: str = "no known name"


@lru_cache(maxsize=4096)
def words(name: str) -> tuple[str, ...]:
    """A name as words in lower case, those in full that German cuts short: `Rudder_deg` is (rudder, deg)."""
    name = unicodedata.normalize("NFKC", name).translate(LETTERS)
    name = unicodedata.normalize("NFD", name)
    name = "".join(letter for letter in name if not "\u0300" <= letter <= "\u036f" and letter != "\u200b")
    name = unicodedata.normalize("NFC", name)
    name = re.sub(r"([a-z])([A-Z])|([A-Z])([A-Z][a-z])", r"\1\3 \2\4", name)
    found = [f"{word}indigkeit" if word.endswith("geschw") else word for word in WORD.findall(name.lower())]
    return tuple(part for word in found for part in (_segments(word) if re.match(f"[{HAN}]", word) else (word,)))


def _segments(text: str) -> list[str]:
    """A text without spaces between its words, cut into words that are known, the longest first."""
    out: list[str] = []
    while text:
        size = next((n for n in range(len(text), 1, -1) if text[:n] in _han()), 1)
        out.append(text[:size])
        text = text[size:]
    return out


@cache
def _han() -> frozenset[str]:
    lists = (word_list("command"), word_list("not_measured"), word_list("harmless"), *word_groups("sides").values())
    names = {name for q in quantities().values() for name in q.names} | set(vague_names()) | set(name_list("time"))
    return frozenset(word for word in names.union(*lists) if re.match(f"[{HAN}]", word))


def named(parts: tuple[str, ...]) -> Named:
    """What the words of a name, without unit and sign, say."""
    counted = "".join(part for part in parts if not part.isdigit())
    whole = _known("".join(parts), short=True) or _known(counted, short=False)
    if whole:
        return Named(whole, why="name")
    # the words of a name, `pos n` and `pos e` in full: without their space they are other words
    full = {("pos", "n"): ("position", "north"), ("pos", "e"): ("position", "east")}
    parts = full.get(parts[:2], parts[:2]) + parts[2:]
    told = "".join(part for part in parts if part not in word_list("harmless"))
    if {"".join(parts), told} & listed("other_motions"):
        return Named(why="vertical, or pitch: no quantity of a record")
    command, found = set(parts) & word_list("command"), [p for p in parts if p not in word_list("command")]
    refused = set(found) & word_list("not_measured")
    may_be, rest = _longest(found)
    plain = [part for part in found if part not in word_list("harmless")]
    closer, others = _longest(plain)
    if len(plain) - len(others) > len(found) - len(rest):  # a name with harmless words within
        may_be, rest = closer, others
    # words that are names of the same: the narrowest of all counts, as of `gyro hdt` and `rudder rsa`
    others = []
    for part in rest:
        own = set(_known(part, short=False))
        if own and (set(may_be) == own or (set(may_be) < own == AXES)):  # nor the letter of an axis, as of `x east`
            continue
        if own == {"heading"} < set(may_be) and part in OF_ANY_NORTH:  # that of a compass may be either
            continue
        shared = own & set(may_be)
        if shared and shared < set(may_be):
            may_be = tuple(quantity for quantity in may_be if quantity in own)
            continue
        if shared and own > shared and "heading_magnetic" not in own - shared:  # the narrower word stands already
            continue
        speeds = {quantities()[name].dimension for name in (*own, *may_be)} == {"speed"}
        if len(own) == 1 and len(may_be) > 1 and speeds:  # `speed sway`: a sway
            may_be = tuple(own)
            continue
        others.append(part)
    rest = others
    if refused and not (may_be and not set(rest) & refused):
        return Named(why=f"{sorted(refused)[0]!r}: no measured quantity of a record")
    symbols = {symbol for symbol, known in _short().items() if known == may_be}
    harmless = word_list("harmless").union(symbols, *word_groups("sides").values())
    extra = [p for p in rest if p not in harmless and p.rstrip("0123456789") not in harmless]
    if not may_be:
        return Named()
    if command and may_be[0] in ("rudder", "rudder_command"):
        return Named(("rudder_command",), tuple(extra), why=f"name with {sorted(command)[0]!r}")
    if command:
        return Named(why=f"{sorted(command)[0]!r}: a set value, no measurement")
    return Named(may_be, tuple(extra), "name")


def _longest(parts: list[str]) -> tuple[tuple[str, ...], list[str]]:
    """(what the longest name within the words may mean, the other words)."""
    harmless = word_list("harmless")
    odd = list(accumulate((not (p in harmless or p.isdigit()) for p in parts), initial=0))
    for i, j, text in sorted(_known_spans(parts), key=lambda span: -len(span[2])):
        alone = odd[j] - odd[i] == odd[-1]
        if (len(text) >= FEWEST or alone or re.match(f"[{HAN}]", text)) and (known := _known(text, short=alone)):
            return known, [*parts[:i], *parts[j:]]
    return (), parts


def _known_spans(parts: list[str]) -> Iterator[tuple[int, int, str]]:
    """(first, behind the last, text) of the words that are a name together."""
    longest = max(map(len, _names().keys() | _short().keys()))
    for i in range(len(parts)):
        text = ""
        for j in range(i, len(parts)):
            text += parts[j]
            if len(text) > longest:
                break
            if text in _names() or text in _short():
                yield i, j + 1, text


def _known(text: str, short: bool) -> tuple[str, ...]:
    return _names().get(text) or (_short().get(text, ()) if short else ())


@cache
def _names() -> dict[str, tuple[str, ...]]:
    table = {joined(name): may_be for name, may_be in vague_names().items()}
    for quantity, entry in quantities().items():
        for name in entry.names:
            table.setdefault(joined(name), (quantity,))
    return table


@cache
def _short() -> dict[str, tuple[str, ...]]:
    return {joined(name): (quantity,) for quantity, entry in quantities().items() for name in entry.short}


def joined(name: str) -> str:
    """The words of a name without what separates them."""
    return "".join(words(name))


def is_time(name: str) -> bool:
    """Whether a name is that of the time, or of one of several: `time 2 slow rate`."""
    parts = words(name)
    numbered = len(parts) > 2 and parts[0] in listed("time") and parts[1].isdigit()
    return numbered or _is_one(name, "time")


def is_date(name: str) -> bool:
    """Whether a name is that of a date."""
    return _is_one(name, "date")


def part_of_time(name: str) -> str:
    """The part of a time, year to second, that a column of this name holds; '' where it is none."""
    parts = words(name)
    own = "".join(parts[1:] if len(parts) > 1 and parts[0] in ZONES else parts)
    parts_of_time = vocabulary()["time_parts"].items()
    return next((part for part, names in parts_of_time if own in map(joined, names_in(names))), "")


def _is_one(name: str, kind: str) -> bool:
    """Whether a name is one of a list, as a whole, or all but its last one or two words or its first: `time [s]`, `gps
    time`."""
    parts = words(name)
    tried = (parts, parts[:-1], parts[1:], parts[:-2])
    return any("".join(own) in listed(kind) for own in tried if own)


@cache
def _languages() -> dict[str, frozenset[str]]:
    """Name without what separates its words -> the languages in which it is that of a quantity."""
    found: dict[str, set[str]] = {}
    for entry in vocabulary()["quantities"].values():
        for language, text in entry["names"].items():
            for name in names_in(text):
                found.setdefault(joined(name), set()).add(language)
    return {name: frozenset(own) for name, own in found.items()}


def writes_day_first(names: Iterable[tuple[str, ...]]) -> bool:
    """Whether names, as words, are of a language of Europe that is not English: its dates begin with the day."""
    told = [own for name in names if (own := _languages().get("".join(name), frozenset())) and "en" not in own]
    return bool(told) and not any(own & YEAR_FIRST for own in told)


@cache
def listed(kind: str) -> frozenset[str]:
    """The names of a list (`name_list`) without what separates their words."""
    return frozenset(map(joined, name_list(kind)))
