"""Cells of text as numbers: decimal and thousands signs, letters of a side or hemisphere, units; columns of texts."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.dtypes import StringDType

from ...models.number_texts import DECIMAL
from ..arrow_csv import arrow_mask, arrow_texts, compute, mask_of_arrow, numbers_of_arrow
from .names import named, words
from .quantities import TIME_WORDS, tidy, unit_of, word_groups, word_list

Style: TypeAlias = Literal["point", "comma", "open"]
"""The decimal sign of a table; open where nothing tells whether 612,345 has decimals or thousands."""

GAPS = word_list("gaps") | {""}
"""Texts, in lower case, that stand for a missing value."""
NARROW = str.maketrans("", "", "\u00a0\u202f\u2009'\u2019`")
MINUS = str.maketrans({"\u2212": "-", "\u2013": "-", "\ufe63": "-", "\uff0d": "-"})
PLAIN = re.compile(DECIMAL)
WIDE = str.maketrans({0xFF10 + digit: str(digit) for digit in range(10)} | {0xFF0E: ".", 0xFF0C: ",", 0xFF0B: "+"})
NUMBER_LIKE = re.compile(r"[\s\d.,eE+\-'`\u2019\xa0\u202f\u2009\u2212\u2013\ufe63\uff0b-\uff19]+")
"""Texts of nothing but digits and signs."""
INFINITE = re.compile(r"[+-]?inf(inity)?", re.IGNORECASE)
GROUPED_COMMAS = re.compile(r"[+-]?\d{1,3}(,\d{3})+(\.\d*)?")
GROUPED_SPACES = re.compile(r"[+-]?\d{1,3}( \d{3})+([.,]\d+)?")
POINT_SURE = re.compile(
    r"[+-]?(\d{1,3}(,\d{3})+\.\d+|\d{1,3}(,\d{3}){2,}|0\.\d+|\d{4,}\.\d+|\d*\.(\d{1,2}|\d{4,})|\.\d+)([eE][+-]?\d+)?"
)
COMMA_SURE = re.compile(
    r"[+-]?(\d{1,3}(\.\d{3})+,\d+|\d{1,3}(\.\d{3}){2,}|0,\d+|\d{4,},\d+|\d*,(\d{1,2}|\d{4,})|,\d+)([eE][+-]?\d+)?"
)
ONE_COMMA = re.compile(r"[+-]?(\d*,(\d{1,2}|\d{4,})|(0|\d{4,}|[1-9]\d{0,2}),\d+)")
"""Numbers with a decimal comma and no sign of thousands: some of what `COMMA_SURE` and `EITHER` take."""
EITHER = re.compile(r"[+-]?[1-9]\d{0,2}[.,]\d{3}")
DECORATED = re.compile(r"(?P<before>[^\d+\-.,]*+)(?P<number>[+-]?[\d.,]++(?:[eE][+-]?\d++)?)(?P<after>[^\d]*+)")
ANGLE = re.compile(
    r"(?P<before>[^\d+-]*)(?P<sign>[+-]?)(?P<degrees>\d{1,3})[°\s:-]\s*(?P<minutes>\d{1,2}(?:[.,]\d+)?)['\u2032\s:]?\s*"
    r"(?P<seconds>\d{1,2}(?:[.,]\d+)?)?[\"\u2033]?(?P<after>[^\d]*)"
)
"""Degrees, minutes and perhaps seconds with the letters of a hemisphere: 54°12.345'N, 54 12 20 N, 095-00.01W."""
HEMISPHERES = ("north", "south", "east", "west")
ON_EARTH = {"latitude", "longitude", "magnetic_variation", "magnetic_deviation"}
TO_A_SIDE = {"rudder", "rudder_command", "yaw_rate", "sway", "roll", "roll_rate"}
"""Quantities that count to the sides of the earth, and to those of the ship."""
OF_A_SIDE = ("angle", "angular rate", "speed")
"""Dimensions of what counts to a side."""
SENTINELS = frozenset(
    [float(f"{'9' * whole}.{'9' * digits}" if digits else "9" * whole) for whole in range(3, 8) for digits in range(4)]
    + [32767.0, 32768.0, 65535.0, 2147483647.0, 2147483648.0, 1e10, 1e20, 1e30]
)
"""Sizes of numbers by which loggers mark a missing value."""
POSITIVE_SIDES = ("starboard", "north", "east")
SAMPLE = 2000


