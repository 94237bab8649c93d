"""Every cause, number and term that may explain free runs, as data.

Standard deviations and trial values are in natural units: s in ship lengths sailed (L/U), m/s in the ship's speed,
rad/s in U/L, forces in rho/2 L^2 U^2 and moments in rho/2 L^3 U^2.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...estimation.selection.number import Candidate, Number
from ...models.coefficient_groups import Group, every_own_number, grown, parts_of, stated_groups
from ..causes.base import Cause
from ..causes.base_coefficients import BaseCoefficients
from ..causes.registry import causes, causes_of
from ..free_runs.bank import Bank, Place, numbers_of, places_of, values_of
from .terms import term_of

if TYPE_CHECKING:
    from ...models.model import Model

DEGREE = np.pi / 180.0
INPUT, HULL, FORCE = 0, 1, 2
"""Ranks: faults of input and sensor go before numbers and terms of the hull, these before forces without a cause."""


class Row(NamedTuple):
    """A cause of one number: its prior standard deviation and trial values in the natural unit."""

    cause: str
    name: str
    kind: str
    entries: tuple[str, ...]
    unit: str
    sd: float
    trials: tuple[float, ...] = ()
    low: float = -np.inf
    needs: tuple[str, ...] = ()
    commanded: bool = False
    inverse: bool = False


DELAY = "rudder_delay"
"""The rudder acts so much later than it is recorded."""
ROWS = (
    Row(DELAY, DELAY, "steering", (DELAY,), "s", 0.5, (0.02, 0.05, 0.15), low=0.0),
    Row("rudder_rate_limit", "rudder_slowness", "steering", ("rudder_rate_limit",), "s", 40.0,
        (4.1, 1.9, 0.95, 0.48, 0.24), low=0.0, commanded=True, inverse=True),
    Row("rudder_saturation", "rudder_stop", "steering", ("rudder_saturation",), "1", 20.0,
        (1 / (8 * DEGREE), 1 / (15 * DEGREE), 1 / (25 * DEGREE)), low=0.0, commanded=True, inverse=True),
    Row("rudder_backlash", "rudder_backlash", "steering", ("rudder_backlash",), "1", 5 * DEGREE,
        (0.5 * DEGREE, 2.0 * DEGREE), low=0.0),
    Row("rudder_effectiveness", "rudder_effectiveness", "steering", ("rudder_effectiveness",), "1", 0.3, low=-0.95),
    Row("rudder_offset", "rudder_offset", "steering", ("rudder_offset",), "1", 2.0 * DEGREE),
    Row("yaw_rate_bias", "yaw_rate_bias", "sensor", ("yaw_rate_bias",), "rad/s", 0.05, needs=("r",)),
    Row("yaw_rate_scale", "yaw_rate_scale", "sensor", ("yaw_rate_scale",), "1", 0.2, needs=("r",)),
    Row("yaw_rate_delay", "yaw_rate_delay", "sensor", ("yaw_rate_delay",), "s", 0.3, low=0.0, needs=("r", "psi")),
    Row("heading_delay", "heading_delay", "sensor", ("heading_delay",), "s", 0.3, low=0.0, needs=("psi",)),
    Row("speed_scale", "speed_scale", "sensor", ("surge_scale", "sway_scale"), "1", 0.2, needs=("u",)),
    Row("velocity_delay", "velocity_delay", "sensor", ("surge_delay", "sway_delay"), "s", 0.3, low=0.0,
        needs=("u", "v")),
    Row("sway_offset", "sway_bias", "sensor", ("sway_bias",), "m/s", 0.05, needs=("v",)),
    Row("axis_misalignment", "axis_misalignment", "sensor", ("axis_misalignment",), "1", 5.0 * DEGREE,
        needs=("u", "v")),
)  # fmt: skip
"""Causes of rudder and sensors."""
OFFSET = next(row for row in ROWS if row.cause == "rudder_offset")
UNSTATED = 0.2
"""Standard deviation of a coefficient of which the family states none, as a share of it."""
FAULT, FAULT_SD = "rudder_fault", 0.3
FAULT_TIMES = np.linspace(0.15, 0.85, 40)
"""Times that are tried, as shares of the longest record: one at its start is a rudder that is weak throughout."""
FLOWS = {"current": (("north", "east"), 0, 0.1), "wind": (("north", "east"), 2, 1.5)}
"""Cause -> names of its numbers, column of the first, standard deviation in the ship's speed."""
FORCES = (("constant_X", 4, 2e-3), ("constant_Y", 5, 2e-3), ("constant_N", 6, 5e-4))
"""Steady forces in body axes: name, column of the environment's inputs, standard deviation."""
PUSH = ("constant_R", 0, 0.03)
"""The same of a response model: a steady yaw acceleration, in U/L to the order of its highest derivative."""
TERMS = {
    "yaw_damping_quadratic": (("added_Nr_absr", 6, 0.02),),
    "yaw_damping_cubic": (("added_Nrrr", 6, 0.02),),
    "sway_damping_quadratic": (("added_Yv_absv", 5, 0.5),),
    "crossflow_coupling": (("added_Yr_absv", 5, 0.3), ("added_Yv_absr", 5, 0.3), ("added_Nv_absr", 6, 0.1),
                           ("added_Nr_absv", 6, 0.1)),
}  # fmt: skip
"""Cause -> parameters of its extension, with the column of the force and the prior standard deviation."""


