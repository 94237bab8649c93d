"""The ladder: for every law that may steer the craft the rungs that it lacks, chosen by `estimation.selection`.

Laws compete with the rungs that each of them needs: of those that left-out blocks of time do not tell from the best,
the one whose inputs say what steers the craft, then the one of the fewest numbers.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...estimation.selection.minimiser import Fitted, minimise
from ...estimation.selection.number import Candidate, Number, distinct
from ...estimation.selection.score import Fall, fall, jackknife, score
from ...estimation.selection.selection import (
    Rules,
    Selection,
    fall_between,
    floor_squares,
    predictions,
    select,
    with_only,
)
from ...models.model import Model, resolve
from ...models.time_scale import OWN_TIME
from ..causes.base import NORMAL_90
from .problem import COMMON, OWN, WindowErrors, linkage_of
from .rungs import GAINS, LAWS, NEUTRAL, NOTHING, RUNGS, Law, Rung, priors_of
from .windows import SYMBOLS, Piece, Scales, mean_of_known, windows_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

LEAST = 0.03
"""Fall of the left-out errors of a channel below which a rung does not matter: 3 %."""
RULES = Rules(least=LEAST, level=0.99, evident=0.84, most=6, leaders=3, of_each=0, hopeless=None)
"""Student's t over 16 blocks is 2.6 at .99, and 1.0 at .84, which suffices for a likelihood ratio of 10."""
SMALL = 0.05
"""Share of the motion below which an error is no matter."""
WIDE = 0.5
"""Usual errors, in the motion, before any fit."""
SLOWER, FIRST, COARSE = (0.4, 1.0, 2.5), 8, 0.01
"""Factors of the time constant of the first starts, their Gauss-Newton steps, and the fall of the cost for each
independent error that ends these."""
OWN_ANGLE, ANGLE_STEPS = 0.05, 3
"""Standard deviation of a record's own neutral angle, in hard rudders, and steps of a fit with these."""
FREED = 2.0
"""Linear damping, in units of 1/T0, that may be negative where nonlinear damping bounds the motion."""

NONE = Fall(0.0, 0.0)


@dataclass(frozen=True)
class Attempt:
    """A law with rungs, fitted.  problem : the errors of windows that it is fitted to;  fall : of the errors of
    left-out blocks by its last rung, of a law beside the best one."""

    ladder: Ladder
    law: Law
    rungs: tuple[Rung, ...]
    problem: WindowErrors
    fitted: Fitted
    fall: Fall = NONE

    def of_size(self, size: np.ndarray) -> Attempt:
        """Fitted with another size of usual errors."""
        problem, point = self.problem.of_size(size), self.fitted.point
        fitted = minimise(problem, self.fitted.numbers, point.values, point.own)
        return replace(self, problem=problem, fitted=fitted)

    def beside(self, other: Attempt) -> Attempt:
        """With the fall of the logarithm of the root mean square error of left-out blocks from another one, mean over
        channels, and its standard error: 0.05 is about 5 %."""
        by, channels = fall_between(self.problem, other.fitted, self.fitted), self.problem.channels
        return replace(self, fall=Fall(by.gain / channels, by.error / channels))

    @property
    def last(self) -> Law | Rung:
        """The rung that was taken last, or else the law."""
        return self.rungs[-1] if self.rungs else self.law

    @property
    def count(self) -> int:
        """Numbers that were fitted."""
        return len(self.fitted.numbers)

    @property
    def score(self) -> float:
        """Score of left-out blocks."""
        return float(score(self.fitted.left_out + floor_squares(self.problem)))

    @cached_property
    def left_out(self) -> NDArray[np.float64]:
        """Errors (W, N + 1, 2) of every window by the fit without its block, nan in gaps."""
        return self.problem.left_out(self.fitted)

    @cached_property
    def by_record(self) -> Fitted:
        """The fit with records as the units that are left out."""
        problem, at = self.problem.by_record(), self.fitted.point.values
        return minimise(problem, self.fitted.numbers, at, problem.no_own, steps=1)

    @cached_property
    def with_angles(self) -> Fitted:
        """The fit with a neutral angle of its own for every record."""
        records = range(int(self.problem.windows.record.max()) + 1)
        angles = [Number(f"{OWN}{record}", self.ladder.own_angle) for record in records]
        numbers, start = (*self.fitted.numbers, *angles), self.fitted.point
        return minimise(self.problem, numbers, start.values, start.own, ANGLE_STEPS)

    @property
    def own_angles(self) -> NDArray[np.float64]:
        """Own neutral angles (R,) of the records."""
        found = self.with_angles.point.values
        return np.array([x for name, x in found.items() if name.startswith(OWN)])

    @cached_property
    def covariance(self) -> NDArray[np.float64]:
        """(q, q) of the fitted numbers: of the cost's curvature, and beside it how they differ between blocks of time.

        Along simulated craft either alone is too small by a quarter to a half; intervals of the sum hold about 90 %.
        To that of the neutral angle comes what records have of their own, which a prior counts in as one record more.
        """
        names = [n.name for n in self.fitted.numbers]
        out, own = self.fitted.covariance.copy(), self.own_angles
        out[(names.index(COMMON),) * 2] += (self.ladder.own_angle**2 + own @ own) / (1.0 + own.size) / own.size
        blocks = len(self.fitted.without)
        if blocks < 4:
            return out
        moved = np.array([[values[name] for name in names] for values in self.fitted.without])
        moved -= moved.mean(axis=0)
        return out + (blocks - 1.0) / blocks * moved.T @ moved

    def model(self, values: Mapping[str, float] | None = None) -> Model:
        """The fitted model with the extensions of its rungs only; values : other ones of its numbers."""
        values = self.fitted.point.values if values is None else values
        whole = dict(zip(self.problem.places, self.problem.coefficients(values).tolist(), strict=True))
        model = self.ladder.model(self.law, self.rungs)
        return replace(
            model, id="craft", title=self.law.title, coefficients=np.array([whole[n] for n in model.coordinates]),
            instruments=linkage_of(values), source="built from records",
            particulars={OWN_TIME: self.ladder.scales.time_s},
        )  # fmt: skip