def is_number(text: str) -> bool:
    """Whether a cell is a number, with a decimal point or comma, with or without thousands."""
    text = text.strip()
    if PLAIN.fullmatch(text):
        return True
    text = text.translate(NARROW).translate(MINUS)
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


def numbers_of(texts: Texts, style: Style = "point") -> np.ndarray:
    """Texts (N) as numbers (N,), nan where a text is none.

    style : the decimal sign of the table, for a column that does not show its own.
    """
    own = style_of(texts[:SAMPLE])
    decimal = own if own in ("point", "comma") else style
    plain = _plain_numbers(texts, decimal)
    if plain is not None:
        return plain
    numbers = _floats(_with_points(texts, decimal))
    missing = np.flatnonzero(np.isnan(numbers))
    if missing.size:
        missing = missing[texts.take(missing).matched(NUMBER_LIKE)]
    if missing.size:
        numbers[missing] = texts.take(missing).mapped(lambda text: _number(text, decimal))
    return numbers


def _plain_numbers(texts: Texts, decimal: Style) -> np.ndarray | None:
    """The numbers (N,) of Arrow's texts; None where signs of thousands, or such as only `_number` reads, are among
    them."""
    if texts.arrow is None:
        return None
    gaps = texts.among(GAPS)
    if decimal == "comma":
        signed = texts.matched(re.compile(r".*[.,].*"))
        if not texts.take(np.flatnonzero(signed)).matched(ONE_COMMA).all():
            return None
        texts = texts.replaced(",", ".")
    found = texts.floats(~gaps)
    if found is not None:
        return found
    plain = ~gaps & (texts.matched(PLAIN) | texts.matched(INFINITE))
    other = np.flatnonzero(~gaps & ~plain)
    return None if texts.take(other).matched(NUMBER_LIKE).any() else texts.floats(plain)


def _with_points(texts: Texts, decimal: Style) -> Texts:
    """Texts, trimmed, numbers among them with a decimal point and without thousands."""
    cells, comma = texts.trimmed, decimal == "comma"
    signed = np.strings.find(cells, ",") >= 0
    if comma:
        signed |= np.strings.find(cells, ".") >= 0
    rows = np.flatnonzero(signed)
    if not rows.size:
        return texts
    pattern = re.compile(f"{COMMA_SURE.pattern}|{EITHER.pattern}") if comma else GROUPED_COMMAS
    rows = rows[texts.take(rows).matched(pattern)]
    found = cells.copy()
    plain = np.strings.replace(np.strings.replace(cells[rows], ".", ""), ",", ".") if comma else None
    found[rows] = np.strings.replace(cells[rows], ",", "") if plain is None else plain
    return Texts(found)


def _floats(texts: Texts) -> np.ndarray:
    """The numbers (N,) of texts; nan where a text is no plain number."""
    cells = np.where(texts.trimmed == "", "nan", texts.trimmed)
    if not (np.strings.find(cells, "_") >= 0).any():
        with contextlib.suppress(ValueError):
            return cells.astype(np.float64)
    plain = texts.matched(PLAIN) | texts.matched(INFINITE)
    numbers = np.full(len(texts), np.nan)
    numbers[plain] = texts.trimmed[plain].astype(np.float64)
    return numbers


