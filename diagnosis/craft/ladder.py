"""The ladder: what steers the craft, then one lack after the other, as long as left-out windows are predicted better.

`climb` is the selection.  It knows of a candidate only its fit and the errors of blocks of time that were left out, so
that another forward selection over groups can take its place.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import product
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...estimation.diagnosis_only.windows.fit import (
    Fitted,
    Number,
    covariance_of,
    criterion_at,
    fall,
    fit,
    left_out_errors,
    mean_squares,
)
from ...estimation.diagnosis_only.windows.problem import SYMBOLS, Piece, Windows, mean_of_known, windows_of
from ...estimation.selection.score import jackknife
from ...models.errors import CannotFit
from ...models.model import Model, resolve
from ...models.time_scale import OWN_TIME
from ..causes.base import NORMAL_90
from .rungs import GAINS, LAWS, NEUTRAL, NOTHING, RUNGS, Craft, Law, Rung

if TYPE_CHECKING:
    from numpy.typing import NDArray

LEAST = 0.03
"""Fall of the left-out errors below which a rung does not matter: 3 %."""
ERRORS, LIKELY = 2.5, 1.0
"""Standard errors over blocks by which the errors must fall: alone, and where the criterion falls by SURE as well."""
KNOWN, CHANCE, SURE = 2.0, 4.0, 6.0
"""Fall of the criterion, half a likelihood-ratio statistic, that each number must bring where a measured input acts,
where something is supposed, and where LIKELY is enough."""
SMALL = 0.05
"""Share of the motion below which an error is no matter."""
MOST = 6
FIRST, SHORT, LONG = 6, 8, 16
"""Gauss-Newton steps of a first start, of a candidate, and of what is kept."""
OWN_ANGLE = 0.05
"""Standard deviation of a record's own neutral angle, in hard rudders."""
SLOWER, WEAKER, DESCENDED = (0.4, 1.0, 2.5), (1.0, 4.0, 20.0), 4
"""Factors of time constant and gain of the first starts, and how many of these are followed."""
FREED = 2.0
"""Linear damping, in units of 1/T0, that may be negative where nonlinear damping bounds the motion."""


@dataclass(frozen=True)
class Attempt:
    """A law with rungs, fitted, and the errors of windows whose block of time was left out.

    sign : of the steering;  linkage : numbers between order and hull (`models.instruments`).
    """

    law: Law
    rungs: tuple[Rung, ...]
    sign: float
    linkage: Mapping[str, float]
    fitted: Fitted
    errors: NDArray[np.float64]

    @property
    def count(self) -> int:
        """Numbers that were fitted."""
        return len(self.fitted.numbers) + len(self.linkage)


@dataclass(frozen=True)
class Step:
    """A rung that was taken: the attempt with it, and by how much errors fall, with the standard error."""

    id: str
    title: str
    attempt: Attempt
    gain: float
    error: float


@dataclass(frozen=True)
class Climb:
    """The laws compared (fall against the best, with its standard error), the steps, and what the last step refused."""

    laws: tuple[tuple[Attempt, float, float], ...]
    steps: tuple[Step, ...]
    refused: tuple[tuple[str, float, float], ...] = ()

    @property
    def final(self) -> Attempt:
        """The last attempt."""
        return self.steps[-1].attempt


