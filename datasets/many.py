"""Many runs of one model in one call, by the block kernels of `models.lanes`.

Run i is the record that `generator.record_run` makes with seed + i: the streams of random numbers are the same, the
states agree to 1e-9 of their largest value.  Only what is asked for is kept: channels, every n-th sample, indices.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cached_property
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from ..models.display import html_table
from ..models.errors import BadInput
from ..models.extras import extras_told
from ..models.lanes import Runs, closed_loops, width
from ..models.memory import require_memory
from ..models.model import Model
from ..models.simulate import ClosedLoop, SimulatedRun, initial_state
from .columns import CANONICAL
from .display import shown_name, spread_row
from .disturbances import Disturbance
from .generator import (
    DRIFT_PASSES,
    DRIFT_TOLERANCE_RAD,
    LARGEST_STATE,
    Draws,
    as_measured,
    as_record,
    channels_of,
    conditions,
    meta_of,
    no_convergence,
    steady_start,
)
from .indices import INDICES, indices
from .manoeuvres import Manoeuvre, steps
from .record import Record, RecordMeta
from .sensors import SensorSet, apply

if TYPE_CHECKING:
    import pandas as pd

BLOCK_SAMPLE = 32 * 32 * 8
"""Bytes a block takes for each of its samples: states, inputs, orders and weather of all its runs, about."""


@dataclass(frozen=True, eq=False, repr=False)
class SimulatedRuns:
    """B simulated runs of one model, SI units and radians.

    Parameters
    ----------
    time_s : (T,) s, the same for all runs.
    channels : channel name -> (B, T).
    indices : index name -> (B,), rad or m; of the ship's own motion, without noise; nan where a run does not reach it.
    diverged : (B,) whether a state left what is finite (1e6 SI units); channels and indices of such a run are nan.
    seeds : (B,) the seed of each run.
    metas : what is known about each run, or one entry for all.
    """

    time_s: np.ndarray
    channels: Mapping[str, np.ndarray]
    indices: Mapping[str, np.ndarray]
    diverged: np.ndarray
    seeds: np.ndarray
    metas: Sequence[RecordMeta]

    def __len__(self) -> int:
        return self.diverged.size

    def __repr__(self) -> str:
        told = ", ".join([*self.channels, *self.indices]) or "nothing kept"
        bad = int(np.count_nonzero(self.diverged))
        return (
            f"<SimulatedRuns: {len(self)} runs of {self.time_s.size} samples; {told}{f'; {bad} diverged' * bool(bad)}>"
        )

    def _repr_html_(self) -> str:
        rows = [spread_row(name.replace("_", " "), INDICES[name], values) for name, values in self.indices.items()]
        rows += [
            spread_row(f"{shown_name(name)} at the end", CANONICAL[name], values[:, -1])
            for name, values in self.channels.items()
        ]
        table = html_table(("quantity", "unit", "5 %", "median", "95 %"), rows)
        return f"<p>{escape(repr(self)[1:-1])}</p>{table}"

    def record(self, run: int) -> Record:
        """Run number `run` as a record, with the channels that were kept; BadInput if there is no such run."""
        if not 0 <= run < len(self):
            raise BadInput(f"there is no run {run}", hint=f"runs are numbered from 0 to {len(self) - 1}")
        meta = self.metas[run if len(self.metas) > 1 else 0]
        channels = {name: values[run] for name, values in self.channels.items()}
        return Record(self.time_s, channels, f"run {run}", replace(meta, notes=f"{meta.notes}; seed {self.seeds[run]}"))

    @extras_told()
    def to_dataframe(self) -> pd.DataFrame:
        """The channels as a pandas table: a row a run and sample, with the columns `run` and `time_s`."""
        import pandas as pd

        number, samples = np.arange(len(self)), self.time_s.size
        columns = {name: values.ravel() for name, values in self.channels.items()}
        return pd.DataFrame({"run": np.repeat(number, samples), "time_s": np.tile(self.time_s, len(self)), **columns})

    @extras_told()
    def indices_to_dataframe(self) -> pd.DataFrame:
        """The indices as a pandas table: a row a run, with the columns `run`, `seed` and `diverged`."""
        import pandas as pd

        facts = {"run": np.arange(len(self)), "seed": self.seeds, "diverged": self.diverged}
        return pd.DataFrame({**facts, **self.indices})


@dataclass(frozen=True, eq=False)
class Plan:
    """What is simulated, and what of it is kept.

    Parameters
    ----------
    manoeuvres : one for each of the B runs, or one for all.
    coefficients : (B, p).
    given : state name -> (B,), instead of the straight course at the model's speed (carried by the current).
    seed : of run 0; run i has seed + i.
    channels : names of the channels to keep.
    every : of every so many samples one is kept.
    indices : names of the indices to compute.
    """

    model: Model
    manoeuvres: Sequence[Manoeuvre]
    coefficients: np.ndarray
    dt: float
    duration_s: float
    given: Mapping[str, np.ndarray] = field(default_factory=dict)
    sensors: SensorSet = field(default_factory=SensorSet)
    disturbance: Disturbance = field(default_factory=Disturbance)
    seed: int = 0
    channels: Sequence[str] = ()
    every: int = 1
    indices: Sequence[str] = ()

    @cached_property
    def time_s(self) -> np.ndarray:
        """Times (N+1,) of the simulated samples."""
        return self.dt * np.arange(steps(self.dt, self.duration_s) + 1, dtype=float)

    def draws(self, run: int) -> Draws:
        """The random streams of a run."""
        manoeuvre = self.manoeuvres[run if len(self.manoeuvres) > 1 else 0]
        return Draws(self.model, manoeuvre, self.sensors, self.disturbance, self.seed + run)

    @cached_property
    def fixed_controls(self) -> dict[str, ClosedLoop]:
        """Manoeuvre text -> its control, for those that are the same in every run."""
        return {}

    def control(self, run: int) -> ClosedLoop:
        """What steers a run."""
        draw = self.draws(run)
        if draw.manoeuvre.random or draw.manoeuvre.series is not None:
            return draw.control(self.dt, self.duration_s)
        text = draw.manoeuvre.text
        if text not in self.fixed_controls:
            self.fixed_controls[text] = draw.control(self.dt, self.duration_s)
        return self.fixed_controls[text]


def channel_names(model: Model) -> list[str]:
    """Names of the channels that a calm simulated record of a model has."""
    return list(channels_of(model, np.zeros((1, len(model.states))), np.zeros(1), np.zeros(1)))


def duration_of(model: Model, duration_s: float | None, dt_s: float | None, samples: int | None) -> float | None:
    """The duration that was given, s, or that of commands of so many samples; None: that of the vessel's suite."""
    dt = model.suite.get("dt_s") if dt_s is None else dt_s
    return duration_s if duration_s is not None or samples is None or dt is None else (samples - 1) * float(dt)