def _number(text: str, decimal: Style) -> float:
    """The number of a text with signs of other alphabets, grouped by spaces, or with its minus behind it."""
    tidy = text.translate(NARROW).translate(MINUS).translate(WIDE)
    tidy = tidy.replace(" ", "") if GROUPED_SPACES.fullmatch(tidy) else tidy
    if decimal == "comma" and (COMMA_SURE.fullmatch(tidy) or EITHER.fullmatch(tidy)):
        tidy = tidy.replace(".", "").replace(",", ".")
    elif decimal != "comma" and GROUPED_COMMAS.fullmatch(tidy):
        tidy = tidy.replace(",", "")
    if tidy.endswith("-") and not tidy.startswith(("-", "+")):
        tidy = f"-{tidy[:-1]}" if decimal != "comma" else f"-{tidy[:-1].replace('.', '').replace(',', '.')}"
    return float(tidy) if PLAIN.fullmatch(tidy) else np.nan


def missing_value(numbers: np.ndarray) -> float | None:
    """The number that stands for a missing value: one of `SENTINELS`, farther from all others than these are wide."""
    known = numbers[np.isfinite(numbers)]
    if known.size < 3:
        return None
    for extreme in (float(known.max()), float(known.min())):
        rest = known[known != extreme]
        if abs(extreme) not in SENTINELS or not rest.size:
            continue
        if float(np.abs(rest - extreme).min()) > max(float(np.ptp(rest)), 0.5 * abs(extreme)):
            return extreme
    return None


@dataclass(frozen=True)
class Decorated:
    """Numbers (N,) of cells with letters; what the letters state: a unit, and the side of a positive number."""

    numbers: np.ndarray
    unit: str
    positive: str


def decorated(texts: Texts, name: str, style: Style) -> Decorated | None:
    """The numbers of cells such as `12.5 P`, `54.42N`, `12.3 kn`; None where most cells are of no such form."""
    if texts.arrow is not None:  # of which there may be as many different ones as rows
        known = ~texts.among(GAPS)
        if (known & texts.matched(DECORATED)).sum() < 0.9 * known.sum():
            return None
    kinds_of, codes = texts.coded()
    counts = np.bincount(codes, minlength=len(kinds_of))
    matches = [DECORATED.fullmatch(text.translate(MINUS)) for text in kinds_of]
    told = np.array([text.lower() not in GAPS for text in kinds_of])
    fits = np.array([match is not None for match in matches])
    if not told.any() or counts[told & fits].sum() < 0.9 * counts[told].sum():
        return None
    letters = [_letters(match) if match else "" for match in matches]
    kinds, sides = {kind for kind, t in zip(letters, told, strict=True) if t and kind}, sides_of(name)
    parts = {kind: _side_and_unit(kind, sides) for kind in kinds}
    units = {unit for _, unit in parts.values() if unit}
    if (
        len(units) > 1
        or not kinds
        or any(unit_of(unit) is None and unit != "%" and tidy(unit) not in TIME_WORDS for unit in units)
    ):
        return None
    plain = numbers_of(Texts([match["number"] if match else "" for match in matches]), style)
    stated = {side for side, _ in parts.values() if side}
    other = {kind for kind, (side, _) in parts.items() if side and side not in POSITIVE_SIDES}
    signs = np.where([kind in other for kind in letters], -1.0, 1.0)
    positive = "" if not stated else "east" if stated <= {*HEMISPHERES} else "starboard"
    return Decorated((plain * signs)[codes], units.pop() if units else "", positive)


def _letters(match: re.Match[str]) -> str:
    return f"{match['after'].strip()} {match['before'].strip()}".strip(" .").lower()


def _side_and_unit(letters: str, sides: Mapping[str, str]) -> tuple[str, str]:
    """(side, unit) of letters at a number, such as `p`, `kn`, `°p` and `deg/min s`; '' for what is not among them."""
    if letters in sides:
        return sides[letters], ""
    for i in range(1, len(letters)):
        unit, side = letters[:i].strip(), letters[i:].strip()
        if side in sides and not letters[i - 1 : i + 1].isalpha() and any(unit_of(unit, kind) for kind in OF_A_SIDE):
            return sides[side], unit
    return "", letters