class Steering(NamedTuple):
    """What the rudder or command brings to predictions of left-out windows, beside a craft that it does not turn.

    gain, error : fall of the errors (`fall`) and its standard error;  skill, spread : R2 of the yaw rate against the
    better of that craft and one that does not turn at all, and its standard error;  most : share of the yaw motion
    (rms) that the steering makes at most, at the end of its 90 % interval.
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
    craft: Craft
    given: frozenset[str]
    commands: bool
    kept: dict[tuple[str, tuple[tuple[str, float], ...]], Windows] = field(default_factory=dict)

    def without_heading(self) -> Ladder:
        """The same for the yaw rate alone."""
        blind = [p._replace(record=p.record.with_channels(heading_rad=None)) for p in self.pieces]
        return Ladder(blind, self.craft, self.given, self.commands)

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

    def structure(self, law: Law) -> Model:
        """The law's family with the extensions of all its rungs, without effect."""
        extensions = [r.extension for r in (NEUTRAL, *self.rungs(law)) if r.extension is not None]
        return self.blank("+".join([law.family, *extensions]))

    def blank(self, family: str) -> Model:
        """A model of a family at the craft's speed and revolutions, all coefficients zero."""
        from ...models import kernels

        s, own = self.craft.scales, resolve(family.split("+")[0])
        names = kernels.load(family).COEFFICIENTS
        values = np.array([0.5 * s.time_s if name == "lead_T2" else 0.0 for name in names])
        return replace(
            own, family=family, coefficients=values, speed_m_s=s.speed,
            n0_rps=s.turns if np.isfinite(s.turns) else None,
            max_step_s=max(min(s.time_s / 10.0, self.craft.step_s), s.time_s / 40.0),
        )  # fmt: skip

    def windows(self, law: Law, linkage: Mapping[str, float]) -> Windows:
        """The records' windows for a law; made once."""
        key = law.id, tuple(sorted(linkage.items()))
        if key not in self.kept:
            self.kept[key] = windows_of(self.pieces, self.structure(law), self.craft.scales, linkage)
        return self.kept[key]

    def numbers(self, law: Law, rungs: Sequence[Rung], sign: float) -> list[Number]:
        """The free numbers with their priors; linear damping may be negative beside nonlinear damping."""
        names = self.structure(law).coordinates
        priors = law.priors(self.craft, sign) | NEUTRAL.priors(self.craft, sign)
        if any(r.nonlinear_damping for r in rungs):
            unit = FREED / self.craft.scales.time_s
            limits = {"a": unit, "a1": unit / self.craft.scales.speed}
            free = [n for n in ("a", "a1") if n in priors][-1]
            priors[free] = priors[free]._replace(high=limits[free])
        for rung in rungs:
            priors |= rung.priors(self.craft, sign)
        return [Number(name, names.index(name), *prior) for name, prior in priors.items()]

    def attempt(
        self, law: Law, rungs: Sequence[Rung], sign: float, linkage: Mapping[str, float], start: np.ndarray,
        shifts: np.ndarray | None, most: int,
    ) -> Attempt:  # fmt: skip
        """A fit from a start, with left-out errors."""
        found = self.fitted(law, rungs, sign, linkage, start, shifts, most)
        return Attempt(law, tuple(rungs), sign, dict(linkage), found, left_out_errors(found))

    def fitted(
        self, law: Law, rungs: Sequence[Rung], sign: float, linkage: Mapping[str, float], start: np.ndarray,
        shifts: np.ndarray | None, most: int, windows: Windows | None = None,
    ) -> Fitted:  # fmt: skip
        """A fit from a start."""
        s = self.craft.scales
        own = self.windows(law, linkage) if windows is None else windows
        return fit(own, self.numbers(law, rungs, sign), start, s.time_s, OWN_ANGLE * s.rudder, shifts, most)

    def fitted_to(self, a: Attempt, keep: np.ndarray) -> Fitted:
        """An attempt's numbers fitted to some of its windows, (W,) whether."""
        start = a.fitted.coefficients, a.fitted.shifts
        return self.fitted(a.law, a.rungs, a.sign, a.linkage, *start, FIRST, a.fitted.windows.of(keep))

    def first(self, law: Law) -> Attempt:
        """The best of several starts of a law alone: both signs, several sizes of time constant and gain."""
        s, windows = self.craft.scales, self.windows(law, {})
        starts = [(sign, self._start(law, sign, a, b)) for sign, a, b in product((1.0, -1.0), SLOWER, WEAKER)]
        cost = [
            criterion_at(windows, self.numbers(law, (), sign), x, s.time_s, OWN_ANGLE * s.rudder) for sign, x in starts
        ]
        chosen = [starts[i] for i in np.argsort(cost)[:DESCENDED].tolist()]
        tried = [(self.fitted(law, (), sign, {}, x, None, FIRST), sign) for sign, x in chosen]
        best, sign = min(tried, key=lambda t: t[0].criterion)
        return self.attempt(law, (), sign, {}, best.coefficients, best.shifts, LONG)

    def _start(self, law: Law, sign: float, slower: float, weaker: float) -> np.ndarray:
        """Coefficients of a law: damping and steering of the craft's own size over these factors."""
        blank, priors = self.structure(law), law.priors(self.craft, sign)
        start, steering = blank.coefficients.copy(), [name for name in priors if name[0] == "b"]
        for name, prior in priors.items():
            size = sign * prior.sd / 3.0 / len(steering) / weaker if name in steering else prior.mean
            start[blank.coordinates.index(name)] = size / slower
        return start

    def with_rung(self, now: Attempt, rung: Rung) -> Attempt | None:
        """The best of the rung's starts beside what there is; None where it fails."""
        if rung.instrument is None:
            return self._best(now, rung, [now.linkage])
        best, tried = None, list(rung.trials(self.craft))
        for finer in (1.5, 1.25, 1.1, 1.04):
            linkages = [{**now.linkage, rung.instrument: value} for value in tried]
            best = min(filter(None, (best, self._best(now, rung, linkages))), key=_cost, default=None)
            if best is None:
                break
            tried = [best.linkage[rung.instrument] * factor for factor in (1.0 / finer, finer)]
        return best

    def _best(self, now: Attempt, rung: Rung, linkages: Sequence[Mapping[str, float]]) -> Attempt | None:
        """The best fit of several linkages and all starts of a rung."""
        priors, names = rung.priors(self.craft, now.sign), self.structure(now.law).coordinates
        trials: list[Attempt] = []
        for linkage, begin in product(linkages, rung.starts):
            start = now.fitted.coefficients.copy()
            for (name, prior), z in zip(priors.items(), begin, strict=False):
                start[names.index(name)] = prior.mean + z * prior.sd
            with suppress(np.linalg.LinAlgError, CannotFit):
                rungs = (*now.rungs, rung)
                trials.append(self.attempt(now.law, rungs, now.sign, linkage, start, now.fitted.shifts, SHORT))
        return min(trials, key=_cost, default=None)

    def with_law(self, now: Attempt, law: Law) -> Attempt | None:
        """The same rungs on another law; None where it has not all of them."""
        if any(r not in self.rungs(law) for r in now.rungs):
            return None
        base = self.first(law)
        start, mine = base.fitted.coefficients.copy(), self.structure(now.law).coordinates
        names = self.structure(law).coordinates
        for rung in now.rungs:
            for name in rung.priors(self.craft, now.sign):
                start[names.index(name)] = now.fitted.coefficients[mine.index(name)]
        return self.attempt(law, now.rungs, base.sign, now.linkage, start, now.fitted.shifts, LONG)