class Climb(NamedTuple):
    """The laws alone, the steps from the law that is chosen to all that it lacks, and what was refused then: id of a
    rung, fall of the errors, standard error."""

    laws: tuple[Attempt, ...]
    steps: tuple[Attempt, ...]
    refused: tuple[tuple[str, float, float], ...] = ()

    @property
    def final(self) -> Attempt:
        """The last attempt."""
        return self.steps[-1]


class Steering(NamedTuple):
    """What the rudder or command brings to predictions of left-out windows, beside a craft that it does not turn.

    gain, error : fall of the errors and its standard error;  skill, spread : R2 of the yaw rate against the better of
    that craft and one that does not turn at all, and its standard error;  most : share of the yaw motion (rms) that the
    steering makes at most, at the end of its 90 % interval.
    """

    gain: float
    error: float
    skill: float
    spread: float
    most: float


@dataclass(eq=False)
class Ladder:
    """The records of a craft and what can be tried on them.  given : inputs that all records measure."""

    pieces: Sequence[Piece]
    scales: Scales
    given: frozenset[str]
    commands: bool
    problems: dict[str, WindowErrors] = field(default_factory=dict)

    @property
    def own_angle(self) -> float:
        """Standard deviation of a record's own neutral angle, rad or the command's unit."""
        return OWN_ANGLE * self.scales.rudder

    def without_heading(self) -> Ladder:
        """The same for the yaw rate alone."""
        blind = [p._replace(record=p.record.with_channels(heading_rad=None)) for p in self.pieces]
        return Ladder(blind, self.scales, self.given, self.commands)

    def laws(self) -> list[Law]:
        """The laws whose inputs the records measure; of two that are the same on them, the one with more rungs."""
        found = [law for law in LAWS if law.needs <= self.given]
        replaced = frozenset[str]().union(*(law.instead for law in found))
        return [law for law in found if law.id not in replaced]

    def rungs(self, law: Law) -> list[Rung]:
        """The rungs of a law on these records."""
        return [
            r for r in RUNGS
            if r.needs <= self.given and (not r.only or law.id in r.only) and (self.commands or not r.commands_only)
        ]  # fmt: skip

    def model(self, law: Law, rungs: Sequence[Rung]) -> Model:
        """The law with rungs at the means of their priors, at the craft's speed and revolutions."""
        from ...models import kernels

        s, every = self.scales, (NEUTRAL, *rungs)
        family = "+".join([law.family, *(r.extension for r in every if r.extension is not None)])
        means = {name: prior.mean for one in (law, *every) for name, prior in priors_of(one.numbers, s).items()}
        return replace(
            resolve(law.family.split("+")[0]), family=family, speed_m_s=s.speed,
            coefficients=np.array([means.get(name, 0.0) for name in kernels.load(family).COEFFICIENTS]),
            n0_rps=s.turns if np.isfinite(s.turns) else None,
            max_step_s=max(min(s.time_s / 10.0, s.step_s), s.time_s / 40.0),
        )  # fmt: skip

    def problem(self, law: Law) -> WindowErrors:
        """The errors of the records' windows by a law with all its rungs; made once."""
        if law.id not in self.problems:
            windows = windows_of(self.pieces, self.model(law, self.rungs(law)), self.scales)
            self.problems[law.id] = WindowErrors(windows, self.scales.time_s, WIDE * windows.motion)
        return self.problems[law.id]

    def first(self, law: Law) -> Attempt:
        """The best of several starts of a law alone, all gains then of the sign that their sum has."""
        problem, priors = self.problem(law), priors_of((*law.numbers, *NEUTRAL.numbers), self.scales)
        numbers = [prior.number(name) for name, prior in priors.items()]
        starts = [{name: p.mean * (1.0 / slower - 1.0) for name, p in priors.items()} for slower in SLOWER]
        tried = [minimise(problem, numbers, start, problem.no_own, FIRST, coarse=COARSE) for start in starts]
        best = min(tried, key=lambda fitted: fitted.point.cost).point
        sign = np.sign(sum(best.values[n.name] / n.sd for n in numbers if n.name in GAINS))
        ends = (0.0, np.inf) if sign >= 0.0 else (-np.inf, 0.0)
        signed = [replace(n, low=ends[0], high=ends[1]) if n.name in GAINS else n for n in numbers]
        return Attempt(self, law, (), problem, minimise(problem, signed, best.values, best.own))

    def bank(self, law: Law, always: Sequence[Number]) -> dict[Candidate, Rung]:
        """The ways in which rungs may enter beside the numbers of a law."""
        s, model = self.scales, self.problem(law).windows.model
        damping = [n for n in always if n.name in ("a", "a1")][-1]
        place = model.coordinates.index(damping.name)
        unit = FREED / s.time_s / (s.speed if damping.name == "a1" else 1.0)
        free = replace(damping, high=unit - float(model.coefficients[place]))
        return {c: rung for rung in self.rungs(law) for c in rung.candidates(self.scales, free)}

    def chosen(self, alone: Attempt) -> tuple[Attempt, Selection]:
        """A law with the rungs that it needs; what is doubtful comes last, and has to be surer."""
        problem, always = alone.problem, alone.fitted.numbers
        bank, windows = self.bank(alone.law, always), problem.windows
        enough = np.sqrt((SMALL * windows.motion) ** 2 + problem.floor**2)
        rules = replace(RULES, enough=enough)
        sure = [c for c, rung in bank.items() if not rung.doubtful]
        found = select(problem, sure, rules, alone.fitted, always)
        causes = {c.id for c in found.candidates}
        rest = [c for c, rung in bank.items() if rung.doubtful and c.id not in causes]
        more = select(problem, rest, replace(rules, evident=rules.level), found.final, found.final.numbers)
        found = Selection(found.base, (*found.entered, *more.entered), more.final)
        return replace(alone, rungs=tuple(bank[c] for c in found.candidates), fitted=found.final), found