@cache
def sides_of(name: str) -> dict[str, str]:
    """Letters at the numbers of a column of some name -> the side that they mean."""
    own = {*named(words(name)).may_be}

    def of(*sides: str) -> dict[str, str]:
        return {letters: side.split()[0] for side in sides for letters in word_groups("side_letters")[side]}

    earth, ship = of(*HEMISPHERES), of("port", "starboard")
    if own & ON_EARTH or (not own and re.search(r"\b(?:lat|lon)|n/s|e/w", name.lower())):
        return ship | earth
    return earth | ship | (of("port of a rudder", "starboard of a rudder") if own & TO_A_SIDE else {})


def angle_of(text: str) -> float:
    """Degrees, positive to north and east, of degrees and minutes with the letter of a hemisphere; nan for another
    text."""
    match = ANGLE.fullmatch(text.strip())
    side = sides_of("latitude").get(letters, "") if match and (letters := _letters(match)) else "north"
    if match is None or side not in HEMISPHERES:
        return np.nan
    degrees, minutes, rest = (float((match[k] or "0").replace(",", ".")) for k in ("degrees", "minutes", "seconds"))
    sign = 1.0 if side in POSITIVE_SIDES and match["sign"] != "-" else -1.0
    return sign * (degrees + minutes / 60.0 + rest / 3600.0)


# ---- Columns of texts, millions of cells in the memory of a file: stored as one array of numpy's variable-width
# texts, or of Arrow's where the file is plain (`plain_text`). Both give the same; Arrow's functions take a tenth
# of the time.

CHUNK = 50_000
"""Cells that are made Python texts at a time."""


