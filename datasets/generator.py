"""The generator: vessel x manoeuvre x noise x disturbance x seed -> Record, always the same one.

Every random choice comes from a stream named by the seed and the case's texts, so a record does not depend on
what else was generated. The manoeuvre's stream knows neither noise nor disturbance and the disturbance's does
not know the noise: cases that differ in noise only are measurements of one and the same run.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..models.argument_types import typed
from ..models.errors import BadInput
from ..models.memory import SIMULATED_SAMPLE, require_memory
from ..models.model import CHANNELS, Model, resolve
from ..models.simulate import ClosedLoop, SimulatedRun, closed_loop, initial_state
from .disturbances import Disturbance, parse_disturbance
from .instruments import behind_play, observed
from .manoeuvres import EULER, Manoeuvre, parse_manoeuvre, steps
from .randomness import stream
from .record import Record, RecordMeta, is_side
from .sensors import SensorSet, apply, parse_noise

DRIFT_PASSES = 60
DRIFT_TOLERANCE_RAD = 1e-10
LARGEST_STATE = 1e6
STEPS_IN_A_LENGTH, LENGTHS = 20.0, 50.0
"""Samples in the time L/U, and lengths that a run takes, where a vessel does not say."""
SUGGESTED = {"train": ["zigzag:10/10", "zigzag:20/20", "turn:25"], "held_out": ["zigzag:30/30", "turn:35:port"]}


@dataclass(frozen=True)
class Case:
    """One record to generate: texts as on the command line, seed, duration and sampling step.

    ``duration_s`` and ``dt_s`` default to the vessel suite's.
    """

    vessel: str
    manoeuvre: str
    noise: str = "none"
    disturbance: str = "none"
    seed: int = 0
    duration_s: float | None = None
    dt_s: float | None = None


@typed
def generate(case: Case) -> Record:
    """The record of a case, noise included.

    Raises BadInput for an unknown vessel, a malformed text, a disturbance that the model cannot take, a missing
    duration or step, or a run that diverges.
    """
    return record_run(
        resolve(case.vessel),
        parse_manoeuvre(case.manoeuvre),
        parse_noise(case.noise),
        parse_disturbance(case.disturbance),
        seed=case.seed,
        duration_s=case.duration_s,
        dt_s=case.dt_s,
    )


def record_run(
    model: Model,
    manoeuvre: Manoeuvre,
    sensors: SensorSet | None = None,
    disturbance: Disturbance | None = None,
    *,
    seed: int = 0,
    duration_s: float | None = None,
    dt_s: float | None = None,
    start_speed: float = 1.0,
) -> Record:
    """As `generate`, for parts that have no text: any Model, a free rudder series, sensors built in Python.

    The record is what the model's instruments show; its helmsman steers by the true heading.  `start_speed` is the
    speed of the first sample as a share of the model's; the propeller stays as it is set.
    """
    sensors, disturbance = sensors or SensorSet(), disturbance or Disturbance()
    check(model, disturbance, seed)
    dt, duration = sampling(model, duration_s, dt_s)
    require_memory(SIMULATED_SAMPLE * steps(dt, duration), f"{steps(dt, duration)} samples of {manoeuvre.text!r}")
    draw = Draws(model, manoeuvre, sensors, disturbance, seed)
    control = draw.control(dt, duration)
    environment = disturbance.environment(model, dt * np.arange(steps(dt, duration) + 1), draw.weather("air"))
    run = sail(model, dt, control, disturbance, environment, manoeuvre.integrator, start_speed)
    require_finite(model, manoeuvre, run)
    return as_measured(as_record(model, manoeuvre, run, draw.note), draw)


def measured_again(calm: Record, model: Model, manoeuvre: Manoeuvre, sensors: SensorSet, seed: int) -> Record:
    """What `record_run` gives with these sensors, from `calm`, its record without noise and disturbance.

    For a model with ideal instruments, and a manoeuvre that is not drawn at random or was drawn with the same seed.
    """
    draw = Draws(model, manoeuvre, sensors, Disturbance(), seed)
    check(model, draw.disturbance, seed)
    return apply(calm, sensors, draw.noise(), replace(calm.meta, notes=draw.note))


@dataclass(frozen=True)
class Draws:
    """The random streams of one run, and what they are named by."""

    model: Model
    manoeuvre: Manoeuvre
    sensors: SensorSet
    disturbance: Disturbance
    seed: int

    def control(self, dt: float, duration_s: float) -> ClosedLoop:
        """The closed loop of the manoeuvre."""
        return self.manoeuvre.control(self.model, dt, duration_s, stream(self.seed, "manoeuvre", *self._run))

    def weather(self, what: str) -> np.random.Generator:
        """Stream of the air, the waves or the instruments' waves."""
        return stream(self.seed, what, *self._run, self.disturbance.text)

    def noise(self) -> np.random.Generator:
        """Stream of the sensors."""
        return stream(self.seed, "sensors", *self._run, self.disturbance.text, self.sensors.text)

    @property
    def note(self) -> str:
        """What the record's metadata tell of the draws."""
        return f"{conditions(self.disturbance, self.sensors)}; seed {self.seed}"

    @property
    def _run(self) -> tuple[str, str]:
        return self.model.id, self.manoeuvre.text.removesuffix(EULER)