def climb(ladder: Ladder) -> Climb:
    """The rungs of every law, and the law that does best with them; it is fitted anew with the size of its own errors.

    While laws are compared errors have the usual size of those of the law that is best alone.
    """
    alone = [ladder.first(law) for law in ladder.laws()]
    size = np.min([a.problem.usual(a.fitted) for a in alone], axis=0)
    alone = [a.of_size(size) for a in alone]
    grown = [(a, *ladder.chosen(a)) for a in alone]
    best = min((final for _, final, _ in grown), key=lambda a: a.score)
    law, final, selection = min(
        (one for one in grown if one[1] is best or _is_as_good(one[1], best)),
        key=lambda one: (not one[1].law.seen, one[1].count, one[1].score),
    )
    steps = [law]
    for count in range(1, len(final.rungs) + 1):
        part = with_only(law.problem, selection, selection.entered[:count], law.fitted.numbers)
        steps.append(replace(law, rungs=final.rungs[:count], fitted=part.final).beside(steps[-1]))
    steps[-1] = steps[-1].of_size(final.problem.usual(final.fitted))
    first = min(alone, key=lambda a: a.score)
    return Climb(tuple(a.beside(first) for a in alone), tuple(steps), _refused(final))


def _is_as_good(one: Attempt, best: Attempt) -> bool:
    """Whether an attempt is within LEAST and a standard error of the best."""
    by = best.beside(one).fall
    return by.gain < min(by.error, LEAST)