class Texts(Sequence[str]):
    """The texts (N,) of a column.

    arrow : the same, trimmed, as an array of Arrow's, of ASCII characters without line breaks; None: not of Arrow.
    """

    def __init__(self, cells: Iterable[str] | np.ndarray) -> None:
        """cells : texts in any sequence, or an array (N,) of them."""
        self.arrow: Any = None
        self._stored: Any = None
        self.array: Any = np.asarray(cells if isinstance(cells, np.ndarray) else list(cells), dtype=StringDType())

    @classmethod
    def of_arrow(cls, cells: Any) -> Texts:
        """The texts (N,) of an array of Arrow's, of ASCII characters without line breaks; none is null."""
        self = cls.__new__(cls)
        self._stored, self.arrow = cells, compute().ascii_trim_whitespace(cells)
        return self

    @cached_property
    def array(self) -> Any:
        """The array (N,) of numpy's texts."""
        return np.array(self._stored.to_pylist(), dtype=StringDType())

    def __len__(self) -> int:
        return len(self.array if self.arrow is None else self.arrow)

    def __getitem__(self, index: Any) -> Any:
        """A text, or the texts of a slice."""
        if self.arrow is not None:
            return self._stored[index].to_pylist() if isinstance(index, slice) else self._stored[int(index)].as_py()
        return self.array[index].tolist() if isinstance(index, slice) else str(self.array[int(index)])

    def __iter__(self) -> Iterator[str]:
        return pieces(self.array if self.arrow is None else self._stored)

    def take(self, rows: Any) -> Texts:
        """The texts of some rows."""
        at = np.asarray(rows, dtype=np.int64)
        return Texts(self.array[at]) if self.arrow is None else Texts.of_arrow(self._stored.take(at))

    @cached_property
    def trimmed(self) -> Any:
        """The array (N,) without white space around the texts."""
        found = np.strings.strip(self.array)
        return self.array if np.array_equal(found, self.array) else found

    def trimmed_texts(self) -> Iterator[str]:
        """The texts without white space around them."""
        return pieces(self.trimmed if self.arrow is None else self.arrow)

    def unique(self) -> list[str]:
        """The different texts, trimmed, in the order of their first rows."""
        return list(dict.fromkeys(self.trimmed_texts())) if self.arrow is None else self.arrow.unique().to_pylist()

    def among(self, wanted: Iterable[str]) -> np.ndarray:
        """(N,) whether a text, trimmed and in lower case, is one of some."""
        known = frozenset(wanted)
        if self.arrow is None:
            return self.tested(lambda text: text.lower() in known)
        return mask_of_arrow(compute().is_in(compute().ascii_lower(self.arrow), value_set=arrow_texts(sorted(known))))

    def tested(self, function: Callable[[str], object]) -> np.ndarray:
        """(N,) whether a function of a text, trimmed, is true."""
        return np.fromiter(map(bool, map(function, self.trimmed_texts())), dtype=bool, count=len(self))

    def matched(self, pattern: re.Pattern[str]) -> np.ndarray:
        """(N,) whether a text, trimmed, is of a form as a whole: without look-around; its possessive quantifiers may be
        greedy ones without another result."""
        if self.arrow is None:
            return self.tested(pattern.fullmatch)
        # as Arrow's engine (RE2) writes it: without possessive quantifiers, group names, and numbered characters
        text = re.sub(r"(?<=[*+])\+|\?P<\w+>", "", pattern.pattern)
        text = re.sub(r"\\u([\da-f]{4})", lambda found: chr(int(found[1], 16)), text)
        text = f"{'(?i)' if pattern.flags & re.IGNORECASE else ''}^(?:{text})$"
        return mask_of_arrow(compute().match_substring_regex(self.arrow, text))

    @property
    def longest(self) -> int:
        """Characters of the longest of Arrow's texts."""
        return compute().max(compute().binary_length(self._stored)).as_py() or 0

    def moments(self) -> np.ndarray | None:
        """Seconds since 1970 (N,) of Arrow's texts of ISO 8601, in UTC where they state no zone; None where one is no
        such moment, or some state a zone."""
        import pyarrow

        for zone in (None, "UTC"):
            with contextlib.suppress(pyarrow.ArrowInvalid):
                kind = pyarrow.timestamp("ns", zone)
                self.arrow[:1].cast(kind)  # a refusal of all takes long
                whole, rest = np.divmod(np.from_dlpack(self.arrow.cast(kind).cast(pyarrow.int64())), 10**9)
                return whole + rest / 1e9
        return None

    def replaced(self, old: str, new: str) -> Texts:
        """Arrow's texts with one sign replaced by another."""
        return Texts.of_arrow(compute().replace_substring(self.arrow, old, new))

    def floats(self, which: np.ndarray) -> np.ndarray | None:
        """The numbers (N,) of those of Arrow's texts, which (N,), nan elsewhere; None where one is no number."""
        import pyarrow

        wanted = self.arrow if which.all() else compute().if_else(arrow_mask(which), self.arrow, None)
        try:
            return numbers_of_arrow(wanted.cast(pyarrow.float64()))
        except pyarrow.ArrowInvalid:
            return None

    def coded(self) -> tuple[list[str], np.ndarray]:
        """(the different texts, trimmed; (N,) the place of each row's text among them)."""
        if self.arrow is not None:
            found = self.arrow.dictionary_encode()
            return found.dictionary.to_pylist(), np.from_dlpack(found.indices).astype(np.int64)
        places: dict[str, int] = {}
        codes = (places.setdefault(text, len(places)) for text in self.trimmed_texts())
        rows = np.fromiter(codes, dtype=np.int64, count=len(self))
        return list(places), rows

    def mapped(self, function: Callable[[str], float]) -> np.ndarray:
        """(N,) numbers that a function makes of the texts, trimmed; it is called once for equal texts."""
        texts, codes = self.coded()
        return np.array([function(text) for text in texts], dtype=float)[codes] if texts else np.zeros(0)


def pieces(array: Any) -> Iterator[str]:
    """The texts of an array (N,), numpy's or Arrow's, made Python texts `CHUNK` at a time."""
    for start in range(0, len(array), CHUNK):
        yield from array[start : start + CHUNK].tolist()
