"""Every cause, number and term that may explain free runs of one model, as the causes' rows have them.

Standard deviations and trial values are in natural units (`checks.base.Prior`), forces in rho/2 L^2 U^2 and moments in
rho/2 L^3 U^2.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...checks.base import SensorError
from ...estimation.selection.number import Candidate, Number
from ...models.coefficient_groups import Group, every_own_number, grown, parts_of, stated_groups, values_of
from ...models.model import WIND_COEFFICIENTS, ship_length_m, usual_windage
from ..causes.base import Cause
from ..causes.base_coefficients import BaseCoefficients
from ..causes.missing_terms import ConstantForce, MissingTerm, Term
from ..causes.registry import causes, causes_of
from ..causes.steering_gear import RudderDelay, RudderFault, RudderOffset, RudderSensorDelay
from ..causes.surroundings import Current, Wind
from ..free_runs.bank import Bank, Place, numbers_of, places_of

if TYPE_CHECKING:
    from ...checks.base import Check
    from ...models.model import Model

INPUT, HULL, FORCE = 0, 1, 2
"""Ranks: faults of input and sensor go before numbers and terms of the hull, these before forces without a cause."""
DELAY, OFFSET, FAULT = RudderDelay.id, RudderOffset.id, RudderFault.id
UNSTATED = 0.2
"""Standard deviation of a coefficient of which the family states none, as a share of it."""
FAULT_TIMES = np.linspace(0.15, 0.85, 40)
"""Times that are tried, as shares of the longest record: one at its start is a rudder that is weak throughout."""
FLOWS, SIDES = {Current.id: 0, Wind.id: 2}, ("north", "east")
"""Flow -> column of its northern part among the inputs of a run, and the names of its parts."""
WIND_FORCE = ("wind_force", "wind force")
"""Id and title of the group of coefficients that a model states for a wind that is measured."""
WINDAGE_SD, IN_WIND_SD = 0.4, 1.0
"""Standard deviations of the coefficients of the wind force, as shares of those that are stated, or else of usual ones:
beside a wind that is not known, and in one that is measured."""
NEARLY_NONE = 1e-6
"""The share of them that a measured wind acts on without a number: the forms of the force divide by coefficients."""
COLUMNS = {"X": 4, "Y": 5, "N": 6}
"""Axis -> column of a force along it."""
FORCES = tuple((one.entry, COLUMNS[one.axis], one.sd) for one in ConstantForce.terms)
"""Steady forces in body axes: name, column of the environment's inputs, standard deviation."""
PUSH = ("constant_R", 0, 0.03)
"""The same of a response model: a steady yaw acceleration, in U/L to the order of its highest derivative."""
STARTS = {"second_order_lead": {"lag": {"lead": 1.0}, "half": {"lead": 0.5}}}
"""Extension -> kind -> points that its numbers are tried from where their slopes vanish: a pure lag, half a lead."""


class Facts(NamedTuple):
    """What the records offer: states that they measure, whether the rudder's angle is unknown, their number, and the
    duration of the longest one, s; whether the model's own numbers were identified from them, so that they are hardly
    restricted, or are stated to be exact; causes (ids) that the sensors' channels have decided on; the standard
    deviation of the model's own numbers as a share of them, where it is stated; and whether wind is measured."""

    measured: Collection[str]
    commanded: bool
    records: int
    longest_s: float
    identified: bool = False
    exact: bool = False
    decided: Collection[str] = ()
    coefficient_sd: float | None = None
    windy: bool = False


