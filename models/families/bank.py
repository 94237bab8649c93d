"""The variant ``+bank`` of a family: every term that the estimator of diagnosis can switch on, as constants, together
with the inputs through which disturbances act."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ..definition import Definition, symbols
from .environment import with_environment
from .extensions import carries, extended

BANK_TERMS = (
    *("yaw_damping_quadratic", "yaw_damping_cubic", "sway_damping_quadratic", "crossflow_coupling"),
    *("loading_change", "second_order_lead", "speed_loss"),
)
"""Extensions that the bank variant holds as constants; the others act through its inputs."""


def with_bank(definition: Definition, terms: Sequence[str] = ()) -> Definition:
    """The variant that the estimator of diagnosis runs: every added term as a constant, disturbances as inputs.

    terms : product terms that it holds beside BANK_TERMS.

    A 3-DOF model gets the inputs of the environment variant.  A response model gets ``force`` (added to the yaw
    equation) and ``force_rate`` (added to r_dot where that is a kinematic state).
    """
    base = definition
    for name in (*BANK_TERMS, *terms):
        if carries(base, name):
            grown = extended(base, name)
            extra = grown.coefficients[len(base.coefficients) :]
            base = replace(
                grown,
                coefficients=base.coefficients,
                constants=[*grown.constants, *extra],
                units=definition.units,
                public=definition.public,
                inverse=definition.inverse,
            )
    bank = with_environment(base) if definition.force_scale is not None else _with_forces(base)
    return replace(bank, name="~".join([f"{definition.name}+bank", *terms]))


def _with_forces(definition: Definition) -> Definition:
    force, rate = symbols("force force_rate")
    names = [symbol.name for symbol in definition.states]
    place = names.index("r") - len(definition.forces)
    kinematics = list(definition.kinematics)
    inputs = [*definition.inputs, force]
    if place >= 0:
        kinematics[place] += rate
        inputs.append(rate)
    forces = [definition.forces[0] + force, *definition.forces[1:]]
    return replace(definition, forces=forces, kinematics=kinematics, inputs=inputs)
