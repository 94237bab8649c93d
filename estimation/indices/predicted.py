"""Indices of the family `turning-response` for many sets of parameters at once."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from ...datasets.generator import channels_of
from ...datasets.indices_of_many import indices
from ...datasets.manoeuvres import parse_manoeuvre
from ...models import kernels
from ...models.lanes import closed_loops, width
from ...models.model import Model
from .given import GivenShip

FAMILY = "turning-response"
STEPS = 60
"""Samples in the time L/U."""
LENGTHS = {"turn": 50, "zigzag": 35}
"""Times L/U that a manoeuvre takes: about 540 degrees of a turn, and two overshoots."""
Array = NDArray[np.float64]


def model_of(ship: GivenShip, parameters: Mapping[str, float]) -> Model:
    """The ship as a model with these published parameters."""
    known = kernels.load(FAMILY)
    clock = ship.length_m / ship.speed_m_s
    blank = Model(
        id=ship.name,
        family=FAMILY,
        coefficients=np.full(len(known.COEFFICIENTS), np.nan),
        constants=np.array([ship.length_m, ship.speed_m_s]),
        title=f"{ship.name}, from manoeuvring indices",
        source="manoeuvring indices",
        speed_m_s=ship.speed_m_s,
        max_step_s=clock / STEPS,
        rudder=ship.gear,
        particulars={"L": ship.length_m},
    )
    return blank.with_coefficients(blank.from_parameters(parameters))


def predicted(model: Model, parameters: Array, wanted: Iterable[tuple[str, str]]) -> Array:
    """Indices (B, k), SI units, of parameter sets (B, q) for k pairs of manoeuvre and index; nan where not reached."""
    pairs, clock = list(wanted), model.particulars["L"] / model.speed_m_s
    dt, sets = clock / STEPS, np.array([model.from_parameters(row) for row in parameters])
    found: dict[tuple[str, str], Array] = {}
    for text in dict.fromkeys(text for text, _ in pairs):
        names = [name for own, name in pairs if own == text]
        parts = [
            _of_block(model, sets[first : first + width(model)], text, names, dt)
            for first in range(0, len(sets), width(model))
        ]
        found |= {(text, name): np.concatenate([part[name] for part in parts]) for name in names}
    return np.column_stack([found[pair] for pair in pairs])


def _of_block(model: Model, sets: Array, text: str, names: list[str], dt: float) -> dict[str, Array]:
    manoeuvre = parse_manoeuvre(text)
    control = manoeuvre.control(model, dt, LENGTHS[manoeuvre.kind] * STEPS * dt, np.random.default_rng(0))
    with np.errstate(all="ignore"):
        run = closed_loops(model, dt, [control] * len(sets), sets)
        channels = channels_of(model, run.states, run.command_rad, run.rudder_rad)
        return indices(names, dt * np.arange(run.states.shape[1]), channels)
