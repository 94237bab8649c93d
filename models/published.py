"""Published parameters of the vessels that ship with helmbench, to hold estimates against."""

from __future__ import annotations

from .model import Model, resolve
from .vessel import vessel_files


def published_values(model: Model) -> dict[str, dict[str, float]]:
    """Parameter -> vessel id -> published value, of the vessels of the model's kind.

    Vessels of the model's own family; for a response model also those of other response models, where a parameter has
    the same name and unit.  Values are as published: those with a unit depend on the ship's size and speed.
    """
    found: dict[str, dict[str, float]] = {name: {} for name in model.parameter_names}
    units = dict(zip(model.parameter_names, model.parameter_units, strict=True))
    for vessel in map(resolve, vessel_files()):
        if vessel.family != model.family and not (_is_response(vessel) and _is_response(model)):
            continue
        values = vessel.parameters
        for name, unit in zip(vessel.parameter_names, vessel.parameter_units, strict=True):
            if units.get(name) == unit:
                found[name][vessel.id] = values[name]
    return {name: values for name, values in found.items() if values}


def _is_response(model: Model) -> bool:
    """Whether yaw and heading are all that the model has."""
    return not {"u", "v"} & set(model.states)