def _refused(final: Attempt) -> tuple[tuple[str, float, float], ...]:
    """Rungs that are not in, with the fall of the errors that the linearisation predicts, and its standard error."""
    held, taken, problem = final.fitted.numbers, {r.of or r.id for r in final.rungs}, final.problem
    bank = {c: r for c, r in final.ladder.bank(final.law, held).items() if c.id not in taken}
    joint = {replace(c, numbers=distinct((*held, *c.numbers))): r.id for c, r in bank.items()}
    floor, best = floor_squares(problem), dict[str, tuple[str, float, float]]()
    for candidate, left, _ in predictions(problem, list(joint), final.fitted):
        by, id_ = fall(final.fitted.left_out, left, floor), joint[candidate]
        best.setdefault(id_, (id_, by.gain / problem.channels, by.error / problem.channels))
    return tuple(best.values())


# ---- what the steering brings
def steering(now: Attempt) -> Steering:
    """How much better left-out windows are predicted with the rudder or command than without it."""
    without = now.ladder.first(NOTHING).of_size(now.problem.size)
    return Steering(*now.beside(without).fall, *_skill(without, now), _most(now))


def _most(now: Attempt) -> float:
    """Share of the yaw motion within windows (rms) that the steering makes, with its gains at the ends of their 90 %
    intervals."""
    problem, windows = now.problem, now.problem.windows
    halves = NORMAL_90 * np.sqrt(np.diag(now.covariance))
    most = dict(now.fitted.point.values)
    for number, half in zip(now.fitted.numbers, halves.tolist(), strict=True):
        if number.name in GAINS:
            most[number.name] += half if most[number.name] >= 0.0 else -half
    without = most | {name: 0.0 for name in GAINS if name in most}
    both = windows.errors([problem.lane(most), problem.lane(without)]).reshape(2, *windows.known.shape)
    steered = np.where(windows.known, both[0] - both[1], np.nan)[:, :, :1]
    return float(np.sqrt(mean_of_known(steered**2, (0, 1)))[0] / windows.motion[0])


def _skill(without: Attempt, now: Attempt) -> tuple[float, float]:
    """R2 of the yaw rate, or of the heading where no yaw rate was measured, with its jackknife standard error."""
    w = now.problem.windows
    still = w.start[:, None, [w.model.states.index(s) for s in SYMBOLS]] - w.measured
    still[:, :, 0] = -w.measured[:, :, 0]
    squares = (now.fitted.left_out, without.fitted.left_out, now.problem.sums(np.nan_to_num(still)))
    channel = 0 if now.problem.counts[:, 0].any() else 1
    total = np.stack(squares)[:, :, channel]

    def share(keep: np.ndarray) -> float:
        own, *simple = total[:, keep].sum(axis=1).tolist()
        return 1.0 - own / max(min(simple), 1e-300)

    blocks = np.arange(total.shape[1])
    error = float(jackknife(np.array([share(blocks != b) for b in blocks]))) if blocks.size > 2 else np.inf
    return share(blocks), error
