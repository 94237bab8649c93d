"""What the records of a case have in common, and the run and record of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...datasets.record import Record, RecordMeta
from . import equations, integrate, sensing
from .case import GUSTS, FaultCase
from .effects.base import Effect, Stage
from .effects.forces import force_vector
from .ships import SECOND, TrueShip
from .simulator import DenseRun, Gusts, RunPlan, first_class_functions, further_forces, rudder_force, simulate

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
    return RunPlan(ship, equations.Terms(**terms), integrate.Chain(**chain), tuple(extra), wave, tuple(sensors))


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
