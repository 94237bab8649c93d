"""Manoeuvring indices as they are given: a file or a mapping, read and checked."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike, fspath
from typing import TYPE_CHECKING, Any

from ...datasets.grammar import DEGREE, KNOT
from ...datasets.indices import INITIAL_TURN
from ...datasets.manoeuvres import Manoeuvre, parse_manoeuvre
from ...models.errors import BadInput
from ...models.model import RudderGear

if TYPE_CHECKING:
    from .indices_file import Performed, Ship

CABLE = 185.2
"""Cable, m."""
SOLAS_RATE = 65.0 / 28.0 * DEGREE
"""Slowest rudder of SOLAS II-1/29: from 35 degrees to 30 degrees on the other side in 28 s, rad/s."""
STOP = 35.0 * DEGREE
"""Largest angle of most rudders, rad."""
DISTANCE_LENGTHS, SPEED_SHARE, RATE_SHARE = 0.1, 0.03, 0.05
OVERSHOOT, OVERSHOOT_SHARE = {"first_overshoot": 1.0 * DEGREE, "second_overshoot": 2.0 * DEGREE}, 0.1
"""Standard deviations where none is stated, assumptions: distances in ship lengths, the steady speed as a share of the
approach speed, the yaw rate as a share of itself, an overshoot, rad, or a share of itself if that is more."""
FEWEST = 3
"""Indices without which no model is fitted."""
CONSISTENT = 0.15
"""Largest difference between yaw rate and steady speed over radius, as a share."""
DISTANCES = {"advance": 1.0, "transfer": 1.0, "tactical_diameter": 1.0, "final_diameter": 0.5, "initial_turning": 1.0}
"""Name in the file -> metres of the index (`datasets.indices`) per metre given."""
NAMES = {"final_diameter": "steady_radius", "speed_ratio": "steady_speed", "yaw_rate": "steady_yaw_rate"}
"""Name in the file -> name of the index, where the two differ."""
FAR = {NAMES.get(name, name) for name in DISTANCES}
SHORTEST, LONGEST = 0.05, 50.0
"""Indices that are distances, and the ship lengths between which they lie."""
OF_KIND = {
    "turn": {*DISTANCES, "speed_ratio", "steady_speed", "yaw_rate"},
    "zigzag": {*OVERSHOOT, "initial_turning"},
}
"""Kind of manoeuvre -> indices that it has."""


@dataclass(frozen=True)
class GivenIndex:
    """One index.

    manoeuvre : text of the manoeuvre, to starboard;  key : as the file has it, with the unit;  name : of the index in
    `datasets.indices`;  value, accuracy : in the file's unit, nan where the index is not given;  si : SI units
    (m, m/s, rad, rad/s) of the index in one unit of the file.
    """

    manoeuvre: str
    key: str
    name: str
    value: float
    accuracy: float
    si: float


@dataclass(frozen=True)
class GivenShip:
    """A ship with her indices: length, m, approach speed, m/s, and steering gear."""

    name: str
    length_m: float
    speed_m_s: float
    gear: RudderGear
    indices: tuple[GivenIndex, ...]


def read_indices(source: Mapping[str, Any] | str | PathLike[str]) -> GivenShip:
    """The ship of a YAML or JSON file, or of a mapping with the same keys.

    Raises
    ------
    BadInput : a file that cannot be read, an unknown key, a number that no ship has, indices that contradict each
        other or do not belong to their manoeuvre, too few indices.
    """
    from ...models.yaml_file import checked, read_yaml
    from .indices_file import Ship

    place = "indices" if isinstance(source, Mapping) else fspath(source)
    content = dict(source) if isinstance(source, Mapping) else read_yaml(place, "a file of indices")
    try:
        return _ship(checked(Ship, content, place))
    except BadInput as error:
        raise BadInput(error.message, file=error.file or place, row=error.row, hint=error.hint) from None


def _ship(facts: Ship) -> GivenShip:
    speed = _one(facts, "speed", {"m_s": 1.0, "kn": KNOT})
    if speed is None:
        raise BadInput("no approach speed", hint="give speed_m_s or speed_kn")
    rate = SOLAS_RATE if facts.rudder_rate_deg_s is None else facts.rudder_rate_deg_s * DEGREE
    stop = STOP if facts.rudder_max_deg is None else facts.rudder_max_deg * DEGREE
    rows = [row for one in facts.indices for row in _rows(one, facts.length_m, speed[0] * speed[1], stop)]
    if len(rows) < FEWEST:
        hint = f"at least {FEWEST}: advance and tactical diameter of a turn with overshoots of a zigzag serve best"
        raise BadInput(f"{len(rows)} indices are too few for a model", hint=hint)
    keys = [(row.manoeuvre, row.name) for row in rows]
    twice = next((key for key in keys if keys.count(key) > 1 and not _sided(facts, key[0])), None)
    if twice:
        raise BadInput(f"{twice[1]} of {twice[0]} stands twice", hint="give a mean, or :port and starboard apart")
    return GivenShip(facts.name, facts.length_m, speed[0] * speed[1], RudderGear(stop, rate), tuple(rows))


def _sided(facts: Ship, text: str) -> bool:
    """Whether a manoeuvre stands once to each side."""
    sides = [parse_manoeuvre(one.manoeuvre).side for one in facts.indices if _to_starboard(one.manoeuvre) == text]
    return sorted(sides) == [-1, 1]


def _to_starboard(text: str) -> str:
    return text.removesuffix(":port")


def _one(facts: Any, name: str, units: Mapping[str, float]) -> tuple[float, float, str] | None:
    """Value, SI units in one unit, and key of a quantity that stands in at most one of its units."""
    keys = {f"{name}_{unit}" if unit else name: factor for unit, factor in units.items()}
    found = [(getattr(facts, key), factor, key) for key, factor in keys.items() if getattr(facts, key) is not None]
    if len(found) > 1:
        raise BadInput(f"{name} stands twice: {' and '.join(key for _, _, key in found)}", hint="leave one out")
    return found[0] if found else None


def units_of(name: str, length_m: float, speed_m_s: float) -> dict[str, float]:
    """Unit in a key of the file -> SI units of the index in it."""
    if name in DISTANCES:
        metres = DISTANCES[name]
        return {"m": metres, "lengths": metres * length_m, "cables": metres * CABLE}
    if name in OVERSHOOT:
        return {"deg": DEGREE}
    of_turn = {"speed_ratio": {"": speed_m_s}, "steady_speed": {"m_s": 1.0, "kn": KNOT}}
    return of_turn.get(name) or {"deg_s": DEGREE, "deg_min": DEGREE / 60.0}


def _rows(one: Performed, length_m: float, speed_m_s: float, stop_rad: float) -> list[GivenIndex]:
    """The indices of a manoeuvre; BadInput where they do not belong to it or contradict each other."""
    text = one.manoeuvre
    manoeuvre = parse_manoeuvre(text)
    if manoeuvre.kind not in OF_KIND or manoeuvre.euler:
        raise BadInput(f"manoeuvre {text!r} has no indices", hint="give turn:35 or zigzag:10/10, for example")
    if manoeuvre.values[0] > stop_rad + 1e-9:
        raise BadInput(f"{text}: the rudder goes over to {stop_rad / DEGREE:g} deg only", hint="see rudder_max_deg")
    rows: list[GivenIndex] = []
    for name in (*DISTANCES, "speed_ratio", "steady_speed", "yaw_rate", *OVERSHOOT):
        units = units_of(name, length_m, speed_m_s)
        found, accuracy = _one(one, name, units), _one(one.accuracy, name, units)
        if found is None and accuracy is None:
            continue
        if found is None or (accuracy is not None and accuracy[2] != found[2]):
            raise BadInput(f"{text}: an accuracy without the index, or in another unit: {accuracy and accuracy[2]}")
        _check_kind(manoeuvre, name, found[2])
        value, si, key = found
        usual = default_accuracy(name, value * si, length_m, speed_m_s) / si
        sd = usual if accuracy is None else accuracy[0]
        told = _to_starboard(manoeuvre.text)
        rows.append(GivenIndex(told, key, NAMES.get(name, name), value, sd, si))
    if not rows:
        hint = f"it has {', '.join(sorted(OF_KIND[manoeuvre.kind]))}"
        raise BadInput(f"{text}: no index is given", hint=hint)
    _check_consistent(text, rows, length_m, speed_m_s)
    return rows


def _check_kind(manoeuvre: Manoeuvre, name: str, key: str) -> None:
    if name not in OF_KIND[manoeuvre.kind]:
        hint = f"it has {', '.join(sorted(OF_KIND[manoeuvre.kind]))}"
        raise BadInput(f"{manoeuvre.text} has no {key}", hint=hint)
    reaches = manoeuvre.kind == "turn" or manoeuvre.values[1] >= INITIAL_TURN - 1e-9
    if name == "initial_turning" and not (math.isclose(manoeuvre.values[0], 10.0 * DEGREE) and reaches):
        hint = "it is defined by 10 deg of rudder and of heading: put it under turn:10 or zigzag:10/10"
        raise BadInput(f"{manoeuvre.text} has no {key}", hint=hint)


def default_accuracy(name: str, value: float, length_m: float, speed_m_s: float) -> float:
    """Standard deviation of an index, SI units, where none is stated; name and value in the file's sense."""
    if name in DISTANCES:
        return DISTANCES[name] * DISTANCE_LENGTHS * length_m
    if name in OVERSHOOT:
        return max(OVERSHOOT[name], OVERSHOOT_SHARE * value)
    return RATE_SHARE * value if name == "yaw_rate" else SPEED_SHARE * speed_m_s


