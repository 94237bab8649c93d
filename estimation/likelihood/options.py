"""Prior knowledge as options of a method: priors, bounds and fixed values of published parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...models.errors import BadInput
from .unknowns import Unknowns

if TYPE_CHECKING:
    from ...models.model import Model

FILES = (".yaml", ".yml", ".json")


def read(option: str, value: Any) -> Any:
    """The value of an option, or the content of the YAML or JSON file that it names.

    Raises
    ------
    BadInput : the file cannot be read.
    """
    if not isinstance(value, str | Path) or Path(value).suffix.lower() not in FILES:
        return value
    import yaml

    try:
        return yaml.safe_load(Path(value).read_text(encoding="utf-8"))
    except OSError as error:
        raise BadInput(f"{option} cannot be read: {error.strerror}", file=value) from error
    except (UnicodeDecodeError, yaml.YAMLError) as error:
        raise BadInput(f"{option} is not a YAML or JSON file: {error}", file=value) from error


def pairs(option: str, value: Any, unit: tuple[str, str]) -> dict[str, tuple[float, float]]:
    """Name -> two numbers, from a mapping or a file; None in a pair is nan.

    Raises
    ------
    BadInput : naming the option and the parameter.
    """
    hint = f"{option} takes a mapping NAME: [{unit[0]}, {unit[1]}], or the path of a YAML or JSON file with one"
    given = read(option, value)
    if not isinstance(given, Mapping):
        raise BadInput(f"{option} is {value!r}, which is no mapping", hint=hint)
    found = {}
    for name, pair in given.items():
        if not isinstance(pair, Sequence) or isinstance(pair, str) or len(pair) != 2:
            raise BadInput(f"{option} of {name} is {pair!r}, not a pair of numbers", hint=hint)
        found[str(name)] = (_number(option, name, pair[0]), _number(option, name, pair[1]))
    return found


def _number(option: str, name: Any, value: Any) -> float:
    if value is None:
        return float("nan")
    try:
        return float(value)
    except (TypeError, ValueError):
        raise BadInput(f"{option} of {name} is {value!r}, not a number") from None


def priors(value: Any) -> float | dict[str, tuple[float, float]]:
    """A relative standard deviation about the given model's parameters, or name -> (mean, standard deviation).

    Raises
    ------
    BadInput : the value is neither, or a standard deviation is not positive.
    """
    if isinstance(value, int | float) and not isinstance(value, bool):
        if not 0.0 < value < np.inf:
            raise BadInput(f"prior is {value!r}, a positive share is needed", hint="prior=0.3: 30 % standard deviation")
        return float(value)
    found = pairs("prior", value, ("mean", "sd"))
    for name, (mean, sd) in found.items():
        if not (np.isfinite(mean) and 0.0 < sd < np.inf):
            raise BadInput(f"prior of {name} is {mean!r}, {sd!r}: a mean and a positive standard deviation are needed")
    return found


def limits(value: Any) -> dict[str, tuple[float, float]]:
    """Name -> (low, high), infinite where there is no bound.

    Raises
    ------
    BadInput : low is not below high.
    """
    found = {}
    for name, (low, high) in pairs("bounds", value, ("low", "high")).items():
        low, high = (-np.inf if np.isnan(low) else low), (np.inf if np.isnan(high) else high)
        if not low < high:
            raise BadInput(f"bounds of {name} are {low!r} and {high!r}: the first must be below the second")
        found[name] = (low, high)
    return found


def fixings(value: Any) -> dict[str, float | None]:
    """Name -> value, None for the given model's own value.

    Raises
    ------
    BadInput : the value is neither a mapping nor names.
    """
    given = read("fixed", value)
    if isinstance(given, Mapping):
        return {str(name): None if number is None else _number("fixed", name, number) for name, number in given.items()}
    return dict.fromkeys(names("fixed", given))


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
    for name, value in (fixings(fixed) if fixed is not None else {}).items():
        (i,) = indices("fixed", [name], model)
        values[i] = _own(model, f"fixed={name}")[i] if value is None else value
    for name, (least, most) in (limits(bounds) if bounds is not None else {}).items():
        (i,) = indices("bounds", [name], model)
        low[i], high[i] = least, most
        if values[i] < least or values[i] > most:
            raise BadInput(f"{name} is fixed at {values[i]:g}, outside its bounds {least:g} and {most:g}")
    if not np.isnan(values).any():
        raise BadInput("every parameter is fixed: nothing is left to identify")
    return replace(found, values=values, low=low, high=high, mean=mean, sd=sd)


def _prior_of(model: Model, prior: float | dict[str, tuple[float, float]] | None) -> tuple[np.ndarray, np.ndarray]:
    if isinstance(prior, float):
        own = _own(model, f"prior={prior:g}")
        return own, prior * np.abs(own)
    mean, sd = np.full(len(model.parameter_names), np.nan), np.full(len(model.parameter_names), np.inf)
    given = prior if isinstance(prior, dict) else {}
    for i, pair in zip(indices("prior", list(given), model), given.values(), strict=True):
        mean[i], sd[i] = pair
    return mean, sd


def _own(model: Model, option: str) -> np.ndarray:
    """Published parameters (q,) of the given model."""
    own = model.to_parameters(model.coefficients)
    if not np.isfinite(own).all():
        hint = "name a vessel or a model.json, or give values"
        raise BadInput(f"{option} means the given model's own values, and {model.id} has none", hint=hint)
    return own
