"""Effects in records: `inject` makes the records of a case.

How strong an effect is: the non-centrality of the best possible test; it is drawn in the size that has a wanted one.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...datasets.record import Record
from . import equations, oracle, sensing
from .effects.base import Effect, Setting, kind_of
from .frames import SIZED, STRENGTHS, FaultCase, Frames
from .ships import sister_numbers
from .simulator import DenseRun, first_class_functions, further_forces, gust_sd, rudder_force, straight

DETECTABLE = 60.0
#: Non-centrality of a ship that is unstable (a damping that feeds the turn): no real ship
RUNAWAY = 1e8
DRAWS, TOLERANCE = 4, 0.15
CORRELATION = 1.7
"""Ship lengths sailed over which errors of a model that is not exact are correlated, as those of its free runs are."""
STEP = 0.2
"""Step of the differences by the ship's own numbers, in their standard deviations."""


def draw_effect(frames: Frames, cause: str, rng: np.random.Generator) -> tuple[Effect, float]:
    """An effect of the case's strength, and its non-centrality on the training records.

    Drawn again, up to `DRAWS` times, when what was drawn cannot be made that strong.
    """
    best: tuple[Effect, float] | None = None
    own = own_numbers(frames) if frames.case.beside else None
    for _ in range(DRAWS):
        found = _draw_once(frames, cause, rng, own)
        if not found[2]:
            return found[:2]
        best = best or found[:2]
    assert best is not None
    return best


def _draw_once(frames: Frames, cause: str, rng: np.random.Generator, own: np.ndarray | None):
    """Effect, non-centrality, and whether that fell short of the strength."""
    case, kind = frames.case, kind_of(cause)
    sizes = case.duration_s or 0.0, len(case.train), len(case.held_out)
    shape = Effect(cause, kind.draw(Setting(case.ship, *sizes, lambda: place_on_track(frames, rng)), rng))
    if not kind.sized:
        return shape, float("nan"), False
    if isinstance(case.strength, str) and case.strength in SIZED:
        effect = shape.scaled(SIZED[case.strength])
        power = noncentrality(frames, (effect,), own)
        if DETECTABLE <= power < RUNAWAY:
            return effect, power, False
        span = (DETECTABLE, 2.0 * DETECTABLE)
    else:
        span = STRENGTHS[case.strength] if isinstance(case.strength, str) else (case.strength,) * 2
    target = float(np.exp(rng.uniform(*np.log(span))))
    effect, power = scaled_to(frames, shape, target, own)
    return effect, power, not 0.5 < power / target < 2.0


def place_on_track(frames: Frames, rng: np.random.Generator) -> tuple[float, float]:
    """Where (north, east, in ship lengths) the ship is at a random time between .2 and .7 of a training record."""
    run = frames.run((), int(rng.integers(len(frames.case.train))), calm=True)
    north, east = run.states[int(rng.uniform(0.2, 0.7) * len(run.states)), 3:5] / frames.case.ship.length_m
    return float(north), float(east)


def scaled_to(frames: Frames, shape: Effect, target: float, own: np.ndarray | None) -> tuple[Effect, float]:
    """The effect scaled until its non-centrality is `target` to within `TOLERANCE`, or its cap is reached."""
    low, high, factor, slope = 0.0, np.inf, 1.0, 2.0
    power = noncentrality(frames, (shape,), own)
    effect = shape
    for _ in range(24):
        miss = np.log(target / np.clip(power, 1e-12, RUNAWAY))
        if abs(miss) < TOLERANCE:
            break
        low, high = (factor, high) if miss > 0.0 else (low, factor)
        last, guess = factor, factor * float(np.exp(np.clip(miss / slope, -2.3, 2.3)))
        if not low < guess < high:  # a step that leaves the bracket: halve it (in logarithms)
            guess = float(np.sqrt(max(low, 0.01 * high) * high))
        before, effect = effect, shape.scaled(guess)
        if effect == before or high - low < 1e-5 * low:
            break
        factor, was = guess, power
        power = noncentrality(frames, (effect,), own)
        rise = np.log(np.clip(power, 1e-12, RUNAWAY) / np.clip(was, 1e-12, RUNAWAY)) / np.log(factor / last)
        slope = float(np.clip(rise, 0.7, 8.0))
    return effect, power


def noncentrality(frames: Frames, effects: tuple[Effect, ...], own: np.ndarray | None = None) -> float:
    """Of the best test of the effects on the training records, noise variances known, and the ship too or its numbers
    under their priors (own : see `own_numbers`).

    Noise-free records under the effects go through the filter of the ship without them (`oracle`); effects that
    only add variance are rated by the gain of a test of variances.
    """
    stated = [value for effect in effects if (value := effect.kind.noncentrality(effect.at(0))) is not None]
    if stated:
        return sum(stated)
    each = [one for one, _ in _innovations(frames, effects)]
    if not all(np.isfinite(z).any() for z in each):
        return np.inf
    with np.errstate(over="ignore", invalid="ignore"):  # an unstable ship
        if all(effect.kind.variance_only for effect in effects):
            total = sum(map(oracle.variance_gain, each))
        else:
            total = sum(float(np.nansum(z**2)) for z in each) if own is None else _beside(each, frames.case, own)
    return total if np.isfinite(total) else np.inf


