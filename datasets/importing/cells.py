"""Cells of text as numbers: decimal and thousands signs, letters of a side or hemisphere, units behind a number."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from .units import unit_of, words_of

Style: TypeAlias = Literal["point", "comma", "open"]
"""The decimal sign of a table; open where nothing tells whether 612,345 has decimals or thousands."""

GAPS = words_of(
    "nan na n/a null none nil - -- --- #n/a #nv inv invalid ? * #value! #ref! #div/0! -.- ... ---.- --.-"
) | {""}
"""Texts, in lower case, that stand for a missing value."""
NARROW = str.maketrans("", "", "\u00a0\u202f\u2009'\u2019`")
MINUS = str.maketrans({"\u2212": "-", "\u2013": "-", "\ufe63": "-", "\uff0d": "-"})
PLAIN = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
GROUPED_SPACES = re.compile(r"[+-]?\d{1,3}( \d{3})+([.,]\d+)?")
POINT_SURE = re.compile(
    r"[+-]?(\d{1,3}(,\d{3})+\.\d+|\d{1,3}(,\d{3}){2,}|0\.\d+|\d{4,}\.\d+|\d*\.(\d{1,2}|\d{4,})|\.\d+)([eE][+-]?\d+)?"
)
COMMA_SURE = re.compile(
    r"[+-]?(\d{1,3}(\.\d{3})+,\d+|\d{1,3}(\.\d{3}){2,}|0,\d+|\d{4,},\d+|\d*,(\d{1,2}|\d{4,})|,\d+)([eE][+-]?\d+)?"
)
EITHER = re.compile(r"[+-]?[1-9]\d{0,2}[.,]\d{3}")
DECORATED = re.compile(r"(?P<before>[^\d+\-.,]*?)\s*(?P<number>[+-]?[\d.,]+(?:[eE][+-]?\d+)?)\s*(?P<after>[^\d]*)")
SIDES = {
    letters: side
    for side, known in (
        ("port", "p port bb prt l left babord 左"),
        ("starboard", "s stb stbd sb r right starboard tribord 右"),
        ("north", "n north"),
        ("south", "south"),
        ("east", "e o east"),
        ("west", "w west"),
    )
    for letters in known.split()
}
"""Letters at a number -> the side that they mean; of latitudes and longitudes s is south."""
POSITIVE_SIDES = ("starboard", "north", "east")
SAMPLE = 2000


def is_number(text: str) -> bool:
    """Whether a cell is a number, with a decimal point or comma, with or without thousands."""
    text = text.strip().translate(NARROW).translate(MINUS)
    return bool(PLAIN.fullmatch(text) or POINT_SURE.fullmatch(text) or COMMA_SURE.fullmatch(text)) or (
        bool(EITHER.fullmatch(text) or GROUPED_SPACES.fullmatch(text))
        or text.lower() in ("inf", "-inf", "+inf", "infinity")
    )


def style_of(texts: Sequence[str]) -> Style | None:
    """The decimal sign that a column shows; None where it has no such sign, 'open' where it could be either."""
    sample = [text.strip().translate(NARROW).translate(MINUS) for text in texts[:SAMPLE]]
    sample = [text.replace(" ", "") if GROUPED_SPACES.fullmatch(text) else text for text in sample]
    signed = [text for text in sample if "." in text or "," in text]
    points = sum(bool(POINT_SURE.fullmatch(text)) for text in signed)
    commas = sum(bool(COMMA_SURE.fullmatch(text)) for text in signed)
    if points or commas:
        return "point" if points >= commas else "comma"
    return "open" if any(EITHER.fullmatch(text) for text in signed) else None


def table_style(columns: Sequence[Sequence[str]]) -> Style:
    """The decimal sign of the columns that do not show their own."""
    styles = [style_of(texts) for texts in columns]
    for style in ("point", "comma"):
        other = "comma" if style == "point" else "point"
        if style in styles and other not in styles:
            return style
    cells = [text for texts in columns for text in texts[:SAMPLE]]
    commas, points = (any(sign in text and EITHER.fullmatch(text.strip()) for text in cells) for sign in ",.")
    if commas and points:
        return "open"
    return "open" if commas else "point"


def numbers_of(texts: Sequence[str], style: Style = "point") -> np.ndarray:
    """Texts (N) as numbers (N,), nan where a text is none.

    style : the decimal sign of the table, for a column that does not show its own.
    """
    plain = _floats(texts)
    missing = np.flatnonzero(np.isnan(plain)).tolist()
    own = style_of(texts)
    decimal = own if own in ("point", "comma") else style
    if decimal == "comma" or any("," in texts[i] for i in missing) or _any_spaces(texts, missing):
        return _floats([_with_point(text, decimal) for text in texts])
    return plain


def _any_spaces(texts: Sequence[str], missing: Sequence[int]) -> bool:
    return any(not texts[i].isascii() or "'" in texts[i] or " " in texts[i].strip() for i in missing[:SAMPLE])


def _with_point(text: str, style: Style) -> str:
    """A number with a decimal point and without thousands, other texts as they are."""
    tidy = text.strip().translate(NARROW).translate(MINUS)
    tidy = tidy.replace(" ", "") if GROUPED_SPACES.fullmatch(tidy) else tidy
    if style == "comma":
        return tidy.replace(".", "").replace(",", ".") if COMMA_SURE.fullmatch(tidy) or EITHER.fullmatch(tidy) else tidy
    return tidy.replace(",", "") if re.fullmatch(r"[+-]?\d{1,3}(,\d{3})+(\.\d*)?", tidy) else tidy


def _floats(texts: Sequence[str]) -> np.ndarray:
    out = np.full(len(texts), np.nan)
    for i, text in enumerate(texts):
        try:
            out[i] = float(text) if "_" not in text else np.nan
        except ValueError:
            continue
    return out


@dataclass(frozen=True)
class Decorated:
    """Numbers (N,) of cells with letters; what the letters state: a unit, and the side of a positive number."""

    numbers: np.ndarray
    unit: str
    positive: str


def decorated(texts: Sequence[str], name: str, style: Style) -> Decorated | None:
    """The numbers of cells such as `12.5 P`, `54.42N`, `12.3 kn`; None where most cells are of no such form."""
    matches = [DECORATED.fullmatch(text.strip().translate(MINUS)) for text in texts]
    told = [text.strip().lower() not in GAPS for text in texts]
    if sum(told) == 0 or sum(m is not None for m, t in zip(matches, told, strict=True) if t) < 0.9 * sum(told):
        return None
    letters = [_letters(match) for match in matches]
    kinds = {kind for kind, t in zip(letters, told, strict=True) if t and kind}
    sides = {kind: side for kind in kinds if (side := side_of(kind, name))}
    units = {kind for kind in kinds if kind not in sides}
    if len(units) > 1 or not kinds or any(unit_of(kind) is None and kind != "%" for kind in units):
        return None
    plain = numbers_of([match["number"] if match else "" for match in matches], style)
    signs = np.array([-1.0 if sides.get(kind) and sides[kind] not in POSITIVE_SIDES else 1.0 for kind in letters])
    positive = "" if not sides else "east" if set(sides.values()) <= {"north", "south", "east", "west"} else "starboard"
    return Decorated(plain * signs, units.pop() if units else "", positive)


def _letters(match: re.Match[str] | None) -> str:
    return f"{match['before']}{match['after']}".strip().strip(".").lower() if match else ""


def side_of(letters: str, name: str) -> str:
    """The side that letters at a number mean; '' where they are no side."""
    side = SIDES.get(letters, "")
    place = re.search(r"lat|breite|bredde|緯度|纬度|n/s", name.lower())
    return ("south" if letters == "s" and place else side) if side else ""
