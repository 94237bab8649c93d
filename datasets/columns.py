"""The columns of a record: canonical names with their units, and the other units that are converted on reading."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from ..models.errors import BadInput
from ..models.number_texts import DECIMAL
from ..models.suggestions import near

NUMBER = re.compile(rf"{DECIMAL}|[+-]?inf(inity)?", re.ASCII | re.IGNORECASE)

# Every column of a record with its unit, in the order in which it is written.
CANONICAL: dict[str, str] = {
    "time_s": "s",
    "rudder_command_rad": "rad",
    "rudder_rad": "rad",
    "propeller_rps": "1/s",
    "propeller_thrust_N": "N",
    "thrust_port_N": "N",
    "thrust_starboard_N": "N",
    "heading_rad": "rad",
    "yaw_rate_rad_s": "rad/s",
    "surge_m_s": "m/s",
    "sway_m_s": "m/s",
    "north_m": "m",
    "east_m": "m",
    "roll_rad": "rad",
    "roll_rate_rad_s": "rad/s",
    "wind_speed_m_s": "m/s",
    "wind_direction_rad": "rad",
    "current_speed_m_s": "m/s",
    "current_direction_rad": "rad",
}
RUDDERS = ("rudder_rad", "rudder_command_rad")
HEADING = "heading_rad"
TURN, VELOCITIES, POSITIONS = (HEADING, "yaw_rate_rad_s"), ("surge_m_s", "sway_m_s"), ("north_m", "east_m")
TRACK = (HEADING, *VELOCITIES, *POSITIONS)
TWIN = ("thrust_port_N", "thrust_starboard_N")
"""Thrust of two fixed propellers or its command: without a rudder their difference, N, is the steering command."""
SURROUNDINGS = ("wind_speed_m_s", "wind_direction_rad", "current_speed_m_s", "current_direction_rad")
INPUTS = (*RUDDERS, "propeller_rps", *TWIN, *SURROUNDINGS)
"""Columns of what acts on the craft."""

# unit -> {suffix of an accepted name: factor}, the canonical suffix first
UNITS: dict[str, dict[str, float]] = {
    "s": {"s": 1.0, "ms": 1e-3},
    "rad": {"rad": 1.0, "deg": math.pi / 180.0},
    "rad/s": {"rad_s": 1.0, "deg_s": math.pi / 180.0},
    "m/s": {"m_s": 1.0, "kn": 1852.0 / 3600.0, "ms": 1.0},
    "1/s": {"rps": 1.0, "rpm": 1.0 / 60.0},
    "m": {"m": 1.0},
    "N": {"N": 1.0, "kN": 1e3},
}


QUANTITIES: dict[str, dict[str, tuple[str, float]]] = {
    quantity: {f"{quantity}_{suffix}": (channel, factor) for suffix, factor in UNITS[unit].items()}
    for channel, unit in CANONICAL.items()
    for quantity in (channel.removesuffix("_" + next(iter(UNITS[unit]))),)
}
"""Quantity (a canonical name without its unit) -> {accepted name: (canonical name, factor)}."""
ACCEPTED = {name: meaning for spellings in QUANTITIES.values() for name, meaning in spellings.items()}


def in_order(names: Iterable[str]) -> list[str]:
    """The columns named, in the order of `CANONICAL`."""
    return sorted(names, key=list(CANONICAL).index)


def to_canonical(columns: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Columns (N,) under accepted names as columns in SI units and radians under canonical names, in their order.

    The thrusts of two propellers alone give the steering command, port less starboard, N.
    """
    found = {ACCEPTED[name][0]: (values, ACCEPTED[name][1]) for name, values in columns.items()}
    converted = {name: values if factor == 1.0 else values * factor for name, (values, factor) in found.items()}
    if not set(RUDDERS) & set(converted) and set(TWIN) <= set(converted):
        converted[RUDDERS[1]] = converted[TWIN[0]] - converted[TWIN[1]]
    return {name: converted[name] for name in in_order(converted)}


def check_header(names: Sequence[str], file: object, row: int | None = None) -> None:
    """Refuse names that are not accepted or not distinct, or that lack the time or every channel.

    Raises
    ------
    BadInput : naming `file`, `row` and the column.
    """
    for number, name in enumerate(names, start=1):
        if name not in ACCEPTED:
            message, hint = _why_unknown(name, number, alone=len(names) == 1)
            raise BadInput(message, file=file, row=row, column=name or None, hint=hint)
    channels = [ACCEPTED[name][0] for name in names]
    for index, channel in enumerate(channels):
        if channel in channels[:index]:
            first = names[channels.index(channel)]
            message = "the column appears twice" if first == names[index] else f"the same quantity as {first}"
            raise BadInput(message, file=file, row=row, column=names[index], hint="keep one of them")
    if "time_s" not in channels:
        raise BadInput("missing column", file=file, row=row, column="time_s", hint="every record needs its time")
    if len(channels) == 1:
        raise BadInput("no channel beside the time", file=file, row=row, hint=f"known are {', '.join(CANONICAL)}")


def _why_unknown(name: str, number: int, alone: bool) -> tuple[str, str]:
    """(message, hint) for a column name that is not accepted."""
    if not name:
        return f"column {number} has no name", "name it, or remove the separator at the end of the line"
    if NUMBER.fullmatch(name):
        return "there is a number where the header should be", "name the columns in the first line"
    if alone and len(re.split(r"[\s|:]+", name)) > 1:
        return "no separator found in the header", "separate the columns by comma, semicolon or tab"
    quantities = [q for q in QUANTITIES if f"{name.lower()}_".startswith(f"{q}_")]
    if quantities and name.lower() not in ACCEPTED:
        quantity = max(quantities, key=len)
        unit = name[len(quantity) + 1 :]
        accepted = ", ".join(QUANTITIES[quantity])
        return (f"unknown unit {unit!r}" if unit else "the unit is missing"), f"accepted: {accepted}"
    from .importing.headers import read_header
    from .importing.names import named

    # a slip in a name that ends in the same unit: another quantity is none
    suffixes = [suffix for units in UNITS.values() for suffix in units]
    own = max((u for u in suffixes if name.lower().endswith(f"_{u.lower()}")), key=len, default="")
    slip = near(name, [known for known in ACCEPTED if own and known.endswith(f"_{own}")], cutoff=0.85)
    header = read_header(name)
    known = [found for words in (header.words, *(head for head, _ in header.suffixes)) for found in named(words).may_be]
    said = f"{known[0].replace('_', ' ')}? " if known else ""
    return "unknown column", slip or f"{said}accepted: {', '.join(CANONICAL)}; 'helmbench import' reads raw logs"