def _cost(attempt: Attempt) -> float:
    return attempt.fitted.criterion


def model_of(ladder: Ladder, attempt: Attempt) -> Model:
    """The fitted model with the extensions of its rungs only."""
    extensions = [r.extension for r in (NEUTRAL, *attempt.rungs) if r.extension is not None]
    blank = ladder.blank("+".join([attempt.law.family, *extensions]))
    whole = dict(zip(attempt.fitted.windows.model.coordinates, attempt.fitted.coefficients.tolist(), strict=True))
    return replace(
        blank, id="craft", title=attempt.law.title, coefficients=np.array([whole[n] for n in blank.coordinates]),
        instruments=dict(attempt.linkage), source="built from records",
        particulars={OWN_TIME: ladder.craft.scales.time_s},
    )  # fmt: skip


def better(old: Attempt, new: Attempt) -> tuple[float, float]:
    """By how much left-out errors fall from old to new, and the standard error (`fall`)."""
    return fall(old.errors, new.errors, old.fitted.windows, old.fitted.sizes)


def steering(ladder: Ladder, now: Attempt) -> Steering:
    """How much better left-out windows are predicted with the rudder or command than without it."""
    without = ladder.first(NOTHING)
    return Steering(*better(without, now), *_skill(without, now), _most(ladder, now))


