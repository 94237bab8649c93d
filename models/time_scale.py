"""The time that a ship's motions are scaled by."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .errors import CannotFit

if TYPE_CHECKING:
    from .model import Model

OWN_TIME = "own_time_s"
"""Particular of a model without a length: the craft's own time in the place of L/U, s."""


def ship_length_s(model: Model) -> float:
    """Time in which the ship sails her own length, s.

    Raises
    ------
    CannotFit : the model has no speed or no length.
    """
    length = model.particulars.get("L") or dict(zip(model.constant_names, model.constants, strict=True)).get("L")
    if not length or not model.speed_m_s > 0.0:
        raise CannotFit(f"model {model.id} states no length and speed to scale by")
    return float(length / model.speed_m_s)


def time_scale_s(model: Model) -> float:
    """Time in which the ship sails her own length, s; of a model built from records alone .6 over the yaw rate of a
    hard turn in them (OWN_TIME); of a response model without speed and length sqrt(T / K), as K' and T' are near one.

    Raises
    ------
    CannotFit : the model states neither.
    """
    try:
        return ship_length_s(model)
    except CannotFit:
        if OWN_TIME in model.particulars:
            return model.particulars[OWN_TIME]
        own = dict(zip(model.coordinates, np.abs(model.coefficients).tolist(), strict=True))
        gain = own.get("b", own.get("b1", np.nan) / (own.get("a1", np.nan) or np.nan))
        if {"b2", "bn"} & set(own) and "b1" not in own:  # craft: moments that go with U^2 and n^2
            speed, turns = np.nan_to_num(model.speed_m_s), np.nan_to_num(model.n0_rps or 0.0)
            gain = np.nan_to_num(gain) + own.get("b2", 0.0) * speed**2 + own.get("bn", 0.0) * turns**2
        if model.is_3dof or "bs" in own or not 0.0 < gain < np.inf:  # bs: thrusts in N instead of an angle
            raise
        return float(gain**-0.5)
