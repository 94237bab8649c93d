"""What a column of a log can be: quantities with their dimensions, the words of headers, read from `words.yaml`, and
units."""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from ...models.data_file import load

RATE_OF = {"heading": "yaw_rate", "roll": "roll_rate"}
"""Quantity -> what a column of its name is that has the unit of a rate."""


@dataclass(frozen=True)
class Quantity:
    """A quantity, as the head of `words.yaml` explains: its dimension, names, and what else is known of it."""

    dimension: str
    names: tuple[str, ...]
    short: tuple[str, ...] = ()
    wraps: bool = False
    unsigned: bool = False
    convention: str = ""
    turned: str = ""
    channel: str = ""
    partner: str = ""
    unused: str = ""
    unknown_to_ais: tuple[float, ...] = ()
    unit_of_ais: str = ""


@cache
def vocabulary() -> dict[str, Any]:
    """What `words.yaml` holds; it explains itself."""
    return load(Path(__file__).with_name("words.yaml"))


def names_in(text: str) -> tuple[str, ...]:
    """The names of a list, separated by bars."""
    return tuple(name.strip() for name in text.split("|") if name.strip())


def _quantity(entry: dict[str, Any]) -> Quantity:
    facts: dict[str, Any] = {
        **entry,
        "names": tuple(name for text in entry["names"].values() for name in names_in(text)),
        "short": names_in(entry.get("short", "")),
        "unknown_to_ais": tuple(entry.get("unknown_to_ais", ())),
    }
    return Quantity(**facts)


@cache
def quantities() -> dict[str, Quantity]:
    """Name of a quantity -> the quantity."""
    return {name: _quantity(entry) for name, entry in vocabulary()["quantities"].items()}


def is_unsigned(quantity: str | None) -> bool:
    """Whether a quantity has no sign, or one that its name states."""
    return quantity is not None and quantities()[quantity].unsigned


@cache
def vague_names() -> dict[str, tuple[str, ...]]:
    """Names that stand for more than one quantity -> those, likeliest first."""
    return {name: tuple(entry["may_be"]) for entry in vocabulary()["vague"] for name in names_in(entry["names"])}


def name_list(kind: str) -> tuple[str, ...]:
    """The names of a list: time, date, week (the number of a GPS week), other_motions, which are none of a record's,
    and those of columns that say of which instrument, device or kind a row is, its value and its unit."""
    return names_in(vocabulary()[kind])


@cache
def word_list(kind: str) -> frozenset[str]:
    """The words of a list: command, not_measured, harmless, actuators, counters, positive, negative, time_units,
    no_unit, beside_scale, and mathematical, which are of a heading and do not state which way it counts."""
    return frozenset(vocabulary()[kind].split())


@cache
def word_groups(kind: str) -> dict[str, frozenset[str]]:
    """Name -> its words: of sides, and of letters that mean them."""
    return {name: frozenset(text.split()) for name, text in vocabulary()[kind].items()}


# ---- Units of raw logs: their spellings, dimensions and factors to SI units and radians.


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
SI = "si"
"""What says of all units that they are those of SI, angles in radians."""
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
    """The unit that a text spells, of the dimension if one is given (SI: that of it); None where it spells none."""
    spelt = tidy(text)
    of_si = spelt == SI and dimension is not None
    able = (unit for unit in UNITS.values() if spelt in unit.spellings or (of_si and unit.factor == 1.0))
    return next((unit for unit in able if dimension in (None, unit.dimension)), None)


def candidates(dimension: str) -> tuple[LogUnit, ...]:
    """The units of a dimension that a column without a unit may be in, the likeliest first."""
    return tuple(UNITS[name] for name in vocabulary()["dimensions"][dimension]["units"])
