"""Base models that are wrong in their own numbers or in structure: a dimension of diagnosis suites.

The records are those of the correct ship, so that a diagnosis has to name the group of numbers, or the cause, that a
wrong number belongs to.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from ....methods.registry import make
from ....models.coefficient_groups import with_values
from ....models.model import Model, resolve

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
    BUGS."""
    bug = bug_of(vessel, text)
    return BASES[text](vessel, rng) if bug is None else bug.base()


def carried(text: str, vessel: str) -> bool:
    """Whether a vessel can be given such a base model."""
    model = resolve(vessel)
    if text == "dropped":
        return bool(_nonlinear(model))
    if text == "particulars":
        return "D_P" in model.constant_names
    return text != "other-family" or model.is_3dof


def _exact(vessel: str, rng: np.random.Generator) -> Model:
    return resolve(vessel)


def _off(share: float, vessel: str, rng: np.random.Generator) -> Model:
    """All coefficients off by a normal error of this relative standard deviation, cut off at MOST."""
    model = _exact(vessel, rng)
    error = np.clip(rng.standard_normal(model.coefficients.size), -MOST, MOST)
    return model.with_coefficients(model.coefficients * (1.0 + share * error))


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
    from ...faults import FaultCase, inject

    found = make("output-error").fit(inject(FaultCase(vessel), rng).train, resolve(OTHER_FAMILY))
    return found.model


BASES: dict[str, Callable[[str, np.random.Generator], Model]] = {
    EXACT: _exact,
    UNSTATED: _exact,
    "off-5": partial(_off, 0.05),
    "off-10": partial(_off, 0.1),
    "off-20": partial(_off, 0.2),
    "dropped": _dropped,
    "particulars": _particulars,
    "other-family": _other_family,
}


# ---- One wrong number of a kind that happens: a dimension, an axis, a sign, a unit, a forgotten term.

INFLOW, HULL_YAW, HULL_SWAY = ("rudder_inflow",), ("hull_yaw_linear",), ("hull_sway_linear",)
WAKE, RESISTANCE, INERTIA = ("wake_and_thrust_deduction",), ("resistance",), ("inertia",)
THRUST, INTERACTION = ("propeller_thrust",), ("rudder_hull",)
SIDE = ("asymmetry", "neutral_rudder_angle", "rudder_offset", "constant_force")
"""A steady side force and moment: its own group, the neutral angle that it shows as, and causes of the same effect."""
RUDDER = ("rudder_force", "rudder_effectiveness")
"""Rudder force: its slope, or the cause that says that the rudder acts more or less strongly than its angle."""
GAIN = ("turning_gain", "rudder_effectiveness")


@dataclass(frozen=True)
class Bug:
    """One documented mistake in a vessel's numbers.

    right : groups of coefficients (`models.coefficient_groups`) and causes that name it.
    factors, values : number (published parameter or constant) -> factor on it, or the wrong value itself.
    """

    vessel: str
    id: str
    title: str
    right: tuple[str, ...]
    factors: Mapping[str, float] = field(default_factory=dict)
    values: Mapping[str, float] = field(default_factory=dict)

    def base(self) -> Model:
        """The vessel's model with the mistake."""
        model = resolve(self.vessel)
        known = numbers_of(model)
        wrong = {name: known[name] * factor for name, factor in self.factors.items()} | dict(self.values)
        return with_numbers(model, wrong)

    @property
    def numbers(self) -> frozenset[str]:
        """Names of the wrong numbers."""
        return frozenset({*self.factors, *self.values})


