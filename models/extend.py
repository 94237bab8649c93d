"""A model with an extension of its family, as numbers: `models.families.extensions` holds the equations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from . import kernels as kernel_store
from .errors import BadInput

if TYPE_CHECKING:
    from .model import Model

NEUTRAL = {"sway_time": 10.0, "lead_T2": 10.0, "loss_time": 30.0, "loss_power": 2.0}
"""Parameters of extensions that have no meaning while their effect is absent, but must not be zero."""


def extended(model: Model, extension: str, values: Mapping[str, float] | None = None) -> Model:
    """The model with an extension added to its family; parameters not named in `values` have their null value.

    Constants that the extension needs (water density, windage) come from the model's particulars and windage.

    Raises
    ------
    BadInput : if the family cannot carry the extension, has no parameter of a name in `values`, or the model lacks a
        constant that the extension needs.
    """
    family = f"{model.family}+{extension}"
    kernels = kernel_store.load(family)
    numbers = dict(zip(model.coordinates, model.coefficients.tolist(), strict=True))
    added = {name: NEUTRAL.get(name, 0.0) for name in kernels.COEFFICIENTS if name not in numbers}
    unknown = sorted(set(values or {}) - set(added))
    if unknown:
        raise BadInput(f"extension {extension} has no parameter {unknown[0]!r}", hint=f"it has {', '.join(added)}")
    numbers |= added | dict(values or {})
    constants = model.environment_numbers()
    lacking = [name for name in kernels.CONSTANTS if name not in constants]
    if lacking:
        raise BadInput(f"extension {extension} of {model.id} needs {', '.join(lacking)}")
    return replace(
        model,
        id=f"{model.id}+{extension}",
        family=family,
        coefficients=np.array([numbers[name] for name in kernels.COEFFICIENTS]),
        constants=np.array([constants[name] for name in kernels.CONSTANTS]),
    )