def _check_consistent(text: str, rows: Sequence[GivenIndex], length_m: float, speed_m_s: float) -> None:
    """Refuse indices of a manoeuvre that no ship can have together."""
    si = {row.name: row.value * row.si for row in rows}
    if len(si) < len(rows):
        raise BadInput(f"{text}: the steady speed stands twice", hint="leave out speed_ratio or steady_speed")
    if si.get("transfer", 0.0) >= si.get("tactical_diameter", math.inf):
        raise BadInput(
            f"{text}: the transfer is not below the tactical diameter",
            hint="transfer is the distance at 90 degrees, tactical diameter that at 180",
        )
    if si.get("steady_speed", 0.0) > speed_m_s:
        raise BadInput(f"{text}: the steady speed is above the approach speed", hint="check speed_m_s and its unit")
    for row in rows:
        lengths = row.value * row.si / length_m
        if row.name in FAR and not SHORTEST < lengths < LONGEST:
            raise BadInput(f"{text}: {row.key} is {lengths:.3g} ship lengths", hint="check length_m and the unit")
    radius, speed, rate = (si.get(name, math.nan) for name in ("steady_radius", "steady_speed", "steady_yaw_rate"))
    if abs(rate * radius / speed - 1.0) > CONSISTENT:
        hint = "the yaw rate is twice the steady speed over the final diameter"
        raise BadInput(f"{text}: yaw rate, steady speed and final diameter contradict each other", hint=hint)
