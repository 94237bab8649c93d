"""Cases (ship, effects, gusts, sensors), what the records of one have in common, and the run and record of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...datasets.record import Record, RecordMeta
from ...models.errors import BadInput
from . import equations, integrate, sensing
from .effects.base import Effect, EffectKind, Stage, kind_of
from .effects.forces import force_vector
from .ships import SECOND, TrueShip, ship
from .simulator import DenseRun, Gusts, RunPlan, first_class_functions, further_forces, rudder_force, simulate

#: Correlation times of zero-mean gusts on a full-scale ship, s
GUSTS = {"none": None, "fast": (3.0, 10.0), "slow": (30.0, 60.0)}
GUST_LEVEL = np.deg2rad(0.4)
#: Non-centrality of a strength: drawn uniformly in its logarithm; 29.3 is power .99 at level .001 (one size)
STRENGTHS = {
    "undetectable": (1.0, 3.0),
    "detectable": (30.0, 60.0),
    "faint": (60.0, 120.0),
    "medium": (400.0, 800.0),
    "gross": (4e3, 8e3),
}
#: Strengths by size: factors on the size that a kind draws (an offset near .1 deg, a delay near .2 s, a current near
#: 3 cm/s), increased where that would not be detectable
SIZED = {"small": 1.0, "moderate": 3.0, "large": 10.0, "largest": 60.0}
TRAIN = ("zigzag:20/20", "turn:25:port", "steps:25deg/{:g}s")
HELD_OUT = ("zigzag:10/10:port", "sine:15deg/{:g}s")


@dataclass(frozen=True)
class FaultCase:
    """What to inject.

    Parameters
    ----------
    vessel : one of `ships.VESSELS`.
    causes : kinds of effects, drawn at `strength` (none: a clean case); `effects` are injected as they are.
    strength : a key of `STRENGTHS` or `SIZED`, or a non-centrality.
    gusts : 'none', 'fast' or 'slow'; gust_level : yaw moment of a gust (sd) as a rudder angle, rad.
    train, held_out : manoeuvres (default: three and two of mixed kinds); `{:g}` stands for 40 and 120 s, in the ship's
        own time scale.
    duration_s, dt_s : of each record (default 600 s at 0.5 s, a fifth of it or so for a model).
    noise : factor on the sensors' noise; gaps : share of samples lost; channels : which are kept (default: all).
    command : the records hold the rudder's command instead of its angle.
    noise_time_s : correlation time of the sensors' noise, s of a 160 m ship (0: white).
    spread : relative standard deviation of an effect's size between records.
    factors : (name, factor) of numbers in which the ship differs from the published one (`ships.sister_numbers`).
    beside : relative standard deviation of the ship's own numbers beside which the effects have to be told, from
        innovations that are correlated as errors of free runs are (`injected.own_numbers`); 0: all is known.
    foreign : the effects' forces are those of another record, so that no cause of the motion explains them
        (`frames.foreign_forces`).
    """

    vessel: str = "mariner"
    causes: tuple[str, ...] = ()
    strength: str | float = "medium"
    effects: tuple[Effect, ...] = ()
    gusts: str = "none"
    gust_level: float = GUST_LEVEL
    train: tuple[str, ...] = ()
    held_out: tuple[str, ...] = ()
    duration_s: float | None = None
    dt_s: float | None = None
    noise: float = 1.0
    gaps: float = 0.0
    channels: tuple[str, ...] = ()
    command: bool = False
    wrap: bool = True
    noise_time_s: float = 0.0
    spread: float = 0.0
    beside: float = 0.0
    foreign: bool = False
    factors: tuple[tuple[str, float], ...] = ()

    def __post_init__(self) -> None:
        for kind in self.kinds:
            if not kind.carried_by(self.ship):
                raise BadInput(f"{self.vessel} cannot carry {kind.id}")
        if isinstance(self.strength, str) and self.strength not in STRENGTHS | SIZED:
            raise BadInput(f"strength {self.strength!r}", hint=f"a number or {', '.join(STRENGTHS | SIZED)}")
        if self.foreign and (self.gusts != "none" or any(kind.on_sensor for kind in self.kinds)):
            raise BadInput("planted nulls are forces, in calm", hint="no effects of sensors, gusts 'none'")
        if self.gusts not in GUSTS:
            raise BadInput(f"gusts {self.gusts!r}", hint="none, fast or slow")

    @property
    def kinds(self) -> list[EffectKind]:
        """Kinds of the effects."""
        return [*map(kind_of, self.causes), *(effect.kind for effect in self.effects)]

    @property
    def ship(self) -> TrueShip:
        """The ship without effects."""
        return ship(self.vessel, self.factors)

    def completed(self) -> FaultCase:
        """The case with its defaults filled in."""
        clock = self.ship.clock
        times = 40.0 * clock, 120.0 * clock
        facts: dict[str, Any] = {
            "train": tuple(text.format(times[0]) for text in self.train or TRAIN),
            "held_out": tuple(text.format(times[1]) for text in self.held_out or HELD_OUT),
            "duration_s": self.duration_s or (600.0 if clock > 0.5 else 150.0),
            "dt_s": self.dt_s or (0.5 if clock > 0.5 else 0.1),
            "channels": self.channels or (sensing.CHANNELS if self.ship.is_3dof else sensing.RESPONSE_CHANNELS),
            "command": self.command or any(kind.command for kind in self.kinds),
        }
        return replace(self, **facts)


EVERY = 10
"""Steps of the simulation between two forces that are computed; linear between them."""


def plan_of(ship: TrueShip, effects: Sequence[Effect], record: int) -> RunPlan:
    """What the effects do in one record."""
    terms: dict[str, float] = {}
    chain: dict[str, float] = {}
    extra, sensors, wave = [], [], None
    for effect in effects:
        kind, p = effect.kind, effect.at(record)
        ship = kind.changed_ship(ship, p)
        chain |= {name: float(value) for name, value in kind.rudder(p).items()}
        terms |= {name: float(value) for name, value in kind.forces(p).items()}
        wave = kind.wave(p) or wave
        if kind.force is not None:
            extra.append((kind.force, force_vector(p)))
        if kind.on_sensor:
            sensors.append((kind, p))
    return RunPlan(
        ship, equations.NO_TERMS._replace(**terms), integrate.Chain(**chain), tuple(extra), wave, tuple(sensors)
    )


@dataclass(frozen=True, eq=False)
class Frames:
    """A case with its defaults, and what its records share with and without effects: gusts, first headings, random
    streams."""

    case: FaultCase
    gusts: Gusts | None
    headings: np.ndarray
    seeds: np.ndarray

    @property
    def manoeuvres(self) -> tuple[str, ...]:
        """One a record."""
        return (*self.case.train, *self.case.held_out)

    @property
    def count(self) -> int:
        """Number of records."""
        return len(self.manoeuvres)

    @classmethod
    def draw(cls, case: FaultCase, rng: np.random.Generator) -> Frames:
        """Correlation time and axes of the gusts, first headings all round the compass, one seed per record."""
        case, gusts = case.completed(), None
        if (span := GUSTS[case.gusts]) is not None:
            time = float(np.exp(rng.uniform(*np.log(span)))) * case.ship.clock
            gusts = Gusts(case.gust_level, time, bool(rng.random() < 0.5))
        count = len(case.train) + len(case.held_out)
        return cls(case, gusts, rng.uniform(-np.pi, np.pi, count), rng.integers(0, 2**63, count))

    def changed(self, **facts: Any) -> Frames:
        """The same gusts, headings and streams with other facts of the case."""
        return replace(self, case=replace(self.case, **facts))

    def run(self, effects: Sequence[Effect], i: int, rudder: np.ndarray | None = None, calm: bool = False) -> DenseRun:
        """The dense run of record i; rudder : angles (2n + 1,) that are taken instead of the manoeuvre's, rad; calm :
        without gusts."""
        case, planted = self.case, None
        if case.foreign:
            donor = (i + 1) % self.count
            other = self.changed(foreign=False).run(effects, donor, calm=True)
            planted, effects = foreign_forces(plan_of(case.ship, effects, donor), case.ship, other), ()
        plan = plan_of(case.ship, effects, i)
        rng = np.random.default_rng(self.seeds[i])
        helmsman = case.noise * sensing.NOISE["heading_rad"]
        gusts, duration = None if calm else self.gusts, case.duration_s or 0.0
        return simulate(
            plan, self.manoeuvres[i], duration, rng, self.headings[i], gusts, helmsman, prescribed=rudder,
            planted=planted,
        )  # fmt: skip

    def record(
        self, effects: Sequence[Effect], i: int, run: DenseRun, rng: np.random.Generator, noise: bool = True
    ) -> Record:
        """The record of run i; without noise also without gaps and with the heading unwrapped.

        recorded = (1 + scale) true(t - delay) + bias + noise; in which order effects act: `effects.base.Stage`.
        """
        case, ship = self.case, self.case.ship
        plan = plan_of(ship, () if case.foreign else effects, i)
        sensors, dt = sorted(plan.sensors, key=lambda item: item[0].stage), case.dt_s or 0.0
        sd, memory = sensing.noise_sd(ship, case.noise if noise else 0.0), case.noise_time_s * ship.clock
        time = dt * np.arange(round((len(run.states) - 1) * run.step_s / dt) + 1)
        jitter = sum(kind.jitter_s(p) for kind, p in sensors)
        taken = np.clip(time + jitter * rng.standard_normal(time.size), 0.0, time[-1])
        rows = {
            c: sensing.sampled(run, c, taken - sum(kind.delay_s(c, p) for kind, p in sensors)) for c in sensing.CHANNELS
        }
        before = [kind.stage <= Stage.OFFSET for kind, _ in sensors].count(True)
        for kind, p in sensors[:before]:
            kind.apply(rows, time, p, sd, rng)
        for channel in rows:
            rows[channel] = rows[channel] + sd.get(channel, 0.0) * sensing.coloured(rng, time.size, dt, memory)
        for kind, p in sensors[before:]:
            kind.apply(rows, time, p, sd, rng)
        if case.wrap and noise:
            rows["heading_rad"] = np.mod(rows["heading_rad"], 2.0 * np.pi)
        for channel in sensing.CHANNELS[1:]:
            rows[channel] = sensing.with_gaps(rows[channel], case.gaps if noise else 0.0, rng)
        kept = {"rudder_command_rad" if case.command else "rudder_rad": rows["rudder_rad"]}
        kept |= {c: rows[c] for c in sensing.CHANNELS[1:] if c in case.channels}
        side, source = "port" if ship.starboard < 0 else "starboard", "truth simulator"
        meta = RecordMeta(vessel=ship.id, positive_rudder=side, manoeuvre=self.manoeuvres[i], source=source)
        return Record(time, kept, f"{'train' if i < len(case.train) else 'held_out'}-{i + 1}", meta)


def foreign_forces(plan: RunPlan, sound: TrueShip, run: DenseRun) -> np.ndarray:
    """Forces X, Y, N (n + 1, 3) that the effects of a plan add along a run, backwards in time and without their mean.

    Planted in another record they are nulls that no cause of its motion explains: knock-offs in the sense of Barber &
    Candes 2015 (Ann. Stat. 43, 2055), with the size, spectrum and shape of the true effect but without its relation to
    the record's own rudder and motion.  What a diagnosis names of them is a false discovery.  A mean would be a
    constant force, which a diagnosis may name.
    """
    steps = np.arange(len(run.states))
    at = np.append(steps[:-1:EVERY], steps[-1])
    ill, well = (
        np.array([forces(one, run, int(k), rudder) for k in at])
        for one, rudder in ((plan, run.hull), (RunPlan(sound), run.rudder))
    )
    added = ill - well
    series = np.column_stack([np.interp(steps, at, column) for column in added.T])
    return (series - series.mean(axis=0))[::-1]


def forces(plan: RunPlan, run: DenseRun, step: int, rudder: np.ndarray) -> np.ndarray:
    """X, Y, N (3,) that give the accelerations of a plan's ship at a step of a run; of a response ship the yaw one."""
    ship, out = plan.ship, np.zeros(8)
    args = equations.ship_numbers(ship, *rudder_force(ship)), plan.terms, *further_forces(plan.extra)
    state, angle = run.states[step], float(rudder[2 * step])
    with first_class_functions():
        equations.derivative(
            ship.kind, ship.coefficients, *args, step * run.step_s, state, angle, 0.0, 0.0, 0.0, np.zeros(5), out
        )
    if ship.is_3dof:
        return ship.mass @ out[:3]
    return np.array([0.0, 0.0, out[1 if ship.kind == SECOND else 2]])
