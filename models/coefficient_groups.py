"""Groups of numbers of a model that may be wrong together, with prior standard deviations: data of the families.

Each file of `families/coefficient_groups` holds the groups of one or more families (see `mmg.yaml` for the format).
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from . import kernels as kernel_store
from .errors import BadInput
from .families.extensions import carries, extension_of

if TYPE_CHECKING:
    from .model import Model

FOLDER = Path(__file__).parent / "families" / "coefficient_groups"


@dataclass(frozen=True)
class Group:
    """Numbers that may be wrong together.

    extension : model extension that they belong to, None for numbers of the family itself.
    sd : name -> prior standard deviation, in the unit of the number.
    """

    id: str
    title: str
    extension: str | None
    sd: dict[str, float]


def groups_of(model: Model) -> tuple[Group, ...]:
    """The groups of a model's family, with the numbers that the model has and does not hold at zero.

    Raises
    ------
    BadInput : the family states no groups, or its file is wrong.
    """
    values = dict(zip((*model.coordinates, *model.constant_names), model.theta.tolist(), strict=True))
    definition = kernel_store.definition_of(model.family)
    found = []
    for name, (title, extension, numbers) in _stated(model.family.partition("+")[0]).items():
        if extension is None:
            sd = _matched(numbers, values)
        elif carries(definition, extension):
            sd = _matched(numbers, dict.fromkeys(extension_of(extension).units, 0.0))
        else:
            sd = {}
        if sd:
            found.append(Group(name, title, extension, sd))
    return tuple(found)


def grown(model: Model, groups: Iterable[Group]) -> Model:
    """The model with the extensions of the groups, in the order in which the family states them, parameters at zero."""
    wanted = {group.id for group in groups}
    names = [group.extension for group in groups_of(model) if group.id in wanted and group.extension is not None]
    family = "+".join([model.family, *names])
    kernels = kernel_store.load(family)
    known = dict(zip((*model.coordinates, *model.constant_names), model.theta.tolist(), strict=True))
    values = np.array([known.get(name, 0.0) for name in kernels.COEFFICIENTS])
    constants = np.array([known[name] for name in kernels.CONSTANTS])
    return replace(model, family=family, coefficients=values, constants=constants)


def _matched(numbers: dict[str, str | float], values: dict[str, float]) -> dict[str, float]:
    """Standard deviation of every value whose name matches; a percentage of zero is left out."""
    found = {}
    for pattern, stated in numbers.items():
        for name, value in values.items():
            if re.fullmatch(pattern, name):
                sd = _sd(stated, value)
                found |= {name: sd} if sd > 0.0 else {}
    return found


def _sd(stated: str | float, value: float) -> float:
    if isinstance(stated, str):
        return abs(value) * float(stated.removesuffix("%")) / 100.0
    return float(stated)


@lru_cache(maxsize=16)
def _stated(family: str) -> dict[str, tuple[str, str | None, dict[str, str | float]]]:
    from .yaml_file import read_yaml

    for path in sorted(FOLDER.glob("*.yaml")):
        content = read_yaml(path, "a file of coefficient groups")
        if family in content["families"]:
            return {
                name: (entry["title"], entry.get("extension"), entry["numbers"])
                for name, entry in content["groups"].items()
            }
    hint = f"a file in models/families/coefficient_groups; there are {', '.join(p.stem for p in FOLDER.glob('*.yaml'))}"
    raise BadInput(f"family {family} states no groups of coefficients", hint=hint)
