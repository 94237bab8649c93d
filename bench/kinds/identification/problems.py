"""Identification problems: the records, the blank model and the truth that one row of a suite is made of.

A `Task` is plain data; its `FitTask` is made from it in the worker that runs the row, so that only a few strings are
sent.  Problems are kept while rows of the same task follow each other.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from math import ceil
from pathlib import Path

import numpy as np

from ....datasets.disturbances import Disturbance, parse_disturbance
from ....datasets.generator import check, measured_again, record_run
from ....datasets.instruments import corrected
from ....datasets.io import read_record
from ....datasets.manoeuvres import Manoeuvre, parse_manoeuvre
from ....datasets.measured import load
from ....datasets.record import Record
from ....datasets.sensors import SensorSet, parse_noise
from ....estimation.information.bounds import cramer_rao
from ....models.errors import BadInput
from ....models.extend import extended
from ....models.model import CHANNELS, Model, resolve
from ....models.simulate import state_matrices

HELD_OUT_SEED = 1_000_003
"""Seed of every simulated held-out record: never that of a training record, and the same for every row."""
IDENTIFIABLE_NOISE, IDENTIFIABLE_SHARE = "low", 0.5
"""A parameter counts as identifiable where its Cramer-Rao bound at this noise is below this share of its size."""
GIVEN, DERIVED = "given", "derived"


Terms = tuple[tuple[str, tuple[tuple[str, float], ...]], ...]
"""Extensions of a ship's equations, each with its parameters."""


@dataclass(frozen=True)
class Task:
    """What is identified from what: texts and numbers only.

    `constants` are factors on constants of the fitted model, `terms` forces that the ship has and the model lacks.

    `vessel` is a vessel id, or the measured set's name where `measured` is true; `source` is what the fitted model is
    resolved from and `model` its family.  `duration_s` and `dt_s` override the vessel file's for training records,
    of which the first `length` (a share) is kept, and of that every `thinning`-th sample.  Held-out records may have a
    noise, a disturbance and a start speed (share of the vessel's) of their own, or come from another measured set.

    Of the user's own are a ship whose file is `vessel_file`, and records that are paths where `own_records` is true, in
    the rudder sign `positive_rudder` unless that is None; `digest` is of the content of all such files.
    """

    vessel: str
    source: str
    model: str
    train: tuple[str, ...]
    held_out: tuple[str, ...]
    noise: str = "none"
    disturbance: str = "none"
    seed: int = 0
    thinning: int = 1
    length: float = 1.0
    measured: bool = False
    duration_s: float | None = None
    dt_s: float | None = None
    held_out_noise: str = "none"
    held_out_disturbance: str = "none"
    held_out_speed: float = 1.0
    held_out_dataset: str | None = None
    vessel_file: str | None = None
    own_records: bool = False
    positive_rudder: str | None = None
    digest: str | None = None
    constants: tuple[tuple[str, float], ...] = ()
    terms: Terms = ()

    @property
    def ship(self) -> str:
        """What the vessel is resolved from."""
        return self.vessel_file or self.vessel

    @property
    def train_text(self) -> str:
        """The training records as the tables name them."""
        return "+".join(self._names(self.train))

    def _names(self, records: Sequence[str]) -> list[str]:
        return [Path(text).stem for text in records] if self.own_records else list(records)

    @property
    def held_out_text(self) -> str:
        """The held-out records with the conditions that are not those of a calm run without noise."""
        conditions = {
            "set": self.held_out_dataset or "",
            "noise": self.held_out_noise.removeprefix("none"),
            "in": self.held_out_disturbance.removeprefix("none"),
            "start speed": "" if self.held_out_speed == 1.0 else f"{self.held_out_speed:g}",
        }
        told = [f"{name} {value}" for name, value in conditions.items() if value]
        return "+".join(self._names(self.held_out)) + (f" ({', '.join(told)})" if told else "")


@dataclass(frozen=True)
class Truth:
    """True values of the published parameters and what the training records can tell of them.

    `values` (name -> value) holds what is known, `kind` says how: `given` by the vessel file or `derived` by
    linearising the vessel.  `crb_sd` and `identifiable` are empty where no bound can be stated.
    """

    values: Mapping[str, float] = field(default_factory=dict)
    kind: str | None = None
    crb_sd: Mapping[str, float] = field(default_factory=dict)
    identifiable: Mapping[str, bool] = field(default_factory=dict)


@dataclass(frozen=True)
class FitTask:
    """Records and blank model of a task; `model` carries no coefficients; measured: the records are no simulations."""

    model: Model
    train: tuple[Record, ...]
    held_out: tuple[Record, ...]
    truth: Truth
    measured: bool = False

    @property
    def n_samples(self) -> int:
        """Number of training samples."""
        return sum(record.n for record in self.train)


