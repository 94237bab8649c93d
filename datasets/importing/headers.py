"""What a column's header states: its words, unit and sign convention, cut apart."""

from __future__ import annotations

import math
import re
import unicodedata
from dataclasses import dataclass
from functools import cache

from .names import named, words
from .quantities import NO_UNIT, SI, TIME_WORDS, LogUnit, quantities, tidy, unit_of, word_groups, word_list

BRACKETS = re.compile("[\\[({<\u3010\u3014]([^\\[\\](){}<>\u3010\u3011\u3014\u3015]*)[\\])}>\u3011\u3015]")
TAIL = re.compile(r"(?:,|;|\s/|:|\s(?=°)|\bin\b|\ben\b|\bi\b|\bem\b)\s*([^,;:]+)$")
"""A unit behind a comma, a colon or `in`, `en`, `i`, or one that begins with the sign of degrees."""
JOINT = (
    r"[\s_]*(?:=|:|\bto\b|\btowards?\b|\bis\b|\bist\b|\bnach\b|\bzu\b|\bvers\b|\ba\b|\bhacia\b|\btil\b|\bmot\b|\bpara\b|\bfor\b"
    r"|が|は|为|を|\bside\b|\bdown\b|\bup\b)*[\s_]*"
)
RAISED = re.compile(r"[\s_]*(?:side|hand)?[\s_]*(?:goes|is|side)?[\s_]*(?:up|rises|hoch|oben|haut|arriba|opp)(?![a-z])")
"""Words behind a side that say it is the upper one: of a roll angle the other side goes down."""
LOWERED = re.compile(r"[\s_]*(?:side|hand)?[\s_]*(?:goes|is|side)?[\s_]*(?:down|lower|unten|bas|abajo|ned)(?![a-z])")
"""Words behind a side that say it is the lower one, as a roll angle counts."""
PERCENT = ("%", "percent", "pct", "prozent", "‰", "porcentaje", "prosent", "パーセント")
WEST_SOUTH = re.compile(
    r"(west|south|\bw\b|\bs\b|ouest|sud|oeste|sur)\s*(=|is|:)?\s*(\+|positive)|(\+|positive)\s*(=|:|to|is|towards)?\s*(the\s+)?"
    r"(west|south|w\b|s\b|ouest|sud|oeste|sur)"
)
SCALED = re.compile(r"(?:x|\*|×)?\s*([0-9]*[.,]?[0-9]+(?:e[-+]?\d+)?)\s*(?:x|\*|×)?\s*([^\d].*)")
PART = re.compile(
    r"1\s*/\s*(?P<first>10{1,9})\s*(?P<behind>[^\d].*)|(?P<before>[^\d/]+)/\s*(?P<last>10{1,9})|deci[\s-]?(?P<tenth>.+)"
)
"""A tenth, hundredth, ... of a unit: `1/10 deg`, `deg/10`, `decidegrees`."""
SHARE = re.compile(r"(?:%|percent|pct|per cent)\s*(?:of|von)\s*([1-9]\d*(?:\.\d+)?)\s*([^\d\s]+)")
WHOLE = re.compile(r"100\s*(?:%|percent|pct|per cent)\s*(?:=|:|is|are)\s*([1-9]\d*(?:\.\d+)?)\s*([^\d\s]+).*")
"""A share of a size that is stated: `% of 35 deg`, `100 % = 35 deg`."""
REFERENCE = re.compile(r"(?<![a-z])(?:from\s+(?:the\s+)?(?:true\s+)?(?:north|east)|enu|ned)(?![a-z])", re.IGNORECASE)
"""Where a heading counts from, which is no part of its name."""


HEMISPHERE = re.compile(r"(?<![a-z])[nsew](?![a-z])", re.IGNORECASE)
"""A letter alone in the header of a latitude or longitude."""
TRUE = re.compile(r"((?i:°|deg|degs|degrees?))?[\s(]*(?:T|(?i:true))\)?")
"""What says of a direction that it counts from true north, alone or behind its unit."""
MAGNETIC = re.compile(r"((?i:°|deg|degs|degrees?))[\s(]*(?i:m|mag|magnetic)\)?|M|(?i:mag|magnetic)")
"""The unit of a direction that counts from magnetic north; a small m alone is a metre."""
TWICE = re.compile(r"^(.{2,}?)\s*:\s*\1(?=\s|[(\[]|$)")
"""A name that stands twice: `Heading Monitor: Heading Monitor (deg)` of programs that simulate flows."""
LABELS = re.compile(r"""\{\s*\w+\s*=~?\s*["']?[^{}]*\}""")
"""Labels of a series of measurements, which say of which sensor it is: `{sensor="gyro"}`."""
TIMES = re.compile(r"(?<![a-zA-Z0-9])[x×*]\s?(10{1,9})(?![\d.])")


