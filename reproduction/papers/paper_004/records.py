"""Runs of the container ship in sea state 5, and what a model predicts of a run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ....datasets.disturbances import parse_disturbance
from ....datasets.generator import as_record, record_run, require_finite, sail
from ....datasets.manoeuvres import parse_manoeuvre
from ....datasets.record import Record
from ....estimation.run.prediction import prediction_scores
from ....estimation.run.run import run_along
from ....models.model import Model, resolve

SEA = "wind:10@{0}+waves:3.25/8.5@{0}"
"""Sea state 5: mean wind 10 m/s with gusts and waves of 3.25 m from one direction."""
DIRECTIONS = tuple(range(0, 360, 30))
STEP_S, DURATION_S = 0.5, 600.0
RATES = ("surge_m_s", "sway_m_s", "yaw_rate_rad_s")


def calm(model: Model, text: str, duration_s: float = DURATION_S) -> Record:
    """A run in calm water."""
    return record_run(model, parse_manoeuvre(text), duration_s=duration_s, dt_s=STEP_S)


def rough(
    model: Model,
    text: str,
    direction_deg: float,
    rng: np.random.Generator,
    swell: bool = False,
    duration_s: float = DURATION_S,
) -> Record:
    """A run in sea state 5: gusts and mean wave forces as in eq 36-39, with `swell` first-order wave motion too."""
    manoeuvre, sea = parse_manoeuvre(text), parse_disturbance(SEA.format(direction_deg))
    control = manoeuvre.control(model, STEP_S, duration_s, rng)
    environment = sea.environment(model, STEP_S * np.arange(len(control.reference)), rng)
    run = sail(model, STEP_S, control, sea, environment, manoeuvre.integrator)
    require_finite(model, manoeuvre, run)
    record = as_record(model, manoeuvre, run, sea.text)
    return sea.motion(model, record, rng) if swell else record


def prediction_error(model: Model, records: Sequence[Record]) -> float:
    """Free-run error over the standard deviation, rms over surge, sway and yaw rate; nan if a run diverges."""
    scores = prediction_scores(model, records)
    if scores["diverged"]:
        return float("nan")
    return float(np.sqrt(np.mean([1.0 - scores[f"r2_free_{channel}"] for channel in RATES])))


def explained(model: Model, records: Sequence[Record]) -> float:
    """R^2 of the yaw rate in free runs; minus infinity has no number, so nan where one diverges."""
    scores = prediction_scores(model, records)
    return float("nan") if scores["diverged"] else float(scores["r2_free_yaw_rate_rad_s"])


def free_run(model: Model, record: Record) -> dict[str, np.ndarray] | None:
    """Predicted channels (N,) of a record; None if the run diverges."""
    run = run_along(model, record)
    return None if run.diverged else dict(run.predicted)


def distances(run: dict[str, np.ndarray], record: Record) -> np.ndarray:
    """Distance (N,) in m between a predicted track and the record's."""
    return np.hypot(*(run[channel] - record.column(channel) for channel in ("north_m", "east_m")))


def track_error(model: Model, record: Record) -> float:
    """Root mean square distance in m between the predicted track and the record's; nan if the run diverges."""
    run = free_run(model, record)
    return float("nan") if run is None else float(np.sqrt(np.mean(distances(run, record) ** 2)))


def stand_in() -> Model:
    """Paper 004's structure, coefficients unknown, with the particulars of the KVLCC2 as those of the unknown ship.

    Primes by 0.5 rho L^3; propeller and rudder without what eq 4-10 do not have: wake and flow straightening do not
    change with the drift, and x_G = 0.
    """
    ship, structure = resolve("kvlcc2-l7"), resolve("s175-polynomial")
    c = dict(zip(ship.constant_names, ship.constants.tolist(), strict=True))
    straight = 0.5 * (c["gamma_R_plus"] + c["gamma_R_minus"])
    numbers = {name: c[name] for name in ("L", "D_P", "x_P", "A_R", "f_alpha", "epsilon")}
    numbers |= {name: c[name] * c["d"] / c["L"] for name in ("m_x", "m_y", "J_z")}
    numbers |= {"m": 2.0 * c["nabla"] / c["L"] ** 3, "I_z": 2.0 * c["I_zz"] / (c["rho"] * c["L"] ** 5)}
    numbers |= {"w_P": c["w_P0"], "tau": 0.0, "a_0": c["k_0"], "a_1": c["k_1"], "a_2": c["k_2"], "k_x": c["kappa"]}
    numbers |= {"gamma_R": straight, "c_Rr": straight * c["l_R"], "c_Rrrr": 0.0, "c_Rrrv": 0.0, "U0": ship.speed_m_s}
    return replace(
        structure.blanked(),
        id="kvlcc2-l7 in the structure of paper 004",
        vessel="kvlcc2-l7",
        constants=np.array([numbers[name] for name in structure.constant_names]),
        speed_m_s=ship.speed_m_s,
        n0_rps=ship.n0_rps,
        max_step_s=ship.max_step_s,
        rudder=ship.rudder,
        windage=None,
        particulars=ship.particulars,
        suite=ship.suite,
    )