def own_numbers(frames: Frames) -> np.ndarray:
    """What the ship's own numbers do to the whitened innovations of the training records: a column (N, m) for each,
    for a change by its standard deviation `case.beside`, under the rudder angles of the ship as it is."""
    case, plain = frames.case, list(_innovations(frames, ()))
    zero = np.concatenate([z.ravel() for z, _ in plain])
    columns = []
    for name in sister_numbers(case.vessel):
        other = frames.changed(factors=(*case.factors, (name, 1.0 + STEP * case.beside)))
        moved = [whitened(frames, *_recorded(other, (), i, run.rudder)) for i, (_, run) in enumerate(plain)]
        columns.append(np.nan_to_num(np.concatenate([z.ravel() for z in moved]) - zero) / STEP)
    return np.array(columns).T


def _beside(each: Sequence[np.ndarray], case: FaultCase, own: np.ndarray) -> float:
    """Non-centrality of whitened innovations of records beside the ship's own numbers (N, m), which explain what
    they can of them; so many samples as are correlated count as one."""
    z = np.nan_to_num(np.concatenate([one.ravel() for one in each]))
    alike = max(1.0, CORRELATION * case.ship.length_m / case.ship.speed_m_s / (case.dt_s or 1.0))
    projected, information = own.T @ z, alike * np.eye(own.shape[1]) + own.T @ own
    return float(z @ z - projected @ np.linalg.solve(information, projected)) / alike


def _innovations(frames: Frames, effects: tuple[Effect, ...]) -> Iterator[tuple[np.ndarray, DenseRun]]:
    """Whitened innovations and run of each training record under the effects, without noise and gusts."""
    for i in range(len(frames.case.train)):
        record, run = _recorded(frames, effects, i)
        yield whitened(frames, record, run), run


def _recorded(
    frames: Frames, effects: tuple[Effect, ...], i: int, rudder: np.ndarray | None = None
) -> tuple[Record, DenseRun]:
    run = frames.run(effects, i, rudder, calm=True)
    return frames.record(effects, i, run, np.random.default_rng(frames.seeds[i]), noise=False), run


def whitened(frames: Frames, record: Record, run: DenseRun) -> np.ndarray:
    """Whitened innovations (N, k) of a noise-free record against the case's ship without effects."""
    case, gusts = frames.case, frames.gusts
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
    with first_class_functions():
        oracle.innovations(
            base.kind, base.coefficients, equations.ship_numbers(base, *rudder_force(base)), equations.NO_TERMS,
            *further_forces(()), run.step_s * spread, steps // spread, spread, 2 * steps, x0[:6], start, y,
            np.array([sensing.STATE[name] for name in names]), np.array([sd[name] for name in names]),
            rudder_seen(case, record, run), sd["rudder_rad"], scales, gusts.correlation_s if gusts else 1.0, z,
        )  # fmt: skip
    return z


def rudder_seen(case: FaultCase, record: Record, run: DenseRun) -> np.ndarray:
    """The recorded rudder angle between the samples too, with the sign that the record gives it."""
    column = "rudder_command_rad" if case.command else "rudder_rad"
    flipped = float(
        np.dot(record.column(column), run.rudder[:: 2 * round((case.dt_s or 0.0) / run.step_s)][: record.n])
    )
    return -run.rudder if flipped < 0.0 else run.rudder


@dataclass(frozen=True, eq=False)
class Injected:
    """The records of a case and what is in them.

    noncentrality: of the weakest of the drawn effects, each on its own on the training records (nan for a case
    without effects that have a size).  frames: the case, and what its records share.
    """

    frames: Frames
    train: list[Record]
    held_out: list[Record]
    effects: tuple[Effect, ...]
    noncentrality: float

    @property
    def case(self) -> FaultCase:
        """The case with its defaults filled in."""
        return self.frames.case

    @property
    def truth(self) -> list[dict[str, Any]]:
        """[{cause, parameters, units}], per-record values as lists (training records first)."""
        return [{"cause": e.cause, "parameters": dict(e.parameters), "units": dict(e.kind.units)} for e in self.effects]

    def held_out_without_gusts(self) -> list[Record]:
        """What the ship with its effects does in the held-out records under the same rudder without gusts, recorded
        without noise and gaps: the best that a model of the ship could predict."""
        out = []
        for i in range(len(self.train), self.frames.count):
            run = self.frames.run(self.effects, i)
            if self.frames.gusts is not None:
                run = self.frames.run(self.effects, i, run.rudder, calm=True)
            out.append(self.frames.record(self.effects, i, run, np.random.default_rng(0), noise=False))
        return out

    def true_motion(self) -> list[Record]:
        """The motion of the training records as it was, in all channels without errors of the sensors."""
        frames, rng = self.frames.changed(channels=sensing.CHANNELS), np.random.default_rng(0)
        runs = [frames.run(self.effects, i) for i in range(len(self.train))]
        return [frames.record((), i, run, rng, noise=False) for i, run in enumerate(runs)]


def inject(case: FaultCase, rng: np.random.Generator) -> Injected:
    """Draw the effects of a case, scale each to the strength, and make the records."""
    frames = Frames.draw(case, rng)
    drawn = [draw_effect(frames.changed(foreign=False), cause, rng) for cause in case.causes]
    found = (*case.effects, *(effect.spread(case.spread, frames.count, rng) for effect, _ in drawn))
    power = min((power for _, power in drawn if not np.isnan(power)), default=float("nan"))
    runs = [frames.run(found, i) for i in range(frames.count)]
    records = [frames.record(found, i, run, rng) for i, run in enumerate(runs)]
    n = len(frames.case.train)
    return Injected(frames, records[:n], records[n:], found, power)