def as_measured(record: Record, draw: Draws) -> Record:
    """A true record with the waves' motion, as the instruments show it and the sensors measure it."""
    record = draw.disturbance.motion(draw.model, record, draw.weather("waves"))
    record = observed(record, draw.model.instruments, draw.weather("instruments"))
    if play := draw.model.instruments.get("rudder_hysteresis"):
        record = record.with_channels(rudder_rad=behind_play(record.column("rudder_rad"), play))
    if late_s := draw.model.instruments.get("rudder_sensor_delay"):
        shown = np.interp(record.time_s - late_s, record.time_s, record.column("rudder_rad"))
        record = record.with_channels(rudder_rad=shown)
    return apply(record, draw.sensors, draw.noise())


def check(model: Model, disturbance: Disturbance, seed: int) -> None:
    """BadInput unless the model has coefficients, can take the disturbance, and the seed is not negative."""
    if not model.known:
        raise BadInput(f"{model.id} has no coefficients to simulate with", hint="give a vessel or a model.json")
    if seed < 0:
        raise BadInput(f"seed {seed} is negative")
    disturbance.check(model)


def sampling(model: Model, duration_s: float | None, dt_s: float | None) -> tuple[float, float]:
    """Sampling step and duration in s: given, or those of `suggested`; BadInput if neither says."""
    own = suggested(model)
    dt = own.get("dt_s") if dt_s is None else dt_s
    duration = own.get("duration_s") if duration_s is None else duration_s
    if dt is None or duration is None:
        raise BadInput(f"{model.id} has no suite values", hint="give both: --duration and --dt")
    return float(dt), float(duration)


def suggested(model: Model) -> Mapping[str, Any]:
    """What to sail with a vessel: its file's `suite`, else zigzags and turns by the time L/U; empty without both.

    Keys dt_s, duration_s, train and held_out.
    """
    length, speed = model.particulars.get("L", math.nan), model.speed_m_s
    if model.suite or not length > 0.0 or not speed > 0.0:
        return model.suite
    step = length / speed / STEPS_IN_A_LENGTH
    power = 10.0 ** math.floor(math.log10(step))
    dt = power * max(size for size in (1.0, 2.0, 5.0) if size * power <= step * (1.0 + 1e-9))
    duration = math.ceil(LENGTHS * length / speed / dt / 10.0) * 10.0 * dt
    return SUGGESTED | {"dt_s": float(f"{dt:.1g}"), "duration_s": duration}