def bank_of(model: Model, facts: Facts, length_s: float, only: Collection[str] | None) -> Bank:
    """The bank of a model with coefficients; only : causes (ids) that it is restricted to."""
    groups = stated_groups(model)
    whole = grown(model, groups) if groups else model
    groups = tuple(g for g in groups if g.extension != OFFSET) or (_unstated(model),)
    pairs = [*_inputs(whole, facts, length_s), *_terms(whole, facts)]
    candidates, places = [c for c, _ in pairs], {n: p for _, own in pairs for n, p in own.items()}
    cause_of = {c.of: c.of for c in candidates if c.of != WIND_FORCE[0]} | causes_of(model)
    numbers = values_of(whole)
    candidates += [c for g in groups for c in _of_group(g, numbers)]
    places = places_of(whole) | places
    own = {n.name: n for g in groups if g.extension is None for n in numbers_of(g, numbers)}
    if facts.coefficient_sd:
        own = {n: replace(x, sd=facts.coefficient_sd * abs(numbers[n])) for n, x in own.items() if numbers[n]}
    if facts.identified:
        barely = every_own_number(groups)
        own = {n.name: n for n in numbers_of(barely, numbers)}
    if only is not None and BaseCoefficients.id not in only and not facts.identified:
        own = {}
    kept = [c for c in candidates if only is None or cause_of.get(c.of, BaseCoefficients.id) in only]
    terms = every_term()
    series = {name: terms[name].along for name, place in places.items() if place.kind == "term"}
    windage = model.windage if model.windage or not model.is_3dof else usual_windage(ship_length_m(model))
    titles = dict([*((g.id, g.title) for g in groups), WIND_FORCE])
    lacking = _lacks_windage(model, facts)
    wind_share = NEARLY_NONE if lacking else 1.0
    bank = Bank(whole, tuple(kept), tuple(own.values()), places, cause_of, titles, series, windage, wind_share)
    return replace(bank, model=replace(whole, windage=bank.windage_with({}))) if lacking else bank


def _lacks_windage(model: Model, facts: Facts) -> bool:
    """Whether wind is measured that the model knows no coefficients for."""
    return facts.windy and model.is_3dof and not model.windage


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
    unit = {
        "1": 1.0,
        "rad": 1.0,
        "s": length_s,
        "m": length_s * speed,
        "m/s": speed,
        "s/m": 1.0 / speed,
        "rad/s": 1.0 / length_s,
    }
    for cause in causes().values():
        if cause.id in facts.decided:
            continue
        if cause.id == RudderSensorDelay.id and facts.identified and not model.is_3dof:
            continue  # else the lead of an order that an identified response model lacks
        if isinstance(cause, Cause) and not (facts.exact or cause.stands_beside_numbers(model.is_3dof)):
            continue
        yield from _of_instruments(cause, facts, unit)
    if not facts.identified:
        yield from _faults(facts.longest_s)
    if facts.records > 1:
        yield _own_neutral_angles(facts.records)
    if model.is_3dof:
        yield from _flows(model, facts, speed)
        yield from _forces(model, facts, length_s)


def _of_instruments(
    cause: Check, facts: Facts, unit: Mapping[str, float]
) -> Iterator[tuple[Candidate, dict[str, Place]]]:
    """The numbers of a cause of rudder or sensors, from each value that they are tried at; none of any other."""
    prior, number = cause.prior, cause.number if isinstance(cause, Cause) else None
    entries = prior.entries or (number.entries if number is not None else ())
    needs = prior.needs or (cause.channels if isinstance(cause, Cause) else ())
    if not prior.sd or not {*needs} <= {*facts.measured} or (prior.angle if facts.commanded else prior.limit):
        return
    if isinstance(cause, SensorError) and cause.together:
        yield _together(cause, unit)
    if not entries:
        return
    kind = "steering" if cause.where == "rudder" else "sensor"
    size, low = unit.get(cause.unit, 1.0), 0.0 if number is None else number.low
    size = 1.0 / size if prior.limit else size
    rank = FORCE if prior.last else INPUT
    for own in (entries, *prior.others):
        name = cause.id if own == entries else f"{cause.id} of {' '.join(own)}"
        place = {name: Place(kind, own, inverse=prior.limit)}
        for trial in [size * t for t in prior.trials] or [None]:
            yield Candidate(cause.id, (Number(name, size * prior.sd, low=low, trial=trial),), rank), place


def _together(cause: SensorError, unit: Mapping[str, float]) -> tuple[Candidate, dict[str, Place]]:
    """The numbers of a sensor error whose sizes act together."""
    names = [f"{cause.id} {effect.parameter}" for effect in cause.together]
    numbers = (Number(n, cause.prior.sd * unit[e.unit]) for n, e in zip(names, cause.together, strict=True))
    places = {n: Place("sensor", e.instruments) for n, e in zip(names, cause.together, strict=True)}
    return Candidate(cause.id, tuple(numbers), INPUT), places