@lru_cache(maxsize=4)
def problem(task: Task) -> FitTask:
    """The problem of a task.

    Raises `BadInput` where a text is not understood, a measured file is missing or the vessel cannot do it.
    """
    model = fitted_model(task)
    if task.measured:
        own = measured_records(task, task.train, task.vessel)
        train = tuple(_kept(_parsed("straight", task.noise)[1].on_board(record), task) for record in own)
        held_out = measured_records(task, task.held_out, task.held_out_dataset or task.vessel)
        known = Truth()
    else:
        train = _records(task, task.train, task.noise, task.disturbance)
        weather = (task.held_out_noise, task.held_out_disturbance)
        timing = (task.duration_s, task.dt_s, task.held_out_speed)
        held_out = tuple(
            _record(task.ship, manoeuvre, *weather, HELD_OUT_SEED, *timing, task.terms) for manoeuvre in task.held_out
        )
        known = truth(task, model)
    return FitTask(model, _corrected(train, model), _corrected(held_out, model), known, task.measured)


def fitted_model(task: Task) -> Model:
    """The model that is fitted, without coefficients; BadInput for a constant that it does not have."""
    model, factors = resolve(task.source).blanked(), dict(task.constants)
    unknown = [name for name in factors if name not in model.constant_names]
    if unknown:
        raise BadInput(f"{model.id} has no constant {unknown[0]!r}", hint=f"it has {', '.join(model.constant_names)}")
    scale = np.array([factors.get(name, 1.0) for name in model.constant_names])
    return replace(model, constants=model.constants * scale)


def sailing_model(ship: str, terms: Terms) -> Model:
    """The ship as it sails; BadInput for a term that it cannot have."""
    model = resolve(ship)
    for extension, values in terms:
        model = extended(model, extension, dict(values))
    return model


def _corrected(records: tuple[Record, ...], model: Model) -> tuple[Record, ...]:
    """Records in the model's rudder sign, freed of what it knows of its instruments."""
    if not model.instruments:
        return records
    return tuple(corrected(record.turned(model.positive_rudder), model.instruments) for record in records)


def truth(task: Task, model: Model) -> Truth:
    """True parameters of `model` on the task's vessel, with their bounds at the task's noise."""
    vessel = sailing_model(task.ship, task.terms)
    if model.family == vessel.family:
        same = np.array_equal(model.constants, vessel.constants)
        return _bounded(task, vessel, vessel.parameters, GIVEN) if same else Truth()
    values = derived_parameters(vessel, model)
    if not values:
        return Truth()
    if set(values) != set(model.parameter_names):
        return Truth(values, DERIVED)
    return _bounded(task, model.with_coefficients(model.from_parameters(values)), values, DERIVED)


def derived_parameters(vessel: Model, model: Model) -> dict[str, float]:
    """Parameters of a response model that a vessel with sway and yaw has when linearised at its straight course.

    Eliminating sway gives r_ddot = a1 r_dot + a2 r + b1 delta + b2 delta_rate (paper 000, eq 5); the first-order
    time constant is T1 + T2 - T3.  Damping coefficients have no derived value and are left out, and so is everything
    where the vessel has no sway state or the model is no response model.
    """
    if "v" not in vessel.states or "v" in model.states or "r" not in vessel.states:
        return {}
    pick = [vessel.states.index("v"), vessel.states.index("r")]
    a, b = state_matrices(vessel)
    (avv, avr), (arv, arr) = a[np.ix_(pick, pick)]
    bv, br = b[pick, 0] * vessel.starboard * model.starboard
    a1, a2, b1, b2 = map(float, (avv + arr, avr * arv - avv * arr, arv * bv - avv * br, br))
    h, g, t3, gain = -1.0 / a2, a1 / a2, b2 / b1, -b1 / a2
    root = np.sqrt(g * g - 4.0 * h) if g * g >= 4.0 * h else np.nan
    chosen: dict[str, float] = {}
    if model.family == "kt":
        chosen = {"T1": -a1, "T2": -a2, "K": b1, "T3": b2}
    elif model.family.startswith("nomoto-"):
        chosen = {"T": g - t3, "T1": (g + root) / 2.0, "T2": (g - root) / 2.0, "h": h, "g": g, "T3": t3, "K": gain}
    return {name: chosen[name] for name in model.parameter_names if np.isfinite(chosen.get(name, np.nan))}