def simulate_runs(plan: Plan, threads: int = 1) -> SimulatedRuns:
    """Simulate all runs of a plan, in blocks on so many threads.

    Raises
    ------
    BadInput : the manoeuvres differ in their integrator, the model lacks what a manoeuvre or disturbance needs, or what
        is kept does not fit into the memory.
    """
    runs, lanes = len(plan.coefficients), width(plan.model)
    kept = plan.time_s[:: plan.every]
    if len({manoeuvre.integrator for manoeuvre in plan.manoeuvres}) > 1:
        raise BadInput("some of the manoeuvres end in @euler, some do not", hint="simulate them in two calls")
    require_memory(
        8.0 * runs * (kept.size * len(plan.channels) + len(plan.indices)) + threads * BLOCK_SAMPLE * plan.time_s.size,
        f"{runs} runs of {kept.size} samples with {len(plan.channels)} channels",
    )
    channels = {name: np.empty((runs, kept.size)) for name in plan.channels}
    numbers = {name: np.empty(runs) for name in plan.indices}
    diverged = np.empty(runs, dtype=bool)

    def fill(first: int) -> None:
        rows = range(first, min(first + lanes, runs))
        part = slice(rows.start, rows.stop)
        sailed = _sailed(plan, rows)
        bad = ~(np.abs(sailed.states) < LARGEST_STATE).all(axis=(1, 2))
        true = channels_of(plan.model, sailed.states, sailed.command_rad, sailed.rudder_rad)
        for name, values in indices(plan.indices, plan.time_s, true).items():
            numbers[name][part] = np.where(bad, np.nan, values)
        shown = _shown(plan, rows, sailed, true) if plan.channels else {}
        for name in plan.channels:
            channels[name][part] = shown[name][:, :: plan.every]
            channels[name][part][bad] = np.nan
        diverged[part] = bad

    with ThreadPoolExecutor(threads) as pool:
        for _ in pool.map(fill, range(0, runs, lanes)):
            pass
    note = conditions(plan.disturbance, plan.sensors)
    of_text = {manoeuvre.text: meta_of(plan.model, manoeuvre, note) for manoeuvre in plan.manoeuvres}
    metas = [of_text[manoeuvre.text] for manoeuvre in plan.manoeuvres]
    return SimulatedRuns(kept, channels, numbers, diverged, plan.seed + np.arange(runs), metas)