def sail(
    model: Model,
    dt: float,
    control: ClosedLoop,
    disturbance: Disturbance,
    environment: np.ndarray,
    integrator: str,
    start_speed: float = 1.0,
) -> SimulatedRun:
    """Run the closed loop, with the wave drift at the heading that the run itself has at every sample.

    The drift force depends on the heading, which the environment array cannot. The run is repeated with the
    drift along the last run's heading until that stops changing (waveform relaxation: the error after k passes
    falls like c^k / k!, so a finite run always converges). Raises BadInput if it has not after 60 passes.
    """
    start, environment = steady_start(model, environment, start_speed), environment.copy()
    run = closed_loop(model, dt, control, environment, start, integrator)
    if not np.any(environment[:, 4:7]):
        return run
    column = model.states.index("psi")
    for _ in range(DRIFT_PASSES):
        heading = run.states[:, column]
        environment[:, 4:7] = disturbance.drift(model, heading)
        run = closed_loop(model, dt, control, environment, start, integrator)
        if not np.max(np.abs(run.states[:, column] - heading)) > DRIFT_TOLERANCE_RAD:
            return run
    raise no_convergence(model, disturbance)


def no_convergence(model: Model, disturbance: Disturbance) -> BadInput:
    """What is raised where the passes of `sail` do not settle."""
    said = f"{model.id} under {disturbance.text!r}: the wave drift force does not converge"
    return BadInput(said, hint="shorten the run")


def steady_start(model: Model, environment: np.ndarray, start_speed: float = 1.0) -> np.ndarray:
    """Initial state (n,): the model's speed through the water, on course north, carried along by the current."""
    start = start_speed * initial_state(model)
    if np.any(environment[0, 0:2]):
        start[[model.states.index(s) for s in ("u", "v")]] += environment[0, 0:2]
    return start


def require_finite(model: Model, manoeuvre: Manoeuvre, run: SimulatedRun) -> None:
    """BadInput that says when a run diverges (a state beyond a million SI units, or not finite)."""
    bad = np.flatnonzero(~(np.abs(run.states) < LARGEST_STATE).all(axis=1))
    if bad.size:
        when = f"after {run.time_s[bad[0]]:g} s"
        raise BadInput(f"{model.id} diverges in {manoeuvre.text!r} {when}", hint="shorten the run or the step")


def as_record(model: Model, manoeuvre: Manoeuvre, run: SimulatedRun, note: str) -> Record:
    """The run as a noise-free record: command, rudder, propeller where there is one, and every visible state."""
    channels = channels_of(model, run.states, run.command_rad, run.rudder_rad)
    meta = meta_of(model, manoeuvre, note)
    return Record(run.time_s, channels, name=f"{model.id} {manoeuvre.text}", meta=meta)


def meta_of(model: Model, manoeuvre: Manoeuvre, note: str) -> RecordMeta:
    """What is known about a simulated record."""
    return RecordMeta(
        vessel=model.vessel or model.id,
        source="simulated",
        positive_rudder=model.positive_rudder if is_side(model.positive_rudder) else None,
        manoeuvre=manoeuvre.text,
        notes=note,
    )


def channels_of(
    model: Model, states: np.ndarray, command_rad: np.ndarray, rudder_rad: np.ndarray
) -> dict[str, np.ndarray]:
    """Channels (..., N+1) of states (..., N+1, n), rudder command and rudder (..., N+1)."""
    channels = {"rudder_command_rad": command_rad, "rudder_rad": rudder_rad}
    if "n" in model.inputs:
        channels["propeller_rps"] = np.full(rudder_rad.shape, model.n0_rps, dtype=float)
    return channels | {CHANNELS[s]: states[..., i] for i, s in enumerate(model.states) if s in CHANNELS}


def conditions(disturbance: Disturbance, sensors: SensorSet) -> str:
    """Noise and disturbance, as the notes of a generated record tell them."""
    return f"noise {sensors.text}; disturbance {disturbance.text}"
