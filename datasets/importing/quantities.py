"""What a column of a log can be: quantities with their dimensions, and the words of headers, read from `words.yaml`."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from ...models.data_file import load

NOT_USED_AS = {
    "speed_through_water": "a speed through the water is none over ground: map it to surge where there is no current",
}
"""Quantities that are recognised and become no channel, and why."""
RATE_OF = {"heading": "yaw_rate", "roll": "roll_rate"}
"""Quantity -> what a column of its name is that has the unit of a rate."""


@dataclass(frozen=True)
class Quantity:
    """A quantity: its dimension, whole names, symbols that count only as a whole name, and whether it may pass the
    full turn."""

    dimension: str
    names: tuple[str, ...]
    short: tuple[str, ...]
    wraps: bool


@cache
def _words() -> dict[str, Any]:
    return load(Path(__file__).with_name("words.yaml"))


def _names(text: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in text.split("|") if name.strip())


def _quantity(entry: dict[str, Any]) -> Quantity:
    names = tuple(name for text in entry["names"].values() for name in _names(text))
    return Quantity(entry["dimension"], names, _names(entry.get("short", "")), entry.get("wraps", False))


@cache
def quantities() -> dict[str, Quantity]:
    """Name of a quantity -> the quantity."""
    return {name: _quantity(entry) for name, entry in _words()["quantities"].items()}


@cache
def vague_names() -> dict[str, tuple[str, ...]]:
    """Names that stand for more than one quantity -> those, likeliest first."""
    return {name: tuple(entry["may_be"]) for entry in _words()["vague"] for name in _names(entry["names"])}


def name_list(kind: str) -> tuple[str, ...]:
    """The names of a list: time, date, week (the number of a GPS week), and other_motions, which are none of a
    record's."""
    return _names(_words()[kind])


@cache
def time_parts() -> dict[str, tuple[str, ...]]:
    """Part of a time, from the year to the second -> names of its column."""
    return {part: _names(text) for part, text in _words()["time_parts"].items()}


@cache
def word_list(kind: str) -> frozenset[str]:
    """The words of a list: command, not_measured, harmless, actuators, counters, positive, negative, and mathematical,
    which are of a heading and do not state which way it counts."""
    return frozenset(_words()[kind].split())


@cache
def side_words() -> dict[str, frozenset[str]]:
    """Side -> words for it."""
    return {side: frozenset(text.split()) for side, text in _words()["sides"].items()}
