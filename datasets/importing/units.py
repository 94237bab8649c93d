"""Units of raw logs: their spellings, dimensions and factors to SI units and radians."""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass

from .quantities import vocabulary, word_list


@dataclass(frozen=True)
class LogUnit:
    """A unit: its name in mapping files, dimension, factor to SI (radians) and the spellings of logs."""

    name: str
    dimension: str
    factor: float
    spellings: frozenset[str]


UNITS = {
    name: LogUnit(name, facts["dimension"], facts["factor"], frozenset(facts["names"].split()))
    for name, facts in vocabulary()["units"].items()
}
TIME_WORDS, NO_UNIT = word_list("time_units"), word_list("no_unit")
"""Units of times; units of columns that are no channel, or that say no size."""
SUPERSCRIPTS = str.maketrans("⁻⁰¹²³", "-0123")
PER_TIME = re.compile(
    r"(deg|degs|degrees?|°|rad|mrad|m|km|cm|mm|nmi|nm|r|rev|u|tr|grad)[-_.·* ]*(s|sec|min|h|hr)[-_^. ]*-?1"
)
"""A unit of a rate with its denominator as a power: deg s-1, m.s^-1, deg_s_1."""


def tidy(text: str) -> str:
    """A unit's text without brackets, spaces and signs of multiplication, in lower case."""
    text = unicodedata.normalize("NFKC", text.translate(SUPERSCRIPTS)).strip().strip("[](){}<>").lower()
    text = text.replace("º", "°").replace("˚", "°").replace("\u2212", "-").replace("^", "").replace("∘", "°")
    text = re.sub(" (?:per|pro|par|por) |_per_", "/", text)
    power = PER_TIME.fullmatch(text.strip())
    text = f"{power[1]}/{power[2]}" if power else re.sub(r"\s+|\*|·|⋅", "", text)
    text = text.replace("persecond", "/s").replace("perminute", "/min").replace("seconds", "s").replace("second", "s")
    return text.replace("minutes", "min").replace("minute", "min").replace("//", "/")


def unit_of(text: str, dimension: str | None = None) -> LogUnit | None:
    """The unit that a text spells, of the dimension if one is given; None where it spells none."""
    spelt = tidy(text)
    able = (unit for unit in UNITS.values() if spelt in unit.spellings)
    return next((unit for unit in able if dimension in (None, unit.dimension)), None)


def candidates(dimension: str) -> tuple[LogUnit, ...]:
    """The units of a dimension that a column without a unit may be in, the likeliest first."""
    return tuple(UNITS[name] for name in vocabulary()["dimensions"][dimension]["units"])
