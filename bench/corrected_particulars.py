"""Fresh situations by the simulation of the ship's particulars, corrected by the training records.

What somebody can take who does not know a ship's equations but has her particulars: `models/particulars.py` makes a
model of them, and `calibrate` moves the numbers of it that the training records determine.
"""

from __future__ import annotations

from ..diagnosis.calibration.calibrate import corrected_particulars
from ..estimation.run.prediction import prediction_scores
from ..models.model import Model, model_from_particulars, resolve
from ..models.particulars import particulars_of
from .kinds.identification.problems import Task, problem
from .scores.prediction_error import mean_nrmse
from .situations import SEEDS, Situation

CHANNELS = ("heading_rad", "yaw_rate_rad_s")
"""What response models predict, so that errors compare."""


def simulation_of(vessel: str) -> Model | None:
    """The model that the particulars of a vessel give; None where her file states too few."""
    ship = resolve(vessel)
    stated = particulars_of(ship)
    return None if stated is None else model_from_particulars(stated, f"{ship.id}-particulars")


def errors_of(one: Situation) -> list[float] | None:
    """Mean over `CHANNELS` of sqrt(1 - R^2) of the held-out records in free run, for each draw of the noise.

    It is infinite where the corrected model diverges; None where the vessel's file states too few particulars.
    """
    simulation = simulation_of(one.vessel)
    if simulation is None:
        return None
    facts = (one.vessel, one.model, one.model, one.train, one.held_out, one.noise, one.disturbance)
    return [_error(Task(*facts, seed=seed), simulation) for seed in range(SEEDS)]


def _error(task: Task, simulation: Model) -> float:
    records = problem(task)
    train, held_out = (
        [record.turned(simulation.positive_rudder) for record in own] for own in (records.train, records.held_out)
    )
    return mean_nrmse(prediction_scores(corrected_particulars(simulation, train)[0], held_out), CHANNELS)