STARTS = {"second_order_lead": {"lag": {"lead": 1.0}, "half": {"lead": 0.5}}}
"""Extension -> kind -> points that its numbers are tried from where their slopes vanish: a pure lag, half a lead."""


class Facts(NamedTuple):
    """What the records offer: states that they measure, whether the rudder's angle is unknown, their number, and the
    duration of the longest one, s; whether the model's own numbers were identified from them, so that they are hardly
    restricted, or are stated to be exact; causes (ids) that the sensors' channels have decided on; and the standard
    deviation of the model's own numbers as a share of them, where it is stated."""

    measured: Collection[str]
    commanded: bool
    records: int
    longest_s: float
    identified: bool = False
    exact: bool = False
    decided: Collection[str] = ()
    coefficient_sd: float | None = None


def bank_of(model: Model, facts: Facts, length_s: float, only: Collection[str] | None) -> Bank:
    """The bank of a model with coefficients; only : causes (ids) that it is restricted to."""
    groups = stated_groups(model)
    whole = grown(model, groups) if groups else model
    groups = tuple(g for g in groups if g.extension != OFFSET.cause) or (_unstated(model),)
    pairs = [*_inputs(whole, facts, length_s), *_terms(whole, facts)]
    candidates, places = [c for c, _ in pairs], {n: p for _, own in pairs for n, p in own.items()}
    told = {c.of: c.of for c in candidates} | causes_of(model)
    numbers = values_of(whole)
    candidates += [c for g in groups for c in _of_group(g, numbers)]
    places = places_of(whole) | places
    own = {n.name: n for g in groups if g.extension is None for n in numbers_of(g, numbers)}
    if facts.coefficient_sd:
        own = {n: replace(x, sd=facts.coefficient_sd * abs(numbers[n])) for n, x in own.items() if numbers[n]}
    if facts.identified:
        barely = every_own_number(groups)
        own = {n.name: n for n in numbers_of(barely, numbers)}
    kept = [c for c in candidates if only is None or told.get(c.of, BaseCoefficients.id) in only]
    series = {name: term_of(name) for name, place in places.items() if place.kind == "term"}
    return Bank(whole, tuple(kept), tuple(own.values()), places, told, {g.id: g.title for g in groups}, series)


def _unstated(model: Model) -> Group:
    """The coefficients of a model whose family states no groups of them, by their sizes."""
    sd = {name: UNSTATED * abs(x) for name, x in zip(model.coordinates, model.coefficients.tolist(), strict=True) if x}
    return Group("coefficients", "the model's own coefficients", None, sd)


def _of_group(group: Group, values: Mapping[str, float]) -> Iterator[Candidate]:
    """A group, from each of the points that it is tried from, and each of its numbers alone."""
    whole = tuple(numbers_of(group, values))
    for kind, starts in STARTS.get(group.extension or "", {"": {}}).items() if group.sd else ():
        own = [replace(n, trial=starts.get(n.name)) for n in whole]
        yield Candidate(group.id, tuple(own), HULL, kind=kind)
    for part in parts_of(group):
        yield Candidate(part.id, tuple(numbers_of(part, values)), HULL, of=group.id)


def _inputs(model: Model, facts: Facts, length_s: float) -> Iterator[tuple[Candidate, dict[str, Place]]]:
    """Candidates of rudder, sensors and weather with the places of their numbers."""
    speed = model.speed_m_s if np.isfinite(model.speed_m_s) else 1.0
    unit = {"1": 1.0, "s": length_s, "m/s": speed, "rad/s": 1.0 / length_s}
    for row in ROWS:
        if not {*row.needs} <= {*facts.measured} or (row.commanded and not facts.commanded):
            continue
        if row.cause in facts.decided:
            continue
        cause = causes()[row.cause]
        if isinstance(cause, Cause) and not (facts.exact or cause.stands_beside_numbers(model.is_3dof)):
            continue
        place = {row.name: Place(row.kind, row.entries, inverse=row.inverse)}
        for trial in [unit[row.unit] * t for t in row.trials] or [None]:
            number = Number(row.name, unit[row.unit] * row.sd, low=unit[row.unit] * row.low, trial=trial)
            yield Candidate(row.cause, (number,), INPUT), place
    if not facts.identified:
        yield from _faults(facts.longest_s)
    if facts.records > 1:
        yield _own_neutral_angles(facts.records)
    if model.is_3dof:
        yield from _flows(model, facts, speed)
        yield from _forces(model, facts, length_s)


