"""Groups of numbers of a model that may be wrong together, with prior standard deviations: data of the families.

Each file of `families/coefficient_groups` holds the groups of one or more families (see `mmg.yaml` for the format).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from . import kernels as kernel_store
from .errors import BadInput
from .families.extensions import extension_of
from .parameter_checks import Scope, scopes
from .time_scale import time_scale_s

if TYPE_CHECKING:
    from .model import Model

Stated = str | float | dict[str, Any]
"""A prior as a file states it: a percentage of the value, a standard deviation, or several numbers by name."""
BARELY = 3.0
"""Prior standard deviations that a number may be off by where it was identified."""
GROSS = 3.0
"""Factor on the prior standard deviation of a number that is wrong alone: a slip, not an inaccuracy."""
OWN = "own_numbers"
"""Id of the group of all of a model's own numbers."""
FOLDER = Path(__file__).parent / "families" / "coefficient_groups"


@dataclass(frozen=True)
class Group:
    """Numbers that may be wrong together.

    extension : model extension that they belong to, None for numbers of the family itself.
    sd : name -> prior standard deviation, in the unit of the number.
    mean : name -> prior mean of a parameter of the extension, for those where it is not 0.
    low : name -> smallest value that means anything, for those that have one.
    unit : name -> size of which the number is for most ships, in its unit, where the family states it.
    of : id of the group that this is a part of, else its own.
    slips : name -> prior standard deviation of numbers that are known well, and are wrong alone or not at all: those of
    drawings and tables.  unlikely : name -> what is usual of numbers that hardly any ship has as the model has them.
    ratio_to : name of another number of which the published one is the ratio to it; else empty.
    scope : name -> what the number may be for ships: where one that is wrong alone is.  high : name -> largest value
    that means anything, for those that have one.
    """

    id: str
    title: str
    extension: str | None
    sd: dict[str, float]
    mean: dict[str, float] = field(default_factory=dict)
    low: dict[str, float] = field(default_factory=dict)
    unit: dict[str, float] = field(default_factory=dict)
    of: str = ""
    slips: dict[str, float] = field(default_factory=dict)
    ratio_to: str = ""
    scope: dict[str, Scope] = field(default_factory=dict)
    high: dict[str, float] = field(default_factory=dict)
    unlikely: dict[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "of", self.of or self.id)

    @property
    def every(self) -> dict[str, float]:
        """Name -> prior standard deviation of all its numbers."""
        return {**self.sd, **self.slips}


@dataclass(frozen=True)
class LocalNumber:
    """A number, or numbers in proportion, that may be wrong in a part of the runs only.

    group, title : of the group that it belongs to.  change : name -> change of the number in a regime of size one: its
    value, and one rad for the neutral rudder angle.  sd : prior standard deviation of the size.
    """

    name: str
    group: str
    title: str
    change: dict[str, float]
    sd: float


def names_of(model: Model) -> tuple[str, ...]:
    """Names of the elements of `Model.theta`."""
    return (*model.coordinates, *model.constant_names)


def values_of(model: Model) -> dict[str, float]:
    """Number of a model -> its value."""
    return dict(zip(names_of(model), model.theta.tolist(), strict=True))


def with_values(model: Model, values: Mapping[str, float]) -> Model:
    """The model with other values of some of its numbers."""
    both = (model.coordinates, model.coefficients), (model.constant_names, model.constants)
    coefficients, constants = (
        np.array([values.get(n, x) for n, x in zip(names, own.tolist(), strict=True)]) for names, own in both
    )
    return replace(model, coefficients=coefficients, constants=constants)


def local_numbers(model: Model) -> tuple[LocalNumber, ...]:
    """What of a model may be wrong in a part of the runs only: numbers that are not zero, the rudder's whole force, the
    neutral rudder angle; not the mass."""
    values, groups = values_of(model), stated_groups(model)
    entries, found = _stated(model.family.partition("+")[0]) if groups else {}, []
    for group in groups:
        stated = entries[group.id].get("local", True)
        if stated is True and group.extension is None:
            known = {name: sd for name, sd in group.sd.items() if values[name] != 0.0}
            found += [
                LocalNumber(name, group.id, group.title, {name: values[name]}, GROSS * sd / abs(values[name]))
                for name, sd in known.items()
            ]
        for name, pattern in stated.items() if isinstance(stated, dict) else ():
            own = {n: v for n, v in values.items() if re.fullmatch(pattern, n) and v != 0.0}
            change = {pattern: 1.0} if group.extension is not None else own or {pattern: 1.0}
            shares = [sd / abs(x) for n, sd in group.sd.items() if (x := change.get(n, values.get(n, 0.0)))]
            found.append(LocalNumber(name, group.id, group.title, change, GROSS * min(shares, default=0.1)))
    return tuple(found)


def parts_of(group: Group) -> tuple[Group, ...]:
    """Every number of a group as a group of its own, which may be wrong by GROSS times as much, and by half of the
    range that it has for most ships; not far outside of that."""
    return tuple(
        _part(group, name, sd)
        for name, sd in group.every.items()
        if name in group.slips or name in group.scope or len(group.sd) > 1
    )


def _part(group: Group, name: str, sd: float) -> Group:
    """One number of a group, which is wrong alone."""
    scope = group.scope.get(name, Scope(0.0, group.low.get(name, -np.inf), np.inf, 0.0))
    return Group(
        f"{group.id}.{name}",
        group.title,
        group.extension if name in group.sd else None,
        {name: max(GROSS * sd, scope.half_usual)},
        {key: value for key, value in group.mean.items() if key == name},
        {name: scope.low},
        of=group.id,
        high={name: scope.high},
    )


