"""Scales of free runs: sizes of the states, what belongs to a record, and steps in ship lengths.

The numbers are those of calibrations (`estimation/diagnosis_only/mixed_effects/problem.py`).
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...estimation.diagnosis_only.mixed_effects.problem import INTEGRATION_STEP, NEUTRAL_ANGLE_SD, START_SD, STEP

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model

REFERENCE_S = 160.0 / (15.0 * 1852.0 / 3600.0)
"""L/U of a ship of 160 m at 15 kn, s."""


def units(model: Model, length_s: float) -> dict[str, float]:
    """State -> the unit of START_SD and FLOOR, SI; length_s : time of one ship length, s."""
    speed = model.speed_m_s if np.isfinite(model.speed_m_s) else 1.0
    return {"u": speed, "v": speed, "r": 1.0 / length_s, "psi": 1.0}


def own_sd(model: Model, length_s: float) -> dict[str, float]:
    """Prior standard deviations of a record's own effects, SI: neutral rudder angle, then its initial states."""
    unit = units(model, length_s)
    return {"delta": NEUTRAL_ANGLE_SD, **{s: sd * unit[s] for s, sd in START_SD.items() if s in model.states}}


def coarse(record: Record, length_s: float) -> Record:
    """The record thinned to STEP."""
    return record.thinned(max(1, int(STEP * length_s / record.dt + 1e-9)))


def coarsely_integrated(model: Model, length_s: float) -> Model:
    """The model with integration steps of INTEGRATION_STEP where its own are shorter."""
    return replace(model, max_step_s=max(model.max_step_s, INTEGRATION_STEP * length_s))