def _bounded(task: Task, known: Model, values: Mapping[str, float], kind: str) -> Truth:
    """Truth with Cramer-Rao bounds, from the same manoeuvres without noise and disturbance."""
    calm = _calm(task)
    at_row, at_low = _calm_bounds(calm, known, task.noise), _calm_bounds(calm, known, IDENTIFIABLE_NOISE)
    identifiable = {name: at_low[name] < IDENTIFIABLE_SHARE * abs(value) for name, value in values.items() if value}
    return Truth(dict(values), kind, dict(at_row), identifiable if at_low else {})


def _calm(task: Task) -> Task:
    """The training records without noise and disturbance: the same for all seeds unless a manoeuvre is random."""
    seed = task.seed if any(_parsed(text)[0].random for text in task.train) else 0
    calm = {"noise": "none", "disturbance": "none", "held_out_noise": "none", "held_out_disturbance": "none"}
    return replace(task, held_out=(), held_out_speed=1.0, constants=(), seed=seed, **calm)


@lru_cache(maxsize=64)
def _calm_bounds(calm: Task, known: Model, noise: str) -> Mapping[str, float]:
    """`cramer_rao_sd` of the records of a calm task."""
    return cramer_rao_sd(known, _records(calm, calm.train, "none", "none"), noise)


def cramer_rao_sd(known: Model, records: Sequence[Record], noise: str) -> dict[str, float]:
    """Cramer-Rao bound of every published parameter as a standard deviation; empty without noise.

    All recorded states count, positions too; the rudder is taken as exact.  A parameter that the records do not tell
    at all has an infinite bound.
    """
    sensors = parse_noise(noise)
    states = [CHANNELS[state] for state in known.states if state in CHANNELS]
    sd = {name: sensors.sd(name) for name in states if sensors.sd(name) > 0.0 and name not in sensors.missing}
    if not sd:
        return {}
    bounds, _ = cramer_rao(known, list(records), sd)
    return dict(zip(known.parameter_names, (float(bound) for bound in bounds), strict=True))


def _records(task: Task, manoeuvres: Sequence[str], noise: str, disturbance: str) -> tuple[Record, ...]:
    timing = (task.duration_s, task.dt_s, 1.0)
    return tuple(
        _kept(_record(task.ship, manoeuvre, noise, disturbance, task.seed, *timing, task.terms), task)
        for manoeuvre in manoeuvres
    )


def _kept(record: Record, task: Task) -> Record:
    """What of a training record the task takes."""
    return record.slice(0, ceil(task.length * record.n)).thinned(task.thinning)


@lru_cache(maxsize=64)
def _record(
    vessel: str,
    manoeuvre: str,
    noise: str,
    disturbance: str,
    seed: int,
    duration_s: float | None,
    dt_s: float | None,
    start_speed: float,
    terms: Terms,
) -> Record:
    model, (performed, sensors, weather) = sailing_model(vessel, terms), _parsed(manoeuvre, noise, disturbance)
    if noise != "none" and disturbance == "none" and not model.instruments:
        drawn = seed if performed.random else 0
        calm = _record(vessel, manoeuvre, "none", "none", drawn, duration_s, dt_s, start_speed, terms)
        return measured_again(calm, model, performed, sensors, seed)
    timing = {"duration_s": duration_s, "dt_s": dt_s, "start_speed": start_speed}
    return record_run(model, performed, sensors, weather, seed=seed, **timing)


@lru_cache(maxsize=64)
def _parsed(manoeuvre: str, noise: str = "none", disturbance: str = "none") -> tuple[Manoeuvre, SensorSet, Disturbance]:
    return parse_manoeuvre(manoeuvre), parse_noise(noise), parse_disturbance(disturbance)


def measured_records(task: Task, records: Sequence[str], dataset: str) -> tuple[Record, ...]:
    """Records of a measured set, or the user's own; BadInput where one is missing or cannot be used."""
    if task.own_records:
        return tuple(_read(path, task.positive_rudder) for path in records)
    return tuple(_load(dataset, stem) for stem in records)


_read, _load = lru_cache(maxsize=32)(read_record), lru_cache(maxsize=32)(load)


def check_task(task: Task) -> None:
    """BadInput where a text of a simulated task is not understood, or its vessel cannot do what it says."""
    ship = sailing_model(task.ship, task.terms)
    fitted_model(task)
    for manoeuvres, noise, disturbance in (
        (task.train, task.noise, task.disturbance),
        (task.held_out, task.held_out_noise, task.held_out_disturbance),
    ):
        for manoeuvre in manoeuvres:
            _, _, weather = _parsed(manoeuvre, noise, disturbance)
            check(ship, weather, task.seed)
