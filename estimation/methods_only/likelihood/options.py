"""Prior knowledge as options of a method: priors, bounds and fixed values of published parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from ....models.data_file import load
from ....models.errors import BadInput
from ....models.units import factor
from ...likelihood.unknowns import Unknowns

if TYPE_CHECKING:
    from ....models.model import Model
    from .prior_file import BoundsEntry, FixedEntry, PriorEntry

Entry = TypeVar("Entry", "PriorEntry", "BoundsEntry", "FixedEntry")

FILES = (".yaml", ".yml", ".json")


def read(value: Any) -> Any:
    """The value of an option, or the content of the YAML or JSON file that it names."""
    if not isinstance(value, str | Path) or Path(value).suffix.lower() not in FILES:
        return value
    return load(value)


def entries(option: str, value: Any, model: type[Entry]) -> dict[str, Entry]:
    """Parameter -> what a mapping or a file says of it, by the model of an entry.

    Raises
    ------
    BadInput : naming the file or the option, and the parameter.
    """
    from ....models.yaml_file import checked, shortened
    from .prior_file import SHORT, written_out

    given = read(value)
    short = ", ".join(SHORT[model])
    hint = f"{option} takes a mapping NAME: {f'[{short}]' if ',' in short else short}, or the path of a file with one"
    if not isinstance(given, Mapping):
        raise BadInput(f"{option} is {shortened(value)!r}, which is no mapping", hint=hint)
    found, place = {}, f"{value}: " if given is not value else ""
    for name, entry in given.items():
        try:
            found[str(name)] = checked(model, written_out(model, entry), f"{place}{option} of {shortened(name, 40)}")
        except ValueError as error:
            if isinstance(error, BadInput):
                raise
            raise BadInput(f"{place}{option} of {shortened(name, 40)} is {shortened(error)}", hint=hint) from None
    return found


def priors(value: Any) -> float | dict[str, PriorEntry]:
    """A relative standard deviation about the given model's parameters, or name -> mean and standard deviation.

    Raises
    ------
    BadInput : the value is neither, or a standard deviation is not positive.
    """
    if isinstance(value, int | float) and not isinstance(value, bool):
        if not 0.0 < value < np.inf:
            raise BadInput(f"prior is {value!r}, a positive share is needed", hint="prior=0.3: 30 % standard deviation")
        return float(value)
    from .prior_file import PriorEntry

    return entries("prior", value, PriorEntry)


def limits(value: Any) -> dict[str, BoundsEntry]:
    """Name -> low and high, infinite where there is no bound.

    Raises
    ------
    BadInput : low is not below high.
    """
    from .prior_file import BoundsEntry

    return entries("bounds", value, BoundsEntry)


def fixings(value: Any) -> dict[str, FixedEntry | None]:
    """Name -> value, None for the given model's own value.

    Raises
    ------
    BadInput : the value is neither a mapping nor names.
    """
    given = read(value)
    if not isinstance(given, Mapping):
        return dict.fromkeys(names("fixed", given))
    own = dict.fromkeys(str(name) for name, entry in given.items() if entry is None)
    stated = {name: entry for name, entry in given.items() if entry is not None}
    from .prior_file import FixedEntry

    return own | entries("fixed", stated, FixedEntry)


def in_units(option: str, model: Model, name: str, unit: str | None) -> tuple[int, float]:
    """Index of a published parameter, and the factor that converts a number in `unit` to the parameter's.

    Raises
    ------
    BadInput : the model has no parameter of that name, or not in such a unit.
    """
    (i,) = indices(option, [name], model)
    try:
        return i, 1.0 if unit is None else factor(unit, model.parameter_units[i])
    except ValueError as error:
        raise BadInput(f"{option} of {name}: {error}") from None


def names(option: str, value: Any) -> list[str]:
    """Names from a list, or from a text that joins them by +.

    Raises
    ------
    BadInput : the value is anything else.
    """
    if isinstance(value, str):
        return [name.strip() for name in value.split("+")]
    if isinstance(value, Sequence) and all(isinstance(name, str) for name in value):
        return list(value)
    raise BadInput(f"{option} is {value!r}, names are needed", hint=f"{option}=K+T, a list, or a mapping")


def indices(option: str, given: Sequence[str], model: Model) -> list[int]:
    """Indices of published parameters by name.

    Raises
    ------
    BadInput : the model has no parameter of that name.
    """
    known = model.parameter_names
    for name in given:
        if name not in known:
            raise BadInput(f"{option}: {model.family} has no parameter {name!r}", hint=f"known: {', '.join(known)}")
    return [known.index(name) for name in given]


def profiled(value: Any, model: Model) -> list[int]:
    """Indices of the published parameters that the option `profile` names; 'all' names every one.

    Raises
    ------
    BadInput : the model has no parameter of a name.
    """
    if value is None:
        return []
    given = names("profile", value)
    return list(range(len(model.parameter_names))) if given == ["all"] else indices("profile", given, model)


def unknowns_of(model: Model, prior: Any, bounds: Any, fixed: Any) -> Unknowns | None:
    """The unknowns for a model with the known values; None without any option.

    With a relative prior, parameters that are zero in the given model stay zero.

    Raises
    ------
    BadInput : the model has no parameter of a name, or no value of it; or a value is outside its bounds.
    """
    if prior is None and bounds is None and fixed is None:
        return None
    found = Unknowns.all_of(model)
    values, low, high = found.values.copy(), found.low.copy(), found.high.copy()
    mean, sd = _prior_of(model, None if prior is None else priors(prior))
    values[sd == 0.0] = 0.0
    sd = np.where(sd > 0.0, sd, np.inf)
    for name, entry in (fixings(fixed) if fixed is not None else {}).items():
        i, gain = in_units("fixed", model, name, entry.unit if entry else None)
        values[i] = _own(model, f"fixed={name}")[i] if entry is None else gain * entry.value
    for name, limit in (limits(bounds) if bounds is not None else {}).items():
        i, gain = in_units("bounds", model, name, limit.unit)
        low[i], high[i] = (gain * bound for bound in limit.pair)
        if values[i] < low[i] or values[i] > high[i]:
            raise BadInput(f"{name} is fixed at {values[i]:g}, outside its bounds {low[i]:g} and {high[i]:g}")
    if not np.isnan(values).any():
        raise BadInput("every parameter is fixed: nothing is left to identify")
    return replace(found, values=values, low=low, high=high, mean=mean, sd=sd)


def _prior_of(model: Model, prior: float | dict[str, PriorEntry] | None) -> tuple[np.ndarray, np.ndarray]:
    if isinstance(prior, float):
        own = _own(model, f"prior={prior:g}")
        return own, prior * np.abs(own)
    mean, sd = np.full(len(model.parameter_names), np.nan), np.full(len(model.parameter_names), np.inf)
    for name, entry in prior.items() if isinstance(prior, dict) else ():
        i, gain = in_units("prior", model, name, entry.unit)
        mean[i], sd[i] = gain * entry.mean, gain * entry.sd
    return mean, sd


def _own(model: Model, option: str) -> np.ndarray:
    """Published parameters (q,) of the given model."""
    own = model.to_parameters(model.coefficients)
    if not np.isfinite(own).all():
        hint = "name a vessel or a model.json, or give values"
        raise BadInput(f"{option} means the given model's own values, and {model.id} has none", hint=hint)
    return own
