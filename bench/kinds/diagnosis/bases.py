"""Base models that are wrong in their own numbers or in structure: a dimension of diagnosis suites."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from .bugs import bug_of

if TYPE_CHECKING:
    from ....models.model import Model

EXACT, UNSTATED = "exact", "unstated"
"""Bases that are the true ship: the diagnosis is told so, or is not."""
MOST = 2.0
"""Largest error of a coefficient, in standard deviations."""
DIAMETER = (0.9, 1.1)
"""Factors of a propeller's diameter that is taken from another ship."""
OTHER_FAMILY = "nomoto-1-cubic"
LACKING = {"other-family": ("rudder_offset",)}
"""Base -> causes that describe what its family lacks: the ships' hulls are not symmetric, a response model is."""


def base_model(text: str, vessel: str, rng: np.random.Generator) -> Model:
    """The model that a diagnoser is given for a vessel of the truth simulator; text: one of BASES, or of the vessel's
    `bugs.BUGS`."""
    bug = bug_of(vessel, text)
    return BASES[text](vessel, rng) if bug is None else bug.base()


def carried(text: str, vessel: str) -> bool:
    """Whether a vessel can be given such a base model."""
    from ....models.model import resolve

    model = resolve(vessel)
    if text == "dropped":
        return bool(_nonlinear(model))
    if text == "particulars":
        return "D_P" in model.constant_names
    return text != "other-family" or model.is_3dof


def _exact(vessel: str, rng: np.random.Generator) -> Model:
    from ....models.model import resolve

    return resolve(vessel)


def _off(share: float) -> Callable[[str, np.random.Generator], Model]:
    """All coefficients off by a normal error of this relative standard deviation, cut off at MOST."""

    def base(vessel: str, rng: np.random.Generator) -> Model:
        model = _exact(vessel, rng)
        error = np.clip(rng.standard_normal(model.coefficients.size), -MOST, MOST)
        return model.with_coefficients(model.coefficients * (1.0 + share * error))

    return base


def _nonlinear(model: Model) -> list[int]:
    """Places of nonlinear terms that are not zero."""
    linear = {"a", "b", "a1", "a2", "b1", "b2"}
    return [
        i
        for i, (name, value) in enumerate(zip(model.coordinates, model.coefficients.tolist(), strict=True))
        if value != 0.0 and name not in linear and (not model.is_3dof or sum(map(name.count, "vrd")) > 1)
    ]


def _dropped(vessel: str, rng: np.random.Generator) -> Model:
    """One nonlinear term is missing."""
    model = _exact(vessel, rng)
    values = model.coefficients.copy()
    values[int(rng.choice(_nonlinear(model)))] = 0.0
    return model.with_coefficients(values)


def _particulars(vessel: str, rng: np.random.Generator) -> Model:
    """The propeller has the diameter of another one."""
    model = _exact(vessel, rng)
    constants = model.constants.copy()
    constants[model.constant_names.index("D_P")] *= float(rng.choice(DIAMETER))
    return replace(model, constants=constants)


def _other_family(vessel: str, rng: np.random.Generator) -> Model:
    """A response model that was identified from records of the same ship without any effect."""
    from ....methods.registry import make
    from ....models.model import resolve
    from ...faults import FaultCase, inject

    found = make("output-error").fit(inject(FaultCase(vessel), rng).train, resolve(OTHER_FAMILY))
    return found.model


BASES: dict[str, Callable[[str, np.random.Generator], Model]] = {
    EXACT: _exact,
    UNSTATED: _exact,
    "off-5": _off(0.05),
    "off-10": _off(0.1),
    "off-20": _off(0.2),
    "dropped": _dropped,
    "particulars": _particulars,
    "other-family": _other_family,
}