def _faults(longest_s: float) -> Iterator[tuple[Candidate, dict[str, Place]]]:
    """A rudder that loses a share of its force at some time of the records."""
    for time_s in (longest_s * FAULT_TIMES).tolist():
        name = f"{FAULT} after {time_s:.9g} s"
        place = Place("steering", (FAULT,), fixed=((f"{FAULT}_time", time_s),))
        yield Candidate(FAULT, (Number(name, FAULT_SD, low=-1.0),), INPUT, kind="time"), {name: place}


def _own_neutral_angles(records: int) -> tuple[Candidate, dict[str, Place]]:
    """A neutral rudder angle of each record's own."""
    places = {f"{OFFSET.name}:{r}": Place(OFFSET.kind, OFFSET.entries, record=r) for r in range(records)}
    return Candidate(OFFSET.cause, tuple(Number(name, OFFSET.sd) for name in places), INPUT), places


def _flows(model: Model, facts: Facts, speed: float) -> Iterator[tuple[Candidate, dict[str, Place]]]:
    """Steady current and wind: the same in all records, or each record's own."""
    for cause, (sides, first, sd) in FLOWS.items():
        if cause == "wind" and model.windage is None:
            continue
        for records in ((None,), range(facts.records)) if facts.records > 1 else ((None,),):
            places = {
                flow_name(cause, side, r): Place("flow", column=first + i, record=r)
                for r in records
                for i, side in enumerate(sides)
            }
            yield Candidate(cause, tuple(Number(name, sd * speed) for name in places), INPUT), places


def flow_name(cause: str, side: str, record: int | None) -> str:
    """Name of a component of a flow, of all records or of one."""
    return f"{cause}_towards_{side}" if record is None else f"{cause}_towards_{side}:{record}"


def forces_of(model: Model) -> tuple[tuple[str, int, float], ...]:
    """Steady forces in the axes of a model."""
    return FORCES if model.is_3dof else (PUSH,)


def force_units(model: Model, length_s: float) -> dict[str, float]:
    """Axis -> force of one at the approach speed: rho/2 L^2 U^2, N, and rho/2 L^3 U^2, N m; of a response model U/L to
    the order of its highest derivative, rad/s^k."""
    if not model.is_3dof:
        return {"R": length_s ** -(2 if model.states[0] == "r" else 3)}
    numbers = model.environment_numbers()
    length = numbers.get("L", numbers["wind_L"])
    unit = 0.5 * numbers["rho"] * length**2 * model.speed_m_s**2
    return {"X": unit, "Y": unit, "N": unit * length}


def _forces(model: Model, facts: Facts, length_s: float) -> Iterator[tuple[Candidate, dict[str, Place]]]:
    """Steady forces in body axes along which the motion is measured, each alone and all together."""
    units, shown = force_units(model, length_s), {"X": "u", "Y": "v"}
    own = [row for row in FORCES if shown.get(row[0][-1], "r") in {"r", *facts.measured}]
    places = {name: Place("flow", column=column) for name, column, _ in own}
    whole = tuple(Number(name, sd * units[name[-1]]) for name, _, sd in own)
    for numbers in (*((n,) for n in whole), *([whole] if len(whole) > 1 else [])):
        yield Candidate("constant_force", numbers, FORCE), places


def _terms(model: Model, facts: Facts) -> Iterator[tuple[Candidate, dict[str, Place]]]:
    """Terms that the model lacks, as forces along the measured motion."""
    known = {*model.coordinates}
    for cause, entries in TERMS.items() if model.is_3dof else ():
        own = [e for e in entries if "v" not in e[0] or "v" in facts.measured]
        places = {name: Place("term", (name,), column) for name, column, _ in own if name not in known}
        numbers = tuple(Number(name, sd) for name, _, sd in own if name in places)
        sets: Sequence[tuple[Number, ...]] = [(n,) for n in numbers]
        for chosen in (*sets, *([numbers] if len(numbers) > 1 else [])):
            yield Candidate(cause, chosen, HULL), places