def _most(ladder: Ladder, now: Attempt) -> float:
    """Share of the yaw motion within windows (rms) that the steering makes, with its gains at the ends of their 90 %
    intervals."""
    fitted, w = now.fitted, now.fitted.windows
    halves = NORMAL_90 * np.sqrt(np.diag(covariance_of(fitted, OWN_ANGLE * ladder.craft.scales.rudder)))
    gains = [(n.place, half) for n, half in zip(fitted.numbers, halves.tolist(), strict=True) if n.name in GAINS]
    without, most = fitted.coefficients.copy(), fitted.coefficients.copy()
    for place, half in gains:
        without[place] = 0.0
        most[place] += half if most[place] >= 0.0 else -half
    errors = w.errors(np.stack([most, without]), np.tile(fitted.shifts[w.record], (2, 1)))
    steered = (errors[: len(w.inputs)] - errors[len(w.inputs) :])[:, :, :1]
    return float(np.sqrt(mean_of_known(steered**2, (0, 1)))[0] / w.motion[0])


def _skill(without: Attempt, now: Attempt) -> tuple[float, float]:
    """R2 of the yaw rate, or of the heading where no yaw rate was measured, with its jackknife standard error."""
    w, sizes = now.fitted.windows, now.fitted.sizes
    still = np.tile(w.start[:, None, [w.model.states.index(s) for s in SYMBOLS]] - w.measured, (2, 1, 1))
    still[:, :, 0] = -np.tile(w.measured[:, :, 0], (2, 1))
    squares = mean_squares((now.errors, without.errors, still), w, sizes)
    channel = 0 if squares[0, :, 0, 1].any() else 1
    total = squares[:, :, channel, 0]

    def share(keep: np.ndarray) -> float:
        own, *simple = total[:, keep].sum(axis=1).tolist()
        return 1.0 - own / max(min(simple), 1e-300)

    blocks = np.arange(total.shape[1])
    error = float(jackknife(np.array([share(blocks != b) for b in blocks]))) if blocks.size > 2 else np.inf
    return share(blocks), error


def enters(old: Attempt, new: Attempt, gain: float, error: float) -> bool:
    """Whether a rung is taken: errors of left-out blocks fall, and the criterion by more than chance would do.

    That a measured input acts is known beforehand: only its size is asked.
    """
    each = (old.fitted.criterion - new.fitted.criterion) / (new.count - old.count)
    added = set(new.rungs) - set(old.rungs)
    known = all(r.needs for r in added)
    likely = known or (each > SURE and not any(r.doubtful for r in added))
    return each > (KNOWN if known else CHANCE) and gain > max(LEAST, (LIKELY if likely else ERRORS) * error)


def climb(ladder: Ladder) -> Climb:
    """Choose the law, then rungs, then see whether another law would do better with them."""
    laws = [ladder.first(law) for law in ladder.laws()]
    now, told = _law(laws)
    steps = [Step(now.law.id, now.law.title, now, 0.0, 0.0)]
    refused: tuple[tuple[str, float, float], ...] = ()
    while len(steps) <= MOST and _needed(now):
        tried = [
            (r, a)
            for r in ladder.rungs(now.law)
            if r not in now.rungs and not _excluded(r, now) and (a := ladder.with_rung(now, r))
        ]
        falls = [(r, a, *better(now, a)) for r, a in tried]
        entering = [t for t in falls if enters(now, *t[1:])]
        if not entering:
            before, now = now, _richer_law(ladder, now, steps)
            if now is before:
                refused = tuple((r.id, gain, error) for r, _, gain, error in falls)
                break
            continue
        rung, attempt, gain, error = max(entering, key=lambda t: t[2] / (t[1].count - now.count))
        now = ladder.attempt(
            now.law, attempt.rungs, now.sign, attempt.linkage, attempt.fitted.coefficients, attempt.fitted.shifts, LONG
        )
        steps.append(Step(rung.id, rung.title, now, gain, error))
        now = _other_law(ladder, now, steps)
    return Climb(told, tuple(_pruned(ladder, steps)), refused)


def _needed(now: Attempt) -> bool:
    """Whether errors of left-out windows are larger than SMALL, in yaw rate or heading; the noise is no error."""
    w = now.fitted.windows
    square = mean_of_known(now.errors**2, (0, 1)) - np.nan_to_num(w.noise) ** 2
    return bool(np.any(square > (SMALL * w.motion) ** 2))