def _faults(longest_s: float) -> Iterator[tuple[Candidate, dict[str, Place]]]:
    """A rudder that loses a share of its force at some time of the records."""
    for time_s in (longest_s * FAULT_TIMES).tolist():
        name = f"{FAULT} after {time_s:.9g} s"
        place = Place("steering", (FAULT,), fixed=((f"{FAULT}_time", time_s),))
        yield Candidate(FAULT, (Number(name, RudderFault.prior.sd, low=-1.0),), INPUT, kind="time"), {name: place}


def _own_neutral_angles(records: int) -> tuple[Candidate, dict[str, Place]]:
    """A neutral rudder angle of each record's own."""
    places = {f"{OFFSET}:{r}": Place("steering", (OFFSET,), record=r) for r in range(records)}
    return Candidate(OFFSET, tuple(Number(name, RudderOffset.prior.sd) for name in places), INPUT), places


def _flows(model: Model, facts: Facts, speed: float) -> Iterator[tuple[Candidate, dict[str, Place]]]:
    """Steady current and wind: the same in all records, each record's own, or of one record alone; where the model
    states no windage, with coefficients of the wind force, which are all that is not known of a measured wind (of one
    record alone they would take up its neutral angle)."""
    coefficients = {f"{Wind.id} {n}": Place("windage", (n,)) for n in WIND_COEFFICIENTS}
    wind = (Wind.id, Wind.prior.sd, {} if model.windage else coefficients)
    in_wind, lacking = tuple(Number(name, IN_WIND_SD) for name in coefficients), _lacks_windage(model, facts)
    if facts.windy:
        yield Candidate(*((Wind.id, in_wind, INPUT) if lacking else (WIND_FORCE[0], in_wind, HULL))), coefficients
    every = range(facts.records)
    for cause, sd, more in ((Current.id, Current.prior.sd, {}), *(() if lacking else (wind,))):
        alone = [(r,) for r in every] if facts.records > 2 and not more else []
        for records in ((None,), *([every] if facts.records > 1 else []), *alone):
            places = {
                flow_name(cause, side, r): Place("flow", column=FLOWS[cause] + i, record=r)
                for r in records
                for i, side in enumerate(SIDES)
            }
            numbers = [Number(name, sd * speed) for name in places]
            numbers += [Number(name, WINDAGE_SD) for name in more]
            kind = "record" if None not in records and len(records) < facts.records else ""
            yield Candidate(cause, tuple(numbers), INPUT, kind=kind), places | more


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
    numbers, length = model.environment_numbers(), ship_length_m(model)
    unit = 0.5 * numbers["rho"] * length**2 * model.speed_m_s**2
    return {"X": unit, "Y": unit, "N": unit * length}


def _forces(model: Model, facts: Facts, length_s: float) -> Iterator[tuple[Candidate, dict[str, Place]]]:
    """Steady forces in body axes along which the motion is measured, each alone and all together."""
    units, state_of = force_units(model, length_s), {"X": "u", "Y": "v"}
    own = [row for row in FORCES if state_of.get(row[0][-1], "r") in {"r", *facts.measured}]
    places = {name: Place("flow", column=column) for name, column, _ in own}
    whole = tuple(Number(name, sd * units[name[-1]]) for name, _, sd in own)
    for numbers in (*((n,) for n in whole), *([whole] if len(whole) > 1 else [])):
        yield Candidate(ConstantForce.id, numbers, FORCE), places


def _terms(model: Model, facts: Facts) -> Iterator[tuple[Candidate, dict[str, Place]]]:
    """Terms that the model lacks, as forces along the measured motion."""
    known = {*model.coordinates}
    for cause in (c for c in causes().values() if isinstance(c, MissingTerm) and model.is_3dof):
        own = [t for t in cause.terms if t.factors and ("v" not in t.entry or "v" in facts.measured)]
        places = {t.entry: Place("term", (t.entry,), COLUMNS[t.axis]) for t in own if t.entry not in known}
        numbers = tuple(Number(t.entry, t.sd) for t in own if t.entry in places)
        sets: Sequence[tuple[Number, ...]] = [(n,) for n in numbers]
        for chosen in (*sets, *([numbers] if len(numbers) > 1 else [])):
            yield Candidate(cause.id, chosen, HULL, extends=True), places


def every_term() -> dict[str, Term]:
    """Parameter of an extension -> the term that a cause has of it."""
    return {one.entry: one for cause in causes().values() if isinstance(cause, MissingTerm) for one in cause.terms}