@dataclass(frozen=True)
class ColumnHeader:
    """words : of the name, without unit and sign.  units : texts that state a unit.  suffixes : other ways to cut the
    words, each with the unit that its last words spell.  positive : side of a positive number, '' where none is stated.
    foreign : a unit that is stated and says no size.  unread : what stands at the place of a unit and is none that is
    known.  times : of `x10`, how many times the value the numbers are.
    """

    words: tuple[str, ...]
    units: tuple[str, ...]
    suffixes: tuple[tuple[tuple[str, ...], str], ...]
    positive: str
    foreign: str
    unread: str = ""
    times: float = 1.0

    def unit(self, dimension: str) -> tuple[LogUnit | None, float]:
        """(the unit of that dimension that is stated, what its numbers are multiplied with); None where none is."""
        for text in self.units:
            unit, factor = scaled_unit(text, dimension)
            if unit is not None:
                return unit, factor
        return None, 1.0


def read_header(name: str, unit: str = "") -> ColumnHeader:
    """The parts of a header; `unit` is what a row of units says."""
    name, unit = (unicodedata.normalize("NFKC", text).replace("\u2212", "-") for text in (name, unit))
    name = TWICE.sub(r"\1", LABELS.sub(" ", name).strip())
    positive, place = sign_stated(name)
    if positive:
        name = _without(name, *place)
        again, place = sign_stated(name)
        name = _without(name, *place).rstrip(" /,;") if again == positive else name
    elif unit:
        positive, place = sign_stated(f"({unit})")
        unit = _without(f"({unit})", *place).strip("() ") if positive else unit
    if _hemisphere(name, unit):
        name, unit = (HEMISPHERE.sub(" ", text) for text in (name, unit))
    times = TIMES.search(name)
    name = TIMES.sub(" ", name)
    pieces = [part.strip() for found in BRACKETS.findall(name) for part in re.split(r"[;,|]", found)]
    rest = BRACKETS.sub(" ", name)
    tail = TAIL.search(rest)
    if tail and says_unit(tail[1]):
        pieces.append(tail[1].strip())
        rest = rest[: tail.start()]
    pieces += [part.strip() for part in re.split(r"[;,|]", unit)]
    for i, piece in enumerate(pieces):  # `mph over ground`: what stands behind a unit belongs to the name
        own, _, more = piece.partition(" ")
        if more and not says_unit(piece) and unit_of(own) is not None and named(words(f"{rest} {more}")).may_be:
            rest, pieces[i] = f"{rest} {more}", own
    alone = REFERENCE.sub(" ", rest)
    if _means(alone, "heading", "heading_magnetic", "course_over_ground"):
        rest, pieces = alone, [REFERENCE.sub(" ", piece).strip() for piece in pieces]
        pieces = [(match[1] or "") if (match := TRUE.fullmatch(piece)) else piece for piece in pieces]
        magnetic = any(map(MAGNETIC.fullmatch, pieces))
        pieces = [(match[1] or "") if (match := MAGNETIC.fullmatch(piece)) else piece for piece in pieces]
        rest = f"{rest} mag" if magnetic and "mag" not in words(rest) else rest
    units = tuple(piece for piece in pieces if piece and says_unit(piece))
    other = [piece for piece in pieces if piece and not says_unit(piece)]
    sized = [text for text in units if _sized(text)]
    unread = "" if units else next((piece for piece in other if _is_unread(piece, rest)), "")
    known = words(" ".join([rest, *(piece for piece in other if piece != unread)]))
    foreign = next((text for text in units if not _sized(text) and tidy(text) not in TIME_WORDS | {"-", "--"}), "")
    suffixes = []
    for count in () if sized or foreign in PERCENT else (4, 3, 2, 1):  # `rot_deg_min`, `rate_deg_s_1`, `sog_kn`
        head, tail = known[:-count], known[-count:]
        texts = ("/".join(tail), "_".join(tail), "".join(tail))
        text = next((t for t in texts if unit_of(t) is not None or (count == 1 and t in PERCENT)), "")
        suffixes += [(head, text)] if head and len(tail) == count and text else []
    return ColumnHeader(known, tuple(units), tuple(suffixes), positive, "" if sized else foreign,
                  unread, float(times[1]) if times else 1.0)  # fmt: skip


def _is_unread(piece: str, name: str) -> bool:
    """Whether a text in brackets is a unit that is not known: it has a known unit in it, or no known word, also not as
    the end of a name such as `SPD(OG)`."""
    whole = named(words(f"{name} {piece}"))
    if whole.may_be and not whole.extra and set(whole.may_be) < set(named(words(name)).may_be or quantities()):
        return False
    parts = words(piece)
    known = word_list("harmless").union(word_list("command"), word_list("not_measured"), *word_groups("sides").values())
    strange = [part for part in parts if part not in known and not part.isdigit()]
    composed = re.search(r"[/^*\d]", piece) and any(unit_of(part) is not None for part in parts if len(part) > 1)
    return bool(composed) or bool(strange and not named(parts).may_be)


def _hemisphere(name: str, unit: str) -> str:
    """The letter n, s, e or w that stands alone in the header of a latitude or longitude; '' for none or several."""
    letters = HEMISPHERE.findall(f"{name} {unit}")
    if len(letters) != 1 or not _means(HEMISPHERE.sub(" ", name), "latitude", "longitude"):
        return ""
    return letters[0].lower()


