"""What counts as none and what is expected in free runs: steps, floors of errors, spreads of a record's own effects."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model

THRUST = "propeller_thrust_N"
CORRELATION = 1.7
"""Correlation time of the residuals of free runs, in ship lengths sailed (10 s for a 7 m model at 1.18 m/s)."""
STEP, INTEGRATION_STEP = 0.035, 0.05
"""Time step, in ship lengths sailed, that records are thinned to, and the largest of the integration: RK4 with it errs
by under 1e-5 of the yaw rate and the speeds of every vessel here."""
NEUTRAL_ANGLE_SD = np.deg2rad(0.3)
"""Standard deviation of a record's neutral rudder angle about the common one, rad."""
START_SD = {"u": 2.5e-3, "v": 2.5e-3, "r": 3e-3, "psi": 2e-3}
"""Standard deviation of a record's initial state about the estimated one: shares of speed, of speed / length, rad."""
UNMEASURED_SD = 0.03
"""That of velocities that no record measures, and whose start is the model's: share of speed."""
FLOOR = {"u": 2.5e-3, "v": 2.5e-3, "r": 5e-3, "psi": np.deg2rad(0.5), THRUST: 0.05}
"""Error of a whole record below which a channel counts as perfect: shares of speed, of speed / length, rad, share of
the mean thrust."""
OF_PIECES = 0.3
"""Share of FLOOR that counts as perfect in pieces, which are shorter."""


def units(model: Model, length_s: float) -> dict[str, float]:
    """State -> the unit of START_SD and FLOOR, SI; length_s : time of one ship length, s."""
    speed = model.speed_m_s if np.isfinite(model.speed_m_s) else 1.0
    return {"u": speed, "v": speed, "r": 1.0 / length_s, "psi": 1.0}


def started_states(model: Model) -> tuple[str, ...]:
    """States whose initial value belongs to a record."""
    return tuple(s for s in START_SD if s in model.states)


def start_sd(model: Model, length_s: float, measured: Collection[str]) -> np.ndarray:
    """(S,) prior standard deviations of the initial values of `started_states`, SI; measured : states that are."""
    unit = units(model, length_s)
    sd = {s: UNMEASURED_SD if s in ("u", "v") and s not in measured else share for s, share in START_SD.items()}
    return np.array([sd[s] * unit[s] for s in started_states(model)])


def coarse(record: Record, length_s: float) -> Record:
    """The record thinned to STEP."""
    return record.thinned(max(1, int(STEP * length_s / record.dt + 1e-9)))


def coarsely_integrated(model: Model, length_s: float) -> Model:
    """The model with integration steps of INTEGRATION_STEP where its own are shorter."""
    return replace(model, max_step_s=max(model.max_step_s, INTEGRATION_STEP * length_s))
