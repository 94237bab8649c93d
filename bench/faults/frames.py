"""What the records of a case have in common, and the run and record of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...datasets.record import Record
from . import sensing
from .case import FaultCase
from .effects import Effect
from .effects.forces import ForceKind
from .effects.sensors import SensorKind
from .foreign import foreign_forces
from .ships import TrueShip
from .simulator import DenseRun, Gusts, RunPlan, simulate


def plan_of(ship: TrueShip, effects: Sequence[Effect], record: int) -> RunPlan:
    """What the effects do in one record."""
    dynamic: dict[str, float] = {}
    chain: dict[str, float] = {}
    extra, sensors, wave = [], [], None
    for effect in effects:
        kind, p = effect.kind, effect.at(record)
        ship = kind.changed_ship(ship, p)
        chain |= kind.rudder(p)
        dynamic |= kind.forces(p)
        wave = kind.wave(p) or wave
        if isinstance(kind, ForceKind):
            extra.append((kind.force, kind.vector(p)))
        if isinstance(kind, SensorKind):
            sensors.append((kind, p))
    return RunPlan(ship, dynamic, chain, tuple(extra), wave, tuple(sensors))


@dataclass(frozen=True, eq=False)
class Frames:
    """What the records of a case share, with and without effects: manoeuvres, first headings, random streams."""

    manoeuvres: tuple[str, ...]
    headings: np.ndarray
    seeds: np.ndarray

    @property
    def count(self) -> int:
        """Number of records."""
        return len(self.manoeuvres)

    @classmethod
    def draw(cls, case: FaultCase, rng: np.random.Generator) -> Frames:
        """First headings all round the compass, one seed per record."""
        texts = (*case.train, *case.held_out)
        return cls(texts, rng.uniform(-np.pi, np.pi, len(texts)), rng.integers(0, 2**63, len(texts)))

    def run(
        self, case: FaultCase, effects: Sequence[Effect], i: int, gusts: Gusts | None, rudder: np.ndarray | None = None
    ) -> DenseRun:
        """The dense run of record i; rudder : angles (2n + 1,) that are taken instead of the manoeuvre's, rad."""
        planted = None
        if case.foreign:
            donor = (i + 1) % self.count
            other = self.run(replace(case, foreign=False), effects, donor, None)
            planted, effects = foreign_forces(plan_of(case.ship, effects, donor), case.ship, other), ()
        plan = plan_of(case.ship, effects, i)
        rng = np.random.default_rng(self.seeds[i])
        helmsman = case.noise * sensing.NOISE["heading_rad"]
        manoeuvre, duration = self.manoeuvres[i], case.duration_s or 0.0
        return simulate(
            plan, manoeuvre, duration, rng, self.headings[i], gusts, helmsman, prescribed=rudder, planted=planted
        )

    def record(
        self,
        case: FaultCase,
        effects: Sequence[Effect],
        i: int,
        run: DenseRun,
        rng: np.random.Generator,
        noise: bool = True,
    ) -> Record:
        """The record of run i; without noise also without gaps and with the heading unwrapped."""
        sd = sensing.noise_sd(case.ship, case.noise if noise else 0.0)
        effects = () if case.foreign else effects
        role = "train" if i < len(case.train) else "held_out"
        return sensing.observe(
            run, plan_of(case.ship, effects, i), case.dt_s or 0.0, rng, sd, case.channels,
            gaps=case.gaps if noise else 0.0, command=case.command, name=f"{role}-{i + 1}",
            manoeuvre=self.manoeuvres[i], wrap=case.wrap and noise,
            noise_time_s=case.noise_time_s * case.ship.clock,
        )  # fmt: skip
