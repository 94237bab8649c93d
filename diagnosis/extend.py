"""The extended model: the base model with the accepted causes built in, as a model like any other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..methods.innovations.estimator import Estimator, Setting
from ..methods.innovations.layout import OUTER
from ..models import kernels as kernel_store
from ..models.families.extensions import EXTENSIONS, carries
from ..models.instruments import SENSORS, SWAPS, combined
from ..models.model import Model
from .flags import Flag
from .kinematics import Tracks

TERMS = {
    "yaw_damping_quadratic": ("added_Nr_absr",),
    "yaw_damping_cubic": ("added_Nrrr",),
    "sway_damping_quadratic": ("added_Yv_absv",),
    "crossflow_coupling": ("added_Yr_absv", "added_Yv_absr", "added_Nv_absr", "added_Nr_absv"),
    "loading_change": ("loading_fraction",),
    "second_order_lead": ("lead", "lead_T2"),
    "speed_loss": ("loss_gain", "loss_time", "loss_power"),
    "rudder_offset": ("rudder_offset",),
    "rudder_effectiveness": ("rudder_effectiveness",),
    "current": ("current_n", "current_e"),
    "wind": ("wind_n", "wind_e"),
    "constant_force": ("force_0", "force_1", "force_2"),
    "wave_drift": ("drift_n", "drift_e"),
}
"""Entries of the parameter vector that become coefficients of an extension."""
RESPONSE = {"constant_force": "constant_yaw"}
SENSOR_NAMES = dict(
    zip(("psi", "r", "u", "v", "x", "y"), ("heading", "yaw_rate", "surge", "sway", "north", "east"), strict=True)
)
INSTRUMENT_OF = {
    "rudder_effectiveness": "rudder_effectiveness",
    "rudder_offset": "rudder_offset",
    "rudder_delay": "rudder_delay",
    "rudder_play": "rudder_backlash",
    "fault": "rudder_fault",
    "fault_time": "rudder_fault_time",
    "rudder_rate": "rudder_rate_limit",
    "rudder_limit": "rudder_saturation",
    "misalignment": "axis_misalignment",
    "wave_frequency": "wave_frequency",
    "wave_damping": "wave_damping",
    "wave_rms": "wave_rms",
    **{f"{kind}_{c}": f"{name}_{kind}" for c, name in SENSOR_NAMES.items() for kind in ("scale", "bias", "delay")},
}
"""Entry of the filter's parameter vector -> instrument of a model."""


def extended_model(
    est: Estimator, s: Setting, causes: Sequence[str], flags: Sequence[Flag] = (), tracks: Tracks | None = None
) -> Model:
    """The model at a setting with the causes as extensions of its family, else as instruments.

    A quantity per record enters as its mean over the training records.
    """
    model = est.model
    row = np.where(np.all(s.p == s.p[0], axis=0), s.p[0], s.p.mean(axis=0))
    n = len(model.coordinates)
    family, values, taken = model.family, list(row[:n]), set()
    for cause in causes:
        slots = TERMS.get(cause)
        name = cause if model.is_3dof else RESPONSE.get(cause, cause)
        if slots is None or name not in EXTENSIONS or not carries(kernel_store.definition_of(family), name):
            continue
        family = f"{family}+{name}"
        own = [row[est.index[slot]] for slot in slots[: len(EXTENSIONS[name].units)]]
        if cause == "constant_force":
            own = [x * unit for x, unit in zip(own, est.unit, strict=False)]
        if cause == "wave_drift":
            own = [x * est.unit[0] for x in own]
        values += own
        taken |= {est.index[slot] for slot in slots}
    before = _switches(flags) | dict(tracks.instruments if tracks else ())
    extended = replace(model, id=_named(model, causes), family=family, coefficients=np.array(values, float))
    return replace(
        extended,
        constants=_constants(extended, est),
        instruments=combined(model.instruments, {**_instruments(est, row, taken), **before}),
    )


def _named(model: Model, causes: Sequence[str]) -> str:
    return "+".join([model.id.partition("+")[0], *causes])


def _constants(extended: Model, est: Estimator) -> np.ndarray:
    """Constants of the extended family: the base model's, and those that its terms brought along."""
    known = dict(zip(est.model.constant_names, est.model.constants, strict=True))
    known = {name: est.base[i] for name, i in est.index.items() if name not in OUTER} | known
    names = kernel_store.load(extended.family).CONSTANTS
    return np.array([known[name] for name in names], float)


def _instruments(est: Estimator, row: np.ndarray, taken: set[int]) -> dict[str, float]:
    """Rudder linkage, sensors and waves that differ from the ideal and are not in the equations."""
    waves = row[est.index["wave_rms"]] > 0.0
    found = {}
    for slot, name in INSTRUMENT_OF.items():
        i = est.index[slot]
        if i not in taken and (row[i] != est.base[i] or (waves and name.startswith("wave_"))):
            found[name] = float(row[i])
    return found


def _switches(flags: Sequence[Flag]) -> dict[str, float]:
    """Gross faults as instruments."""
    columns = {column: name for name, (column, _) in SENSORS.items()}
    found = {}
    for flag in flags:
        if flag.cause == "rudder_sign":
            found["rudder_reversed"] = 1.0
        elif flag.cause == "earth_frame_velocity":
            found["earth_frame_velocity"] = 1.0
        else:
            pair = {columns[name] for name in flag.details["channels"]}
            found |= {key: 1.0 for key, swap in SWAPS.items() if {columns[c] for c in swap} == pair}
    return found