def _sailed(plan: Plan, rows: range) -> Runs:
    """The runs of a block, with the wave drift as in `generator.sail`."""
    model, disturbance = plan.model, plan.disturbance
    streams = (plan.draws(run).weather("air") for run in rows)
    weather = None  # environment (W, N+1, 7) of the block
    if disturbance != Disturbance():
        weather = np.array([disturbance.environment(model, plan.time_s, stream) for stream in streams])
    start = np.tile(initial_state(model), (len(rows), 1))
    if weather is not None:
        start = np.array([steady_start(model, environment) for environment in weather])
    for name, values in plan.given.items():
        start[:, model.states.index(name)] = values[rows.start : rows.stop]
    controls = [plan.control(run) for run in rows]
    sets, integrator = plan.coefficients[rows.start : rows.stop], plan.manoeuvres[0].integrator
    runs = closed_loops(model, plan.dt, controls, sets, start, weather, integrator)
    if weather is None or not np.any(weather[:, :, 4:7]):
        return runs
    todo, column = np.arange(len(rows)), model.states.index("psi")
    for _ in range(DRIFT_PASSES):
        before = runs.states[todo, :, column]
        weather[todo, :, 4:7] = [disturbance.drift(model, heading) for heading in before]
        again = closed_loops(
            model, plan.dt, [controls[i] for i in todo], sets[todo], start[todo], weather[todo], integrator
        )
        runs.states[todo], runs.command_rad[todo], runs.rudder_rad[todo] = vars(again).values()
        todo = todo[np.abs(again.states[:, :, column] - before).max(axis=1) > DRIFT_TOLERANCE_RAD]
        if not todo.size:
            return runs
    raise no_convergence(model, disturbance)


def _shown(plan: Plan, rows: range, sailed: Runs, true: Mapping[str, np.ndarray]) -> Mapping[str, np.ndarray]:
    """Channels (W, N+1) as they are recorded."""
    whole = plan.disturbance.waves is not None or bool(plan.model.instruments)
    if not (whole or plan.sensors.channels):
        return true
    records = []
    for i, run in enumerate(rows):
        draw = plan.draws(run)
        if whole:  # moved by waves and shown by instruments
            own = SimulatedRun(plan.time_s, sailed.states[i], sailed.command_rad[i], sailed.rudder_rad[i])
            records.append(as_measured(as_record(plan.model, draw.manoeuvre, own, ""), draw))
        else:  # what a sensor draws does not depend on the other channels
            record = Record(plan.time_s, {name: true[name][i] for name in plan.channels})
            records.append(apply(record, plan.sensors, draw.noise()))
    return {name: np.array([record.column(name) for record in records]) for name in plan.channels}
