"""Cases: which ship, what is hidden in it, how strongly, under which gusts and sensors; `plant` makes the records."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...datasets.record import Record
from ...models.errors import BadInput
from . import equations, oracle, sensing
from .effects import CATALOGUE, Effect, Setting, carries, plan_of
from .ships import Ship, ship
from .simulator import Gusts, Run, gust_sd, rudder_force, simulate, straight, vector

#: Non-centrality of a strength: uniform in its logarithm between these; 29.3 is power .99 at level .001 (one size)
STRENGTHS = {
    "undetectable": (1.0, 3.0),
    "detectable": (30.0, 60.0),
    "faint": (60.0, 120.0),
    "medium": (400.0, 800.0),
    "gross": (4e3, 8e3),
}
#: Strengths by size: the catalogue's sizes (an offset near .1 deg, a delay near .2 s, a current near 3 cm/s) times
#: this, more if they would not be detectable
SIZED = {"small": 1.0, "moderate": 3.0, "large": 10.0}
DETECTABLE = 60.0
#: Non-centrality of a ship that runs away (a damping that feeds the turn): no ship that anyone has sailed
RUNAWAY = 1e12
DRAWS = 4
#: Correlation times of zero-mean gusts on a full-scale ship, s
GUSTS = {"none": None, "fast": (3.0, 10.0), "slow": (30.0, 60.0)}
GUST_LEVEL = np.deg2rad(0.4)
TRAIN = ("zigzag:20/20", "turn:25:port", "steps:25deg/{:g}s")
HELD_OUT = ("zigzag:10/10:port", "sine:15deg/{:g}s")


@dataclass(frozen=True)
class Case:
    """What to plant.

    Parameters
    ----------
    vessel : one of `ships.VESSELS`.
    causes : what is drawn at `strength` (none: a clean case); `effects` are planted as they are.
    strength : a key of `STRENGTHS` or `SIZED`, or a non-centrality.
    gusts : 'none', 'fast' or 'slow'; gust_level : yaw moment of a gust (sd) as a rudder angle, rad.
    train, held_out : manoeuvres (default: three and two of mixed kinds, in the ship's own time scale).
    duration_s, dt_s : of each record (default 600 s at 0.5 s, a fifth of it or so for a model).
    noise : factor on the sensors' noise; gaps : share of samples lost; channels : which are kept (default: all).
    command : the records hold the rudder's command instead of its angle.
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

    def __post_init__(self) -> None:
        for cause in [*self.causes, *(effect.cause for effect in self.effects)]:
            if cause not in CATALOGUE:
                raise BadInput(f"nothing called {cause!r} can be planted", hint=f"known are {', '.join(CATALOGUE)}")
            if not carries(self.ship, cause):
                raise BadInput(f"{self.vessel} cannot carry {cause}")
        if isinstance(self.strength, str) and self.strength not in STRENGTHS | SIZED:
            raise BadInput(f"strength {self.strength!r}", hint=f"a number or {', '.join(STRENGTHS | SIZED)}")
        if self.gusts not in GUSTS:
            raise BadInput(f"gusts {self.gusts!r}", hint="none, fast or slow")

    @property
    def ship(self) -> Ship:
        """The ship without effects."""
        return ship(self.vessel)

    def settled(self) -> Case:
        """The case with its defaults filled in."""
        clock = self.ship.clock
        times = 40.0 * clock, 120.0 * clock
        facts: dict[str, Any] = {
            "train": self.train or tuple(text.format(times[0]) for text in TRAIN),
            "held_out": self.held_out or tuple(text.format(times[1]) for text in HELD_OUT),
            "duration_s": self.duration_s or (600.0 if clock > 0.5 else 150.0),
            "dt_s": self.dt_s or (0.5 if clock > 0.5 else 0.1),
            "channels": self.channels or (sensing.CHANNELS if self.ship.is_3dof else sensing.RESPONSE_CHANNELS),
            "command": self.command
            or any(CATALOGUE[c].command for c in (*self.causes, *(e.cause for e in self.effects))),
        }
        return replace(self, **facts)


@dataclass(frozen=True, eq=False)
class Planted:
    """The records of a case and what is in them.

    truth: the effects as planted, with units; noncentrality: of the weakest of the drawn effects, each on its own on
    the training records (nan for a case without effects that have a size).
    """

    case: Case
    train: list[Record]
    held_out: list[Record]
    effects: tuple[Effect, ...]
    gusts: Gusts | None
    noncentrality: float

    @property
    def truth(self) -> list[dict[str, Any]]:
        """[{cause, parameters, units}], per-record values as lists (training records first)."""
        return [
            {"cause": e.cause, "parameters": dict(e.parameters), "units": CATALOGUE[e.cause].units}
            for e in self.effects
        ]


def plant(case: Case, rng: np.random.Generator) -> Planted:
    """Draw the effects of a case, scale each to the strength, and make the records."""
    case = case.settled()
    gusts = draw_gusts(case, rng)
    frames = Frames.draw(case, rng)
    drawn = [draw_effect(case, cause, frames, gusts, rng) for cause in case.causes]
    found = (*case.effects, *(effect for effect, _ in drawn))
    power = min((power for _, power in drawn if not np.isnan(power)), default=float("nan"))
    runs = [frames.run(case, found, i, gusts) for i in range(frames.count)]
    records = [frames.record(case, found, i, run, rng) for i, run in enumerate(runs)]
    n = len(case.train)
    return Planted(case, records[:n], records[n:], found, gusts, power)


def draw_gusts(case: Case, rng: np.random.Generator) -> Gusts | None:
    """Correlation time and frame of a case's gusts."""
    span = GUSTS[case.gusts]
    if span is None:
        return None
    time = float(np.exp(rng.uniform(*np.log(span)))) * case.ship.clock
    return Gusts(case.gust_level, time, bool(rng.random() < 0.5))


@dataclass(frozen=True, eq=False)
class Frames:
    """What the records of a case have in common whatever is planted: manoeuvres, first headings, random streams."""

    manoeuvres: tuple[str, ...]
    headings: np.ndarray
    seeds: np.ndarray

    @property
    def count(self) -> int:
        """Number of records."""
        return len(self.manoeuvres)

    @classmethod
    def draw(cls, case: Case, rng: np.random.Generator) -> Frames:
        """First headings all round the compass, one seed per record."""
        texts = (*case.train, *case.held_out)
        return cls(texts, rng.uniform(-np.pi, np.pi, len(texts)), rng.integers(0, 2**63, len(texts)))

    def run(self, case: Case, effects: Sequence[Effect], i: int, gusts: Gusts | None) -> Run:
        """The dense run of record i."""
        plan = plan_of(case.ship, tuple(effects), i)
        rng = np.random.default_rng(self.seeds[i])
        helmsman = case.noise * sensing.NOISE["heading_rad"]
        return simulate(plan, self.manoeuvres[i], case.duration_s or 0.0, rng, self.headings[i], gusts, helmsman)

    def record(
        self, case: Case, effects: Sequence[Effect], i: int, run: Run, rng: np.random.Generator, noise: bool = True
    ) -> Record:
        """The record of run i; without noise also without gaps and with the heading unwrapped."""
        sd = sensing.noise_sd(case.ship, case.noise if noise else 0.0)
        role = "train" if i < len(case.train) else "held_out"
        return sensing.observe(
            run, plan_of(case.ship, tuple(effects), i), case.dt_s or 0.0, rng, sd, case.channels,
            gaps=case.gaps if noise else 0.0, command=case.command, name=f"{role}-{i + 1}",
            manoeuvre=self.manoeuvres[i], wrap=case.wrap and noise,
        )  # fmt: skip


def draw_effect(
    case: Case, cause: str, frames: Frames, gusts: Gusts | None, rng: np.random.Generator
) -> tuple[Effect, float]:
    """An effect of the case's strength, and its non-centrality on the training records.

    Drawn again, up to `DRAWS` times, when what was drawn cannot be made that strong.
    """
    best: tuple[Effect, float] | None = None
    for _ in range(DRAWS):
        found = _draw_once(case, cause, frames, gusts, rng)
        if not found[2]:
            return found[:2]
        best = best or found[:2]
    assert best is not None
    return best


def _draw_once(case: Case, cause: str, frames: Frames, gusts: Gusts | None, rng: np.random.Generator):
    """Effect, non-centrality, and whether that fell short of the strength."""
    setting = Setting(
        case.ship, case.duration_s or 0.0, len(case.train), len(case.held_out), lambda: passed(case, frames, rng)
    )
    facts = CATALOGUE[cause]
    shape = Effect(cause, facts.draw(setting, rng))
    if not facts.sized:
        return shape, float("nan"), False
    if case.strength in SIZED:
        effect = shape.scaled(SIZED[case.strength])
        power = noncentrality(case, (effect,), frames, gusts)
        if DETECTABLE <= power < RUNAWAY:
            return effect, power, False
        span = (DETECTABLE, 2.0 * DETECTABLE)
    else:
        span = STRENGTHS[case.strength] if isinstance(case.strength, str) else (case.strength,) * 2
    target = float(np.exp(rng.uniform(*np.log(span))))
    effect, power = scaled_to(case, shape, target, frames, gusts)
    return effect, power, not 0.5 < power / target < 2.0


def passed(case: Case, frames: Frames, rng: np.random.Generator) -> tuple[float, float]:
    """Where (north, east, in ship lengths) a training record is at some time between .2 and .7 of it."""
    run = frames.run(case, (), int(rng.integers(len(case.train))), None)
    north, east = run.states[int(rng.uniform(0.2, 0.7) * len(run.states)), 3:5] / case.ship.length_m
    return float(north), float(east)


def scaled_to(
    case: Case, shape: Effect, target: float, frames: Frames, gusts: Gusts | None, tolerance: float = 0.15
) -> tuple[Effect, float]:
    """The effect scaled until its non-centrality is `target` to within the tolerance, or its cap is reached."""
    low, high, factor, slope = 0.0, np.inf, 1.0, 2.0
    power = noncentrality(case, (shape,), frames, gusts)
    effect = shape
    for _ in range(24):
        miss = np.log(target / np.clip(power, 1e-12, RUNAWAY))
        if abs(miss) < tolerance:
            break
        low, high = (factor, high) if miss > 0.0 else (low, factor)
        last, guess = factor, factor * float(np.exp(np.clip(miss / slope, -2.3, 2.3)))
        if not low < guess < high:  # a step that leaves the bracket: halve it (in logarithms)
            guess = float(np.sqrt(max(low, 0.01 * high) * high))
        before, effect = effect, shape.scaled(guess)
        if effect == before or high - low < 1e-5 * low:
            break
        factor, was = guess, power
        power = noncentrality(case, (effect,), frames, gusts)
        rise = np.log(np.clip(power, 1e-12, RUNAWAY) / np.clip(was, 1e-12, RUNAWAY)) / np.log(factor / last)
        slope = float(np.clip(rise, 0.7, 8.0))
    return effect, power


def noncentrality(case: Case, effects: tuple[Effect, ...], frames: Frames, gusts: Gusts | None) -> float:
    """Of the best test of the effects on the training records, noise variances and the ship known.

    Noise-free records under the effects go through the filter of the ship without them (`oracle`); effects that
    only add variance are rated by the gain of a test of variances.
    """
    total = 0.0
    random = all(CATALOGUE[effect.cause].random for effect in effects)
    for i in range(len(case.train)):
        run = frames.run(case, effects, i, None)
        if any(effect.cause == "outliers" for effect in effects):
            return sum(effect.at(i)["share"] for effect in effects if effect.cause == "outliers") * 12e4
        record = frames.record(case, effects, i, run, np.random.default_rng(frames.seeds[i]), noise=False)
        z = whitened(case, record, run, gusts)
        if not np.isfinite(z).any():
            return np.inf
        with np.errstate(over="ignore"):  # a ship that runs away
            total += oracle.variance_gain(z) if random else float(np.nansum(z**2))
    return total if np.isfinite(total) else np.inf


def whitened(case: Case, record: Record, run: Run, gusts: Gusts | None) -> np.ndarray:
    """Whitened innovations (N, k) of a noise-free record against the case's ship without effects."""
    base, dt = case.ship, case.dt_s or 0.0
    names = [name for name in sensing.STATE if name in record.channels]
    y = np.column_stack([record.column(name) for name in names])
    sd = sensing.noise_sd(base, case.noise)
    x0 = straight(base, float(run.states[0, 5]))
    steps = max(1, round(dt / run.step_s))
    spread = next(k for k in (5, 4, 3, 2, 1) if steps % k == 0)
    start = 30.0 * np.array(
        [sd["surge_m_s"], sd["sway_m_s"], sd["yaw_rate_rad_s"], sd["north_m"], sd["east_m"], sd["heading_rad"]]
    )
    if not base.is_3dof:
        start[[0, 3, 4]] = 1e-9
        start[1] = 1e-4
    z = np.full(y.shape, np.nan)
    scales = np.array(gust_sd(base, gusts) if gusts else (0.0, 0.0, 0.0))
    oracle.innovations(
        base.kind, base.coefficients, equations.ship_vector(base, *rudder_force(base)), vector({}),
        run.step_s * spread, steps // spread, spread, 2 * steps, x0[:6], start, y,
        np.array([sensing.STATE[name] for name in names]), np.array([sd[name] for name in names]),
        rudder_seen(case, record, run), sd["rudder_rad"], scales, gusts.correlation_s if gusts else 1.0, z,
    )  # fmt: skip
    return z


def rudder_seen(case: Case, record: Record, run: Run) -> np.ndarray:
    """The recorded rudder angle between the samples too, with the sign that the record gives it."""
    column = "rudder_command_rad" if case.command else "rudder_rad"
    flipped = float(
        np.dot(record.column(column), run.rudder[:: 2 * round((case.dt_s or 0.0) / run.step_s)][: record.n])
    )
    return -run.rudder if flipped < 0.0 else run.rudder