def groups_of(model: Model) -> tuple[Group, ...]:
    """The groups of a model's family, with the numbers that the model has and does not hold at zero.

    Raises
    ------
    BadInput : the family states no groups, or its file is wrong.
    """
    values = values_of(model)
    of_family, found = scopes(model.family.partition("+")[0], values, model.speed_m_s), []
    for name, entry in _stated(model.family.partition("+")[0]).items():
        title, extension = entry["title"], entry.get("extension")
        numbers, slips = entry.get("numbers", {}), dict(entry.get("slips", {}))
        slips |= {n: sd for n, sd in entry.get("unlikely", {}).items() if _is_unlikely(of_family.get(n), values.get(n))}
        known = values
        if extension is not None and extension not in model.family.split("+"):
            if not kernel_store.carries(model.family, extension):
                continue
            known = dict.fromkeys(extension_of(extension).units, 0.0)
        group = _group(name, title, extension, _matched(numbers, known), model)
        well_known = _group(name, title, None, _matched(slips, values), model).sd
        own = {n: of_family[n] for n in (*group.sd, *well_known) if n in of_family and extension is None}
        scope = {n: s._replace(low=min(s.low, values[n]), high=max(s.high, values[n])) for n, s in own.items()}
        unlikely = {n: s.usual for n, s in own.items() if _is_unlikely(s, values[n])}
        ratio_to = entry.get("ratio_to", "")
        group = replace(group, slips=well_known, ratio_to=ratio_to, scope=scope, unlikely=unlikely)
        if group.every:
            found.append(group)
    return tuple(found)


def _is_unlikely(scope: Scope | None, value: float | None) -> bool:
    """Whether a number is outside of what most ships have."""
    return scope is not None and value is not None and abs(value - scope.usual) > scope.half_usual


def stated_groups(model: Model) -> tuple[Group, ...]:
    """As `groups_of`; none where the family states no groups."""
    try:
        return groups_of(model)
    except BadInput:
        return ()


def every_own_number(groups: Iterable[Group]) -> Group:
    """The numbers of the family itself as one group, barely restricted: for a model that was identified from records.

    A number that is nearly zero may reach the size that it has for most ships.
    """
    own = [group for group in groups if group.extension is None]
    sd = {name: max(BARELY * one, group.unit.get(name, 0.0)) for group in own for name, one in group.sd.items()}
    return Group(OWN, "all of the model's own numbers", None, sd)


def grown(model: Model, groups: Iterable[Group]) -> Model:
    """The model with the extensions whose parameters are among the groups' numbers, in the order in which the family
    states them, parameters at their prior means."""
    wanted = {name for group in groups for name in group.sd}
    own = model.family.split("+")
    stated = [g for g in groups_of(model) if g.extension is not None and g.extension not in own]
    added = [g for g in stated if not wanted.isdisjoint(g.sd)]
    family = "+".join([model.family, *(str(group.extension) for group in added)])
    kernels = kernel_store.load(family)
    known = values_of(model)
    known |= {name: mean for group in added for name, mean in group.mean.items()}
    values = np.array([known.get(name, 0.0) for name in kernels.COEFFICIENTS])
    constants = np.array([known[name] for name in kernels.CONSTANTS])
    return replace(model, family=family, coefficients=values, constants=constants)


def _matched(numbers: Mapping[str, Stated], values: Mapping[str, float]) -> dict[str, tuple[Stated, float]]:
    """What is stated of every value whose name matches, and the value that it is a share of: its own; that of the
    number it is one `of`; of a zero, that of the number it is `like`."""

    def whole(stated: Stated, value: float) -> float:
        other = stated if isinstance(stated, dict) else {}
        return values[other["of"]] if "of" in other else value or values.get(other.get("like", ""), 0.0)

    return {
        name: (stated, whole(stated, value))
        for pattern, stated in numbers.items()
        for name, value in values.items()
        if re.fullmatch(pattern, name)
    }


def _group(
    name: str, title: str, extension: str | None, numbers: Mapping[str, tuple[Stated, float]], model: Model
) -> Group:
    """The group in SI units; a percentage of zero is left out."""
    group = Group(name, title, extension, {})
    for number, (stated, value) in numbers.items():
        if not isinstance(stated, dict):
            sd = abs(value) * float(stated.removesuffix("%")) / 100.0 if isinstance(stated, str) else float(stated)
            group.sd.update({number: sd} if sd > 0.0 else {})
            continue
        power = stated.get("time_power")
        unit = time_scale_s(model) ** power if power is not None else 1.0
        group.unit.update({number: unit} if power is not None else {})
        sd = stated["share"] * abs(value) if "share" in stated else unit * stated["sd"]
        group.sd.update({number: sd} if sd > 0.0 or power is not None else {})
        group.mean.update({number: unit * stated["mean"]} if "mean" in stated else {})
        group.low.update({number: unit * stated["low"]} if "low" in stated else {})
    return group


@lru_cache(maxsize=16)
def _stated(family: str) -> dict[str, dict[str, Any]]:
    from .yaml_file import read_yaml

    for path in sorted(FOLDER.glob("*.yaml")):
        content = read_yaml(path, "a file of coefficient groups")
        if family in content["families"]:
            return content["groups"]
    hint = f"a file in models/families/coefficient_groups; there are {', '.join(p.stem for p in FOLDER.glob('*.yaml'))}"
    raise BadInput(f"family {family} states no groups of coefficients", hint=hint)