BUGS = (
    Bug("mariner", "N_r", "yaw damping 30 % off", HULL_YAW, {"Nr": 0.7}),
    Bug("mariner", "N_v", "yaw moment of drift 30 % off", HULL_YAW, {"Nv": 1.3}),
    Bug("mariner", "Y_v", "sway damping 30 % off", HULL_SWAY, {"Yv": 0.7}),
    Bug("mariner", "rudder-moment", "yaw moment of the rudder 20 % off", ("rudder_effectiveness",), {"Nd": 0.8}),
    Bug("mariner", "stall", "the rudder's cubic terms are forgotten", ("rudder_large_angle",),
        values={"Yddd": 0.0, "Nddd": 0.0}),
    Bug("mariner", "side-force", "side force of the propeller with the wrong sign", SIDE, {"Y0": -1.0, "N0": -1.0}),
    Bug("mariner", "speed-unit", "slope of the resistance per knot instead of per m/s", RESISTANCE,
        {"Xu": 0.5144, "Xuu": 0.5144**2, "Xuuu": 0.5144**3}),
    Bug("mariner", "cross-term", "yaw moment of drift and turning 40 % off", ("hull_nonlinear",), {"Nvvr": 0.6}),
    Bug("s175", "rudder-area", "rudder area 20 % too small", RUDDER, {"A_R": 0.8}),
    Bug("s175", "propeller", "propeller of 94 % of the diameter", THRUST, {"D_P": 0.94}),
    Bug("s175", "wake", "wake fraction of the model basin, .1 too large", WAKE, values={"w_P": 0.284}),
    Bug("s175", "yaw-inertia", "yaw inertia 1.6 times too large", INERTIA, {"I_z": 1.6, "J_z": 1.6}),
    Bug("s175", "added-mass", "added mass in sway 40 % too small", INERTIA, {"m_y": 0.6}),
    Bug("s175", "rudder-lever", "lever of the rudder 20 % too short", INTERACTION, {"CRr": 0.8}),
    Bug("s175", "a_H", "force that the rudder induces on the hull is forgotten", INTERACTION, values={"CRv": 1.0}),
    Bug("s175", "N_r", "yaw damping 30 % off", HULL_YAW, {"Nur": 0.7}),
    Bug("s175", "Y_v", "sway damping 30 % off", HULL_SWAY, {"Yuv": 1.3}),
    Bug("s175", "resistance", "resistance 20 % too large", RESISTANCE, {"Xuu": 1.2}),
    Bug("s175", "flow-straightening", "flow of the turn at the rudder twice as straight", INFLOW, {"c_Rr": 0.5}),
    Bug("kvlcc2-l7", "rudder-area", "rudder area without the horn, 18 % too small", RUDDER, {"A_R": 0.82}),
    Bug("kvlcc2-l7", "propeller", "the other diameter in circulation, .216 m", THRUST, values={"D_P": 0.216}),
    Bug("kvlcc2-l7", "wake", "wake fraction of the full-scale ship, .3", WAKE, values={"w_P0": 0.3}),
    Bug("kvlcc2-l7", "thrust-deduction", "thrust deduction .12 too small", WAKE, values={"t_P": 0.1}),
    Bug("kvlcc2-l7", "yaw-inertia", "yaw inertia 1.6 times too large", INERTIA, {"I_zz": 1.6, "J_z": 1.6}),
    Bug("kvlcc2-l7", "l_R", "lever of the flow at the rudder at the rudder itself", INFLOW, values={"l_R": -0.5}),
    Bug("kvlcc2-l7", "gamma_R", "flow straightening of port and starboard exchanged", INFLOW,
        values={"gamma_R_plus": 0.395, "gamma_R_minus": 0.64}),
    Bug("kvlcc2-l7", "N_r", "yaw damping 30 % off", HULL_YAW, {"N_r": 0.7}),
    Bug("kvlcc2-l7", "N_v", "yaw moment of drift 30 % off", HULL_YAW, {"N_v": 0.7}),
    Bug("kvlcc2-l7", "Y_v", "sway damping 30 % off", HULL_SWAY, {"Y_v": 1.3}),
    Bug("kvlcc2-l7", "resistance", "resistance 20 % too large", RESISTANCE, {"R_0": 1.2}),
    Bug("kvlcc2-l7", "a_H", "force that the rudder induces on the hull is forgotten", INTERACTION,
        values={"CRv": 1.0, "CRr": -0.5}),
    Bug("kvlcc2-l7", "wake-in-turns", "wake in turns of port and starboard exchanged", ("wake_in_turns",),
        values={"C_2_plus": 1.1, "C_2_minus": 1.6}),
    Bug("cargo", "gain", "turning gain 20 % too small", GAIN, {"K": 0.8}),
    Bug("cargo", "lead", "lead of the rudder halved", ("lead",), {"T3": 0.5}),
    Bug("response-1", "gain", "turning gain 20 % too large", GAIN, {"K": 1.2}),
    Bug("response-1", "cubic", "cubic damping is forgotten", ("yaw_damping_nonlinear", "yaw_damping_cubic"),
        values={"alpha": 0.0}),
)  # fmt: skip
"""What is wrong, by ship."""


def numbers_of(model: Model) -> dict[str, float]:
    """Name -> value of a model's published parameters and constants."""
    return model.parameters | dict(zip(model.constant_names, model.constants.tolist(), strict=True))


def with_numbers(model: Model, numbers: Mapping[str, float]) -> Model:
    """The model with other values of some published parameters and constants."""
    parameters = {name: numbers.get(name, value) for name, value in model.parameters.items()}
    changed = with_values(model, {name: numbers[name] for name in model.constant_names if name in numbers})
    return changed.with_coefficients(changed.from_parameters(parameters))


def bug_of(vessel: str, name: str) -> Bug | None:
    """A ship's mistake of that id; None where it has none."""
    return next((bug for bug in BUGS if (bug.vessel, bug.id) == (vessel, name)), None)