def _law(laws: Sequence[Attempt]) -> tuple[Attempt, tuple[tuple[Attempt, float, float], ...]]:
    """The law of the fewest numbers among those that are within LEAST and a standard error of the best, or the one
    that the records' own columns speak for."""
    best = max(laws, key=lambda a: better(laws[0], a)[0])
    told = tuple((a, *better(best, a)) for a in laws)
    equal = [a for a, gain, error in told if a is best or gain > -min(error, LEAST)]
    return min(equal, key=lambda a: (not a.law.seen, a.count, -better(best, a)[0])), told


def _excluded(rung: Rung, now: Attempt) -> bool:
    """One nonlinear damping only; wind by heading not beside the measured one."""
    ids = {r.id for r in now.rungs}
    if rung.nonlinear_damping:
        return any(r.nonlinear_damping for r in now.rungs)
    return (rung.id == "heading_moment" and "measured_wind" in ids) or (
        rung.id == "measured_wind" and "heading_moment" in ids
    )


def _other_law(ladder: Ladder, now: Attempt, steps: list[Step]) -> Attempt:
    """The same rungs on the law that does best with them; the step tells of a change.

    Of two laws of as many numbers the one with the smaller errors of left-out blocks and the smaller criterion stands:
    that the other came first is no reason for it.
    """
    others = [a for law in ladder.laws() if law is not now.law and (a := ladder.with_law(now, law))]
    found = [(a, *better(now, a)) for a in others]
    entering = [t for t in found if t[1] > max(LEAST, _doubt(now, t[0]) * t[2])]
    entering = entering or [t for t in found if t[0].count < now.count and t[1] > -min(t[2], LEAST)]
    if not entering:
        return now
    attempt, gain, error = max(entering, key=lambda t: t[1])
    steps.append(Step(attempt.law.id, f"instead: {attempt.law.title}", attempt, gain, error))
    return attempt


def _doubt(now: Attempt, other: Attempt) -> float:
    """Standard errors by which another law must do better to take the place of the present one."""
    if other.count > now.count:
        return ERRORS
    return 0.0 if other.fitted.criterion < now.fitted.criterion else LIKELY


def _richer_law(ladder: Ladder, now: Attempt, steps: list[Step]) -> Attempt:
    """Another law with a rung that the present one has not, where both together do better than all that it can add:
    before that rung the records did not tell the laws apart."""
    own = ladder.rungs(now.law)
    more = {law: [r for r in ladder.rungs(law) if r not in own] for law in ladder.laws()}
    others = [a for law, rungs in more.items() if rungs and (a := ladder.with_law(now, law))]
    tried = [(r, b) for a in others for r in more[a.law] if (b := ladder.with_rung(a, r))]
    found = [(r, b, *better(now, b)) for r, b in tried]
    entering = [t for t in found if t[2] > max(LEAST, ERRORS * t[3])]
    if not entering:
        return now
    rung, attempt, gain, error = max(entering, key=lambda t: t[2])
    steps.append(Step(rung.id, f"instead: {attempt.law.title}; {rung.title}", attempt, gain, error))
    return attempt


def _pruned(ladder: Ladder, steps: Sequence[Step]) -> list[Step]:
    """The steps, with a last one where a rung has become idle by later ones."""
    out, now = list(steps), steps[-1].attempt
    for rung in now.rungs[:-1]:
        rest = tuple(r for r in now.rungs if r is not rung)
        linkage = {k: v for k, v in now.linkage.items() if k != rung.instrument}
        start = now.fitted.coefficients.copy()
        names, blank = ladder.structure(now.law).coordinates, ladder.structure(now.law).coefficients
        for name in rung.priors(ladder.craft, now.sign):
            start[names.index(name)] = blank[names.index(name)]
        without = ladder.attempt(now.law, rest, now.sign, linkage, start, now.fitted.shifts, LONG)
        gain, error = better(without, now)
        if not enters(without, now, gain, error):
            now = without
            out.append(Step(rung.id, f"no longer needed: {rung.title}", now, -gain, error))
    return out