def _means(text: str, *kinds: str) -> bool:
    """Whether a name, without what stands in its brackets, can mean one of these quantities."""
    return not set(named(words(BRACKETS.sub(" ", text))).may_be).isdisjoint(kinds)


def _sized(text: str) -> bool:
    return scaled_unit(text)[0] is not None or tidy(text) == SI


def says_unit(text: str) -> bool:
    """Whether a text is a unit of any kind."""
    return _sized(text) or tidy(text) in TIME_WORDS or tidy(text) in NO_UNIT


def scaled_unit(text: str, dimension: str | None = None) -> tuple[LogUnit | None, float]:
    """(unit, factor) of `deg`, `0.1 deg`, `1/10 deg`, `1e-7 deg`; (None, 1) where it is no unit (of that dimension)."""
    place = re.fullmatch(r"(°|deg|degrees)\s*(?:([ew]|n)|\s(s))", text.strip().lower())
    unit = unit_of(place[1] if place else text, dimension)
    if unit is not None:
        return unit, 1.0
    part = PART.fullmatch(text.strip().lower())
    if part is not None:
        unit = unit_of(part["behind"] or part["before"] or part["tenth"], dimension)
        return (unit, 1.0 / float(part["first"] or part["last"] or 10)) if unit is not None else (None, 1.0)
    share = SHARE.fullmatch(text.strip().lower()) or WHOLE.fullmatch(text.strip().lower())
    if share is not None:
        return (unit, 0.01 * float(share[1])) if (unit := unit_of(share[2], dimension)) is not None else (None, 1.0)
    match = SCALED.fullmatch(text.strip().lower())
    inner = unit_of(match[2], dimension) if match else None
    if match is None or inner is None:
        return None, 1.0
    factor = float(match[1].replace(",", "."))
    power = math.log10(factor) if 0.0 < factor < math.inf else 0.0
    return (inner, factor) if power and abs(power - round(power)) < 1e-9 else (None, 1.0)


@cache
def _patterns() -> tuple[re.Pattern[str], ...]:
    """Patterns of a sign convention, each with the groups `sign` and `side`."""
    sides = "|".join(sorted((re.escape(w) for s in word_groups("sides").values() for w in s), key=len, reverse=True))
    signs = word_list("positive") | word_list("negative")
    strong = "|".join(sorted((re.escape(w) for w in signs if w not in ("pos", "neg")), key=len, reverse=True))
    side = rf"(?<![a-z])(?P<side>{sides})(?![a-z])"
    sign = rf"(?P<sign>(?<![a-z])(?:{strong})(?![a-z])|\+)"
    weak = r"(?P<sign>\b(?:pos|neg)\b\.?|-)"
    return (
        re.compile(rf"{sign}{JOINT}{side}"),
        re.compile(rf"{side}{JOINT}{sign}"),
        re.compile(rf"(?:(?<=[\[(,;/])\s*){weak}{JOINT}{side}"),
        re.compile(rf"(?<=[\[(,;/])\s*{side}[\s]*(?:=|:|is|ist)?\s*{weak}(?=[\s\]),;/]|$)"),
        re.compile(rf"{weak}\s*=\s*{side}"),
    )


def sign_stated(text: str) -> tuple[str, tuple[int, int]]:
    """(side of a positive number, where in the text that is said); ('', (0, 0)) where nothing is."""
    plain = _same_length(text)
    for pattern in _patterns():
        match = pattern.search(plain)
        if match:
            word, sign = match["side"], match["sign"].strip()
            side = next(side for side, known in word_groups("sides").items() if word in known)
            negative = sign == "-" or sign.rstrip(".") in word_list("negative")
            raised = RAISED.match(plain, match.end("side"))
            behind = raised or LOWERED.match(plain, match.end("side"))
            stop = max(match.end(), behind.end() if behind else 0)
            other = "port" if side == "starboard" else "starboard"
            return (other if negative != bool(raised) else side), (match.start(), stop)
    turning = re.search(r"(?<![a-z])(ccw|counter-?clockwise|anti-?clockwise|cw|clockwise)(?![a-z])", plain)
    if turning:
        return ("starboard" if turning[1] in ("cw", "clockwise") else "port"), turning.span()
    return "", (0, 0)


def _same_length(text: str) -> str:
    """The text in lower case and without accents, every letter at its place."""
    latin = (letter if letter > "\u2fff" else unicodedata.normalize("NFD", letter)[0] for letter in text)
    return "".join(letter.lower() for letter in latin).replace("ø", "o")


def _without(text: str, start: int, stop: int) -> str:
    """The text without a statement, and without what the other side is said to be behind it."""
    rest = text[stop:]
    more = re.match(r"\s*[/,;]\s*[^\s\])]*[-+−][^\])]*", rest)
    return text[:start] + " " + (rest[more.end() :] if more else rest)


def west_or_south(name: str, unit: str) -> bool:
    """Whether it is stated that a longitude counts to the west, or a latitude to the south."""
    if letter := _hemisphere(name, unit):
        return letter in "ws"
    text = _same_length(f"{name} {unit}")
    return bool(WEST_SOUTH.search(text) or re.search(r"(°|\bdeg)\s*[ws]\b", text))
