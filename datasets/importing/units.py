"""Units of raw logs: their spellings, dimensions and factors to SI units and radians."""

from __future__ import annotations

import re
from dataclasses import dataclass

from ..grammar import DEGREE, KNOT


@dataclass(frozen=True)
class Unit:
    """A unit: its name in mapping files, dimension, factor to SI (radians) and the spellings of logs."""

    name: str
    dimension: str
    factor: float
    spellings: tuple[str, ...]


_ALL = (
    Unit("rad", "angle", 1.0, ("rad", "radian", "radians", "radiant")),
    Unit(
        "deg", "angle", DEGREE, ("deg", "degs", "degree", "degrees", "grad", "°", "degt", "degm", "°t", "°m", "degtrue")
    ),
    Unit("deg min", "angle", DEGREE, ("ddmm.mmm", "dd°mm.mmm'", "dms")),
    Unit("rad/s", "angular rate", 1.0, ("rad/s", "rads/s", "rads", "radpers", "radiansps", "rad/sec", "1/s")),
    Unit("deg/s", "angular rate", DEGREE, ("deg/s", "degs/s", "°/s", "deg/sec", "degps", "dps", "°/sec", "grad/s")),
    Unit(
        "deg/min",
        "angular rate",
        DEGREE / 60.0,
        ("deg/min", "degs/min", "°/min", "degpmin", "degmin", "dpm", "grad/min", "°/m", "degreesperminute"),
    ),
    Unit("m/s", "speed", 1.0, ("m/s", "m/sec", "ms", "mps", "ms-1", "m/s.", "meter/s")),
    Unit("kn", "speed", KNOT, ("kn", "kt", "kts", "knot", "knots", "knoten", "kns", "sm/h")),
    Unit("km/h", "speed", 1.0 / 3.6, ("km/h", "kmh", "kph", "kmph")),
    Unit("cm/s", "speed", 0.01, ("cm/s", "cm/sec")),
    Unit("mm/s", "speed", 0.001, ("mm/s", "mm/sec")),
    Unit("m", "length", 1.0, ("m", "meter", "metre", "meters", "metres")),
    Unit("km", "length", 1000.0, ("km",)),
    Unit("cm", "length", 0.01, ("cm",)),
    Unit("mm", "length", 0.001, ("mm",)),
    Unit("nmi", "length", 1852.0, ("nmi", "nm", "sm", "nauticalmiles")),
    Unit("ft", "length", 0.3048, ("ft", "feet")),
    Unit("rps", "rotation", 1.0, ("rps", "1/s", "hz", "rev/s", "r/s")),
    Unit("rpm", "rotation", 1.0 / 60.0, ("rpm", "1/min", "u/min", "rev/min", "r/min", "min-1", "/min")),
    Unit("N", "force", 1.0, ("n",)),
    Unit("kN", "force", 1000.0, ("kn",)),
)
UNITS: dict[str, Unit] = {unit.name: unit for unit in _ALL}
TIME_WORDS = frozenset(
    [
        "s",
        "sec",
        "secs",
        "second",
        "seconds",
        "sek",
        "sekunden",
        "ms",
        "msec",
        "millis",
        "us",
        "ns",
        "min",
        "h",
        "utc",
        "gmt",
        "hh:mm:ss",
        "hh:mm:ss.fff",
        "hhmmss",
        "iso",
        "iso8601",
        "epoch",
        "unix",
        "dd.mm.yyyy",
        "yyyy-mm-dd",
        "days",
        "datum",
        "local",
        "lt",
    ]
)
NO_UNIT = frozenset(
    {"-", "--", "none", "n/a", "1", "[-]", "%", "bool", "v", "a", "hpa", "mbar", "c", "°c", "degc", "l/h"}
)
"""Units of columns that are no channel; a row of units holds them beside those above."""


def tidy(text: str) -> str:
    """A unit's text without brackets, spaces and signs of multiplication, in lower case."""
    text = text.strip().strip("[](){}<>").lower().replace("º", "°").replace("\u2212", "-").replace("^", "")
    text = re.sub(r"\s+|\*|·|⋅", "", text.replace(" per ", "/"))
    return text.replace("persecond", "/s").replace("perminute", "/min").replace("s-1", "/s").replace("//", "/")


def unit_of(text: str, dimension: str | None = None) -> Unit | None:
    """The unit that a text spells, of the dimension if one is given; None where it spells none."""
    spelt = tidy(text)
    found = [unit for unit in _ALL if spelt in unit.spellings and dimension in (None, unit.dimension)]
    return found[0] if found else None


def is_unit(text: str) -> bool:
    """Whether a text is a unit of any kind: one of these, a unit of time, or of columns that are no channel."""
    return unit_of(text) is not None or tidy(text) in TIME_WORDS or tidy(text) in NO_UNIT


def candidates(dimension: str) -> tuple[Unit, ...]:
    """The units of a dimension that a column without a unit may be in."""
    return tuple(unit for unit in _ALL if unit.dimension == dimension and unit.name != "deg min")
