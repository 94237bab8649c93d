"""Prior knowledge as options of a method: priors, bounds and fixed values of published parameters."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...models.data_file import load
from ...models.errors import BadInput
from ...models.suggestions import suggestion
from ...models.units import factor
from ..likelihood.unknowns import Unknowns

if TYPE_CHECKING:
    from ...models.model import Model

FILES = (".yaml", ".yml", ".json")
Check = tuple[str, Callable[[float], bool]]
"""What a refusal says is needed, and a test."""
FINITE: Check = "a finite number", lambda x: bool(np.isfinite(x))
BOUND: Check = "a number", lambda x: not np.isnan(x)
POSITIVE: Check = "a positive number", lambda x: 0.0 < x < np.inf
KEYS: dict[str, dict[str, Check]] = {
    "prior": {"mean": FINITE, "sd": POSITIVE},
    "bounds": {"low": BOUND, "high": BOUND},
    "fixed": {"value": FINITE},
}
"""Option -> key of an entry, in the order of its short form -> what it may be; `unit` is a further key of each."""
NO_BOUND = {"low": -np.inf, "high": np.inf}


class Stated(NamedTuple):
    """What an option states of a parameter: its numbers in the order of `KEYS`, and their unit, None for that of the
    parameter."""

    numbers: tuple[float, ...]
    unit: str | None = None


def read(value: Any) -> Any:
    """The value of an option, or the content of the YAML or JSON file that it names."""
    if not isinstance(value, str | Path) or Path(value).suffix.lower() not in FILES:
        return value
    return load(value)


def entries(option: str, value: Any) -> dict[str, Stated]:
    """Parameter -> what a mapping or a file says of it; BadInput names the file or the option, and the parameter."""
    given, short = read(value), ", ".join(KEYS[option])
    if not isinstance(given, Mapping):
        hint = f"a mapping NAME: {f'[{short}]' if ',' in short else short}, or the path of a file with one"
        raise BadInput(f"{option} is {_shown(value)}, which is no mapping", hint=f"{option} takes {hint}")
    place = f"{value}: " if given is not value else ""
    return {str(name): _entry(option, entry, f"{place}{option} of {str(name)[:40]}") for name, entry in given.items()}


def _entry(option: str, entry: Any, place: str) -> Stated:
    keys = KEYS[option]
    if not isinstance(entry, Mapping):
        parts = list(entry) if isinstance(entry, list | tuple) else [entry]
        if len(parts) != len(keys):
            kind = "a pair of numbers" if len(keys) > 1 else "a number"
            raise BadInput(f"{place} is {_shown(entry)}, {kind} is needed", hint=f"or a mapping of {', '.join(keys)}")
        entry = dict(zip(keys, parts, strict=True))
    for key in entry:
        if key not in (*keys, "unit"):
            raise BadInput(f"{place}: unknown key {key!r}", hint=suggestion(str(key), (*keys, "unit")))
    numbers, unit = [_number(entry.get(key), key, needed, place) for key, needed in keys.items()], entry.get("unit")
    if unit is not None and not isinstance(unit, str):
        raise BadInput(f"{place}: unit: needs a text, not {_shown(unit)}")
    if option == "bounds" and not numbers[0] < numbers[1]:
        raise BadInput(f"{place}: {numbers[0]!r} and {numbers[1]!r}: the first must be below the second")
    return Stated(tuple(numbers), unit)


def _number(value: Any, key: str, needed: Check, place: str) -> float:
    """A number that passes a check; no bound is an infinite one."""
    if value is None and key in NO_BOUND:
        return NO_BOUND[key]
    if not isinstance(value, Real) or isinstance(value, bool) or not needed[1](float(value)):
        raise BadInput(f"{place}: {key}: needs {needed[0]}, not {_shown(value)}")
    return float(value)


def _shown(value: Any) -> str:
    text = str(value)
    return text if len(text) <= 80 else f"{text[:77]}..."


def priors(value: Any) -> float | dict[str, Stated]:
    """A relative standard deviation about the given model's parameters, or name -> mean and standard deviation.

    Raises
    ------
    BadInput : the value is neither, or a standard deviation is not positive.
    """
    if not isinstance(value, int | float) or isinstance(value, bool):
        return entries("prior", value)
    if not 0.0 < value < np.inf:
        raise BadInput(f"prior is {value!r}, a positive share is needed", hint="prior=0.3: 30 % standard deviation")
    return float(value)


def fixings(value: Any) -> tuple[list[str], dict[str, Stated]]:
    """Names that keep the given model's own values, and name -> value of others.

    Raises
    ------
    BadInput : the value is neither a mapping nor names.
    """
    given = read(value)
    if not isinstance(given, Mapping):
        return names("fixed", given), {}
    stated = {name: entry for name, entry in given.items() if entry is not None}
    return [str(name) for name in given if name not in stated], entries("fixed", stated)


def names(option: str, value: Any) -> list[str]:
    """Names from a list, or from a text that joins them by +; BadInput for anything else."""
    if isinstance(value, str):
        return [name.strip() for name in value.split("+")]
    if isinstance(value, Sequence) and all(isinstance(name, str) for name in value):
        return list(value)
    raise BadInput(f"{option} is {value!r}, names are needed", hint=f"{option}=K+T, a list, or a mapping")


def indices(option: str, given: Sequence[str], model: Model) -> list[int]:
    """Indices of published parameters by name; BadInput where the model has none of that name."""
    known = model.parameter_names
    for name in given:
        if name not in known:
            raise BadInput(f"{option}: {model.family} has no parameter {name!r}", hint=f"known: {', '.join(known)}")
    return [known.index(name) for name in given]


def profiled(value: Any, model: Model) -> list[int]:
    """Indices of the published parameters that the option `profile` names, 'all' every one; raises as `indices`."""
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
    values, low, high, mean, sd = (getattr(found, name).copy() for name in ("values", "low", "high", "mean", "sd"))
    stated = {} if prior is None else priors(prior)
    if not isinstance(stated, dict):
        mean = _own(model, f"prior={stated:g}")
        values[mean == 0.0] = 0.0
        sd = np.where(mean != 0.0, stated * np.abs(mean), np.inf)
    else:
        for i, numbers in _in_units("prior", stated, model):
            mean[i], sd[i] = numbers
    kept, others = ([], {}) if fixed is None else fixings(fixed)
    for i in indices("fixed", kept, model):
        values[i] = _own(model, f"fixed={model.parameter_names[i]}")[i]
    for i, numbers in _in_units("fixed", others, model):
        (values[i],) = numbers
    for i, numbers in _in_units("bounds", {} if bounds is None else entries("bounds", bounds), model):
        low[i], high[i] = numbers
        if values[i] < low[i] or values[i] > high[i]:
            name = model.parameter_names[i]
            raise BadInput(f"{name} is fixed at {values[i]:g}, outside its bounds {low[i]:g} and {high[i]:g}")
    if not np.isnan(values).any():
        raise BadInput("every parameter is fixed: nothing is left to identify")
    return replace(found, values=values, low=low, high=high, mean=mean, sd=sd)


def _in_units(option: str, stated: Mapping[str, Stated], model: Model) -> Iterator[tuple[int, list[float]]]:
    """Index of each published parameter, and its numbers in the parameter's unit."""
    for name, (numbers, unit) in stated.items():
        (i,) = indices(option, [name], model)
        try:
            gain = 1.0 if unit is None else factor(unit, model.parameter_units[i])
        except ValueError as error:
            raise BadInput(f"{option} of {name}: {error}") from None
        yield i, [gain * number for number in numbers]


def _own(model: Model, option: str) -> np.ndarray:
    """Published parameters (q,) of the given model."""
    own = model.to_parameters(model.coefficients)
    if not np.isfinite(own).all():
        hint = "name a vessel or a model.json, or give values"
        raise BadInput(f"{option} means the given model's own values, and {model.id} has none", hint=hint)
    return own
