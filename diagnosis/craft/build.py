"""From records of a craft to a model: the ladder, its guards, the model in the fewest terms, and what can be said."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...datasets.columns import RUDDERS
from ...estimation.records.naming import named
from ...estimation.results.fit import arithmetic_guard, blas_limited
from ...estimation.validation.horizons import STRAIGHT, TRUSTED, mean_ratio
from ...estimation.validation.validate import label, validate
from ...models.errors import BadInput
from ...models.instruments import INSTRUMENTS, combined
from ..calibration.calibrate import corrected_particulars
from ..causes.base import NORMAL_90
from ..gain.guard import WORSE
from .ladder import Attempt, Climb, Ladder, climb, steering
from .own_speed import numbers_of, with_own_speed
from .records import FED_BACK, copied_input, feedback_share, measured_by_all, outside, weak_motion, without_spikes
from .result import (
    BUILT,
    FIRST,
    OUTSIDE,
    OWN_SPEED,
    PARTLY,
    SHIP,
    UNEXPLAINED,
    CraftDiagnosis,
    LawTold,
    NumberTold,
    Rise,
    by_thrust,
)
from .rungs import SPEED, TURNS
from .sensors import Sensors, behind_sensors
from .verdict import GOOD, NEAR, heading_band, r2, verdict_of
from .windows import LAG, mean_of_known, pieces_of, scales_of

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...estimation.validation.result import Validation
    from ...models.model import Model
    from .windows import Piece

SLACK = 0.05
"""Rise of the errors of left-out records that a step may bring and still stand; fall below those of a craft that goes
straight, from which the yaw rate is predicted."""
RATE = "yaw_rate_rad_s"
LOST = 0.1
"""R2 of the yaw rate that a surge of its own may lose: where nothing was recorded of the thrust, it is far more."""


CLIMBING, LEFT_OUT, AHEAD = (
    "what steers the craft, and what simpler models lack",
    "predicting records that were left out",
    "errors ahead and the heading band",
)
"""Stages that `build` tells."""


def build(
    train: Sequence[Record],
    held_out: Sequence[Record] = (),
    ship: Model | None = None,
    watch: Callable[[str], object] = lambda stage: None,
) -> CraftDiagnosis:
    """Build a model of a craft from its records alone, or beside a simulation of its particulars.

    Parameters
    ----------
    train, held_out : records with rudder or command, and heading or yaw rate; held-out records take no part in the
        choice but for one guard: the model that is returned is not worse along them than the chosen law alone.
    ship : a simulation of surge, sway and yaw (`models/particulars.py`); it is corrected by the training records and
        judged beside the model that is built.
    watch : called with every stage when it begins.

    Raises
    ------
    BadInput : no training record, or a ship that has no surge and sway or no numbers.
    CannotFit : the records hold no yaw motion, the rudder or command never moves, or all stretches are too short.
    """
    if not train:
        raise BadInput("no training record", hint="give at least one")
    if ship is not None and not (ship.is_3dof and ship.known):
        raise BadInput(
            f"model {ship.id} is no simulation of surge, sway and yaw", hint="give a YAML file of particulars"
        )
    with arithmetic_guard(), blas_limited():
        cleaned = [without_spikes(r.turned("starboard")) for r in (*train, *held_out)]
        spikes = [f"{r.name}: {n} samples that stand out of their neighbours are left out." for r, n in cleaned if n]
        records = [r for r, _ in cleaned]
        seen = behind_sensors(records[: len(train)], records[len(train) :])
        found = _built(seen.train, seen.held_out, ship, [*spikes, *seen.notes], watch)
        return _of_sensors(found, seen)


def _of_sensors(outcome: CraftDiagnosis, sensors: Sensors) -> CraftDiagnosis:
    """The outcome with what the records show of their sensors, and its models with such instruments."""
    if not sensors.instruments:
        return replace(outcome, causes=sensors.findings)

    def own(model: Model) -> Model:
        return replace(model, instruments=combined(model.instruments, sensors.instruments))

    ship, speed = outcome.ship, outcome.own_speed
    return replace(
        outcome, causes=sensors.findings, model=own(outcome.model), first=own(outcome.first),
        ship=None if ship is None else own(ship), own_speed=None if speed is None else own(speed),
    )  # fmt: skip


def _built(
    train: Sequence[Record], held_out: Sequence[Record], ship: Model | None, spikes: Sequence[str],
    watch: Callable[[str], object],
) -> CraftDiagnosis:  # fmt: skip
    started = time.perf_counter()
    watch(CLIMBING)
    scales = scales_of(train)
    pieces = pieces_of(train, scales)
    given = measured_by_all([*train, *held_out], scales)
    ladder = Ladder(pieces, scales, given, commands=not all(r.has(RUDDERS[0]) for r in train))
    found = climb(ladder)
    watch(LEFT_OUT)
    simulation, told = (None, []) if ship is None else corrected_particulars(ship, train)
    judge = _Judge(train, held_out, simulation, numbers_of(train, scales.time_s, TURNS in given))
    kept = judge.guarded(found)
    watch(AHEAD)
    grown = judge.judged(kept)
    if _beside_straight(grown.ahead, RATE) > 1.0 - SLACK or _beside_straight(grown.ahead) > 1.0:
        grown = judge.by_yaw_rate(grown, ladder.without_heading())
    (laws, steps, refused), model, ahead, more = grown
    final, taken = steps[-1], [] if len(kept.steps) == len(found.steps) else [TAKEN_BACK]
    verdict, reason = verdict_of(final, steering(final), ahead, copied_input(pieces), weak_motion(pieces))
    beyond = {r.name: where for r in held_out if (where := outside(train, r))}
    if verdict in (UNEXPLAINED, PARTLY) and max(r2(final)) >= GOOD and beyond:
        verdict = OUTSIDE
        reason = f"held-out records leave the range of the training records, where {reason}"
    beyond_told = [f"{n} is outside what the training records show: {', '.join(w)}." for n, w in beyond.items()]
    band, inside = heading_band(final, train, held_out, ahead.horizons_s)
    laws_told = tuple(LawTold(**vars(_rise(a)), chosen=a.law is final.law, tied=_is_tied(a, final)) for a in laws)
    covariance = _covariance(final, model)
    return CraftDiagnosis(
        model=model, first=steps[0].model(), ship=simulation, own_speed=ahead.models.get(OWN_SPEED),
        records=(*((r.name, "train") for r in train), *((r.name, "held_out") for r in held_out)),
        verdict=verdict, reason=reason, window_s=final.problem.windows.length_s,
        laws=laws_told, steps=tuple(map(_rise, steps)), numbers=_numbers(model, covariance, by_thrust(laws_told)),
        refused=refused, band=band, inside=inside,
        own_angles=tuple((r.name, float(s)) for r, s in zip(train, final.own_angles, strict=False)),
        ahead=ahead, trusted_s=ahead.trusted_s[BUILT], next_runs=_next(laws, given),
        notes=(*spikes, *taken, *beyond_told, *told, *more), doubts=_of_loop(pieces, scales.time_s),
        wall_s=time.perf_counter() - started, covariance=covariance,
    )  # fmt: skip


def _of_loop(pieces: Sequence[Piece], time_s: float) -> tuple[str, ...]:
    """What is doubted where a controller steers."""
    share = feedback_share(pieces, time_s)
    if share < FED_BACK:
        return ()
    said = f"a controller steers: heading and yaw rate give {100.0 * share:.0f} % of the changes of rudder or command"
    return (f"{said}; what the steps add may be of the controller, and hold only while it steers",)


class _Grown(NamedTuple):
    """The steps that stand, their model, the errors ahead of it and of what stands beside it, and what must be
    known."""

    climb: Climb
    model: Model
    ahead: Validation
    notes: tuple[str, ...] = ()


class _Judge(NamedTuple):
    """What steps are judged by.  ship : the simulation of particulars that stands beside them;  speed : numbers of
    surge and sway of their own."""

    train: Sequence[Record]
    held_out: Sequence[Record]
    ship: Model | None
    speed: dict[str, float]

    def guarded(self, climb: Climb) -> Climb:
        """The steps up to the last that predicts left-out records no worse than any before, and whose free runs of all
        records stay within bounds."""
        errors = [_of_left_out_records(step) for step in climb.steps]
        for last in reversed(range(1, len(errors))):
            rises = [np.clip(errors[last] - before, -np.log(2.0), np.log(2.0)) for before in errors[:last]]
            steady = all(not float(mean_of_known(rise, (0, 1))) > SLACK for rise in rises)
            if steady and self.is_bounded(climb.steps[last].model()):
                return climb._replace(steps=climb.steps[: last + 1])
        return climb._replace(steps=climb.steps[:1])

    def is_bounded(self, model: Model) -> bool:
        """Whether no free run along any record diverges."""
        try:
            found = validate({BUILT: model}, named([*self.train, *self.held_out]), ahead=False)
        except BadInput:
            return False
        return not any(run.diverged for run in found.runs)

    def judged(self, climb: Climb) -> _Grown:
        """The steps that stand along held-out records."""
        first, model = climb.steps[0].model(), climb.final.model()
        ahead, notes = self.ahead(model, first), list[str]()
        near = max(ahead.horizons_s[:NEAR])
        if len(climb.steps) > 1 and self.held_out and mean_ratio(ahead.scores, BUILT, FIRST, near) > WORSE:
            notes.append(LAW_ALONE)
            climb, model, ahead = climb._replace(steps=climb.steps[:1]), first, self.ahead(first, first)
        ratio = mean_ratio(ahead.scores, SHIP, BUILT)
        if self.ship is not None and np.isfinite(ratio):
            more = f"{abs(ratio - 1.0):.0%} {'larger' if ratio > 1.0 else 'smaller'}"
            notes.append(f"The simulation of the particulars has errors of heading and yaw rate ahead that are {more}.")
        return _Grown(climb, model, ahead, tuple(notes))

    def ahead(self, model: Model, first: Model) -> Validation:
        """Errors ahead of a model, of the steering law alone, of particulars, and of surge and sway of its own."""
        judged = named(list(self.held_out) or list(self.train))
        given = {BUILT: model, FIRST: first} | ({} if self.ship is None else {SHIP: self.ship})
        own = with_own_speed(model, self.speed) if self.speed else None
        if own is not None and self.is_bounded(own):
            both = validate(given | {OWN_SPEED: own}, judged)
            if _told_by_speed(both):
                return both
        return validate(given, judged)

    def by_yaw_rate(self, grown: _Grown, ladder: Ladder) -> _Grown:
        """What stands where a model is no better than a craft that goes straight: one that is fitted to the yaw rate
        alone, where this predicts the yaw rate, or else, where it is worse, the damping alone.

        In waves and under sail the slow changes of the neutral angle decide the heading of a window: a fit to it makes
        the effect of the rudder too small.
        """
        if all(piece.record.has(RATE) for piece in ladder.pieces):
            other = self.judged(self.guarded(climb(ladder)))
            if _beside_straight(other.ahead, RATE) < 1.0 - SLACK:
                return other._replace(notes=(*other.notes, RATE_ALONE))
        if not _beside_straight(grown.ahead) > 1.0:
            return grown
        model = _unsteered(grown.model)
        ahead = self.ahead(model, grown.ahead.models[FIRST])
        return grown._replace(model=model, ahead=ahead, notes=(*grown.notes, UNSTEERED))


TAKEN_BACK = "Steps that predict left-out records worse, or whose free runs leave all bounds, were taken back."
LAW_ALONE = "Held-out records are predicted worse with all that entered: the steering law alone is the model."
UNSTEERED = "No better than a craft that goes straight: the steering of the model is set to zero."
RATE_ALONE = (
    "The model is fitted to the yaw rate alone, and predicts no more than that: slow changes of the neutral angle "
    "decide the heading."
)


def _beside_straight(ahead: Validation, *channels: str) -> float:
    """Errors ahead of the model over those of a craft that goes straight, in some channels or in all."""
    return mean_ratio([*ahead.scores, *ahead.simple], BUILT, STRAIGHT, channels=channels or TRUSTED)


def _of_left_out_records(a: Attempt) -> np.ndarray:
    """Log root mean square errors (R, 2) of whole records, each predicted by a fit to the others; of one none."""
    problem = a.problem.by_record()
    if len(problem.counts) < 2:
        return np.zeros((0, 2))
    squares = np.add.reduceat(np.nan_to_num(problem.left_out(a.by_record) ** 2).sum(axis=1), problem.firsts)
    means = squares / np.where(problem.counts > 0.0, problem.counts, np.nan)
    return 0.5 * np.log(means + (1e-3 * problem.windows.motion) ** 2)


def _unsteered(model: Model) -> Model:
    """The model with its linear damping alone."""
    damping = ("a", "a1", "still_damping", LAG)
    kept = [x if n in damping else 0.0 for n, x in zip(model.coordinates, model.coefficients.tolist(), strict=True)]
    return replace(model, coefficients=np.array(kept), instruments={})


def _rise(step: Attempt) -> Rise:
    return Rise(step.last.id, step.last.title, *step.fall, *r2(step), step.count)


def _is_tied(one: Attempt, chosen: Attempt) -> bool:
    """Whether the records cannot tell a law from the best."""
    return one.law is not chosen.law and -one.fall.gain <= one.fall.error


def _numbers(model: Model, covariance: np.ndarray, in_newton: bool) -> tuple[NumberTold, ...]:
    """The published parameters with intervals, and the numbers between order and hull, which are known within a
    tenth; in_newton : orders are forces."""
    slopes = model.parameters_jacobian(model.coefficients)
    spread = NORMAL_90 * np.sqrt(np.abs(np.einsum("ij,jk,ik->i", slopes, covariance, slopes)))
    values = zip(model.parameters.items(), model.parameter_units, spread.tolist(), strict=True)
    own = [
        NumberTold(name, "N" if in_newton and name == "rudder_offset" else unit, value, value - half, value + half)
        for (name, value), unit, half in values
    ]
    units = {name: INSTRUMENTS[name] for name in model.instruments}
    return (*own, *(NumberTold(n, units[n], v, v / 1.1, v * 1.1) for n, v in model.instruments.items()))


def _covariance(final: Attempt, model: Model) -> np.ndarray:
    """(p, p) of the model's coefficients, zero for those that were not free."""
    out, names = np.zeros((len(model.coordinates),) * 2), [n.name for n in final.fitted.numbers]
    own, places = zip(*((names.index(n), i) for i, n in enumerate(model.coordinates) if n in names), strict=True)
    out[np.ix_(places, places)] = final.covariance[np.ix_(own, own)]
    return out


def _told_by_speed(ahead: Validation) -> bool:
    """Whether surge is predicted better than by its mean, and the yaw rate nearly as well as with the measured speed,
    three lengths ahead."""
    horizon = label(ahead.horizons_s[:NEAR][-1])
    surge, own = (ahead.score(c, OWN_SPEED, horizon=horizon) for c in ("surge_m_s", RATE))
    built = ahead.score(RATE, BUILT, horizon=horizon)
    return bool(surge and own and built and surge.r2 > 0.0 and own.r2 > built.r2 - LOST)


def _next(laws: Sequence[Attempt], given: frozenset[str]) -> str:
    """What to record next."""
    wanted = [] if SPEED in given else ["the speed, or positions"]
    if SPEED in given and any(a.fall.gain < 0.0 and -a.fall.gain <= a.fall.error for a in laws):
        wanted = ["runs at two speeds that differ by half, which tell what steers the craft"]
    return "; ".join([*wanted, "a straight leg of a minute before each manoeuvre, which tells the neutral angle"])
