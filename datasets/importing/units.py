"""Units of raw logs: their spellings, dimensions and factors to SI units and radians."""

from __future__ import annotations

import math
import re
import unicodedata
from dataclasses import dataclass

from ..grammar import DEGREE, KNOT
from .quantities import word_groups, word_list


@dataclass(frozen=True)
class LogUnit:
    """A unit: its name in mapping files, dimension, factor to SI (radians) and the spellings of logs."""

    name: str
    dimension: str
    factor: float
    spellings: frozenset[str]


UNITS: dict[str, LogUnit] = {
    name: LogUnit(name, dimension, factor, word_groups("units")[name])
    for name, dimension, factor in (
        ("rad", "angle", 1.0),
        ("deg", "angle", DEGREE),
        ("gon", "angle", math.pi / 200.0),
        ("mrad", "angle", 1e-3),
        ("cdeg", "angle", 0.01 * DEGREE),
        ("1e-7 deg", "angle", 1e-7 * DEGREE),
        ("deg min", "angle", DEGREE),
        ("rad/s", "angular rate", 1.0),
        ("deg/s", "angular rate", DEGREE),
        ("mrad/s", "angular rate", 1e-3),
        ("deg/min", "angular rate", DEGREE / 60.0),
        ("rad/min", "angular rate", 1.0 / 60.0),
        ("deg/h", "angular rate", DEGREE / 3600.0),
        ("m/s", "speed", 1.0),
        ("kn", "speed", KNOT),
        ("km/h", "speed", 1.0 / 3.6),
        ("cm/s", "speed", 0.01),
        ("mm/s", "speed", 0.001),
        ("mph", "speed", 0.44704),
        ("ft/s", "speed", 0.3048),
        ("m/min", "speed", 1.0 / 60.0),
        ("m", "length", 1.0),
        ("km", "length", 1000.0),
        ("cm", "length", 0.01),
        ("mm", "length", 0.001),
        ("nmi", "length", 1852.0),
        ("ft", "length", 0.3048),
        ("rps", "rotation", 1.0),
        ("rpm", "rotation", 1.0 / 60.0),
        ("rad/s shaft", "rotation", 1.0 / math.tau),
        ("N", "force", 1.0),
        ("kN", "force", 1000.0),
    )
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


CANDIDATES = {
    "angle": ("deg", "rad"),
    "angular rate": ("deg/s", "deg/min", "rad/s"),
    "speed": ("kn", "m/s", "km/h"),
    "length": ("m", "km", "ft", "mm"),
    "rotation": ("rpm", "rps"),
    "force": ("N", "kN"),
}
"""Dimension -> units that a column without a unit may be in, the likeliest first."""


def candidates(dimension: str) -> tuple[LogUnit, ...]:
    """The units of a dimension that a column without a unit may be in."""
    return tuple(UNITS[name] for name in CANDIDATES[dimension])
