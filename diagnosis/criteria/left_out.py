"""The smallest set of numbers that predicts records which were left out: forward selection, exchange, deletion.

Candidates are groups of numbers, and each number of a group alone, which may then be off by more.  One linearisation
of the free runs says for every candidate what a fit would leave of left-out records
(`mixed_effects.left_out.predicted`); the leaders are refitted.

A group enters if the score of the left-out records, and that of their plain free runs, fall by more than two jackknife
standard errors over records (with few records by the 95 % point of Student's t), and the score by more than LEAST.  Of
those that enter, the one of the largest fall per number goes first, so that many numbers take only what few have left.
Groups whose scores cannot be distinguished from the best are ties.  At the end groups leave again, the one of the
smallest fall per number first, as long as that costs less, and steps after which a state is worse than by the base are
taken back.  Nothing enters where free runs are as good as needed: then a significant fall is that of a difference
without importance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import chain, combinations
from typing import TYPE_CHECKING

import numpy as np

from ...checks.statistics.selection import grown
from ...checks.statistics.tails import student_quantile
from ...estimation.diagnosis_only.mixed_effects.fit import Fitted, Number, expanded, fit, tangents_of
from ...estimation.diagnosis_only.mixed_effects.left_out import (
    Fall,
    LeftOut,
    leave_one_out,
    predicted,
    score_difference,
)
from ...estimation.diagnosis_only.mixed_effects.problem import Problem, pooled
from ...estimation.numerics.threads import in_threads
from ...models.coefficient_groups import parts_of
from ..gain.guard import WORSE

if TYPE_CHECKING:
    from ...estimation.diagnosis_only.mixed_effects.expansion import Tangent
    from ...models.coefficient_groups import Group

LEAST = 0.05
"""Fall of the score for each state below which a group does not matter: the errors fall by a twentieth."""
REFITTED, ALONE = 3, 6
"""Groups, and numbers alone, of the largest predicted fall of the score that are refitted in each step."""
RIVAL = 0.5
"""Share of what a group takes off the score that another one must be predicted to take off to be tried in its place."""
SHORT, LONG = 4, 14
"""Gauss-Newton steps of a candidate and of what is kept; a response model costs so little that both take LONG."""
MOST = 6
ADEQUATE = 0.05
"""Share of a channel's own motion below which its free-run error is no matter."""
TRIM = ("asymmetry", "rudder_offset")
"""Extensions that act on a straight course, as the trim of a single record does."""
COMMON = 0.99
"""Probability of Student's t at which the records' own neutral rudder angles count as the ship's: a trim that differs
between records, as that of wind does, is no property of her."""
FARTHEST = 4.0
"""Prior standard deviations by which a number of a 3-DOF model is off at most."""


@dataclass(frozen=True)
class Attempt:
    """Groups fitted together, and the records predicted by fits that left them out."""

    groups: tuple[Group, ...]
    fitted: Fitted
    left_out: tuple[LeftOut, ...]


@dataclass(frozen=True)
class Step:
    """One group that entered: the fit with it, by how much the score fell, and its ties."""

    group: Group
    attempt: Attempt
    fall: Fall
    tied_with: tuple[Group, ...] = ()


Tried = tuple[Attempt, Fall]
"""An attempt with the fall of the score."""


@dataclass(frozen=True)
class Growing:
    """The attempt with all that has entered, the steps in order, and what the last step refused."""

    now: Attempt
    steps: tuple[Step, ...] = ()
    refused: tuple[Tried, ...] = ()


@dataclass(frozen=True)
class Selection:
    """The base without any group, the steps in order, the final attempt, and what the last step refused."""

    base: Attempt
    steps: tuple[Step, ...]
    final: Attempt
    refused: tuple[tuple[Group, Fall], ...] = field(default=())


@dataclass(frozen=True)
class LeftOutRecords:
    """The criterion: the score of free runs of records that were left out.

    groups : the candidates.  most : groups that may enter; two of a response model may enter in one step.
    """

    problem: Problem
    groups: Sequence[Group]
    most: int

    def tried(self, now: Growing, step: int) -> tuple[Growing, Sequence[Tried]]:
        """The leaders of the screen, refitted; none where nothing is needed."""
        if len(now.steps) >= self.most or not _needed(self.problem, now.now):
            return now, ()
        found = tuple(_tried(self.problem, now.now, self.groups))
        return replace(now, refused=found), found

    def entered(self, now: Growing, tried: Sequence[Tried], step: int) -> Growing | None:
        """With the group of the largest fall per number, or with two that enter together only."""
        steps = _single(self.problem, now.now, tried) or _pair(self.problem, now.now, tried)
        return Growing(steps[-1].attempt, (*now.steps, *steps)) if steps else None


def numbers_of(problem: Problem, groups: Sequence[Group]) -> tuple[Number, ...]:
    """The numbers of groups with their priors about the model's own values."""
    names, theta = problem.names, problem.theta
    places = [(group, name, names.index(name)) for group in groups for name in group.sd]
    return tuple(
        Number(name, place, float(theta[place]), group.sd[name], group.low.get(name, -np.inf))
        for group, name, place in places
    )


def attempt(
    problem: Problem,
    groups: Sequence[Group],
    start: Fitted | None,
    most: int,
    tangents: Sequence[Tangent] | None = None,
) -> Attempt:
    """A fit of the groups from another one's values of their numbers; all others are the model's own.

    tangents : of all records there, where they are known.
    """
    numbers, theta = numbers_of(problem, groups), problem.theta.copy()
    own = None if start is None else start.own
    places = [n.place for n in numbers]
    theta[places] = theta[places] if start is None else start.theta[places]
    fitted = fit(problem, numbers, theta, own, most, tangents)
    return Attempt(tuple(groups), fitted, leave_one_out(fitted))


def select(
    problem: Problem,
    groups: Sequence[Group],
    most: int = MOST,
    first: Sequence[Group] = (),
    proposal: Sequence[str] = (),
) -> Selection:
    """Groups in the order in which they enter.

    first : groups that are known to be wrong: they enter before all others, and stay.
    proposal : names of numbers that free runs of pieces name: they enter where free runs of left-out records confirm
    them and they leave nothing of importance, or predict better than what enters group by group.
    """
    groups = [*(group for group in groups if group.sd), *(part for group in groups for part in parts_of(group))]
    base = now = attempt(problem, (), None, LONG)
    if not (proposal or _needed(problem, base)):
        return Selection(base, (), base)
    groups = common(base, groups)
    steps: list[Step] = []
    for group in first:
        earlier, now = now, attempt(problem, (*now.groups, group), now.fitted, LONG)
        steps.append(Step(group, now, score_difference(problem, earlier.left_out, now.left_out)))
    start, always = now, len(now.groups)
    proposed = _proposed(problem, start, groups, proposal)
    if proposed is not None and not _needed(problem, proposed):
        now, refused = proposed, ()
    else:
        end = grown(LeftOutRecords(problem, groups, most), Growing(start), most)
        now, refused = end.now, tuple((_new(end.now, a), fall) for a, fall in end.refused)
        now = _exchanged(problem, _without_idle(problem, now, always), groups, always)
        steps += end.steps
        if proposed is not None and _better(problem, now, proposed):
            now = proposed
    sound = (a for a in (now, *(s.attempt for s in reversed(steps))) if _likely(problem, start, a))
    now = next((a for a in sound if not loses(problem, base, a)), base)
    if not now.groups:
        return Selection(base, (), base, refused)
    return Selection(base, _steps_of(problem, base, steps, now), now, refused)


def common(base: Attempt, groups: Sequence[Group]) -> Sequence[Group]:
    """The groups without those of a trim where the records' own neutral rudder angles have no common sign beyond
    chance."""
    own = base.fitted.own[:, 0]
    spread = float(np.std(own, ddof=1)) / np.sqrt(own.size) if own.size > 1 else np.inf
    alike = abs(float(np.mean(own))) > student_quantile(COMMON, max(own.size - 1, 1)) * spread
    return groups if alike else [g for g in groups if g.extension not in TRIM]


def _proposed(problem: Problem, start: Attempt, groups: Sequence[Group], names: Sequence[str]) -> Attempt | None:
    """The fit of some numbers alone; None where it does not predict left-out records better than the start does.

    Numbers are at most as many as the records: leaving these out one by one does not judge more.
    """
    alone = {name: g for g in groups if len(g.sd) == 1 for name in g.sd}
    own = tuple(alone[name] for name in names if name in alone)
    if not own or len(own) > len(problem.runs):
        return None
    try:
        trial = attempt(problem, (*start.groups, *own), start.fitted, LONG)
    except np.linalg.LinAlgError:
        return None
    better = enters(problem, score_difference(problem, start.left_out, trial.left_out))
    return trial if better and _likely(problem, start, trial) else None


def _better(problem: Problem, old: Attempt, new: Attempt) -> bool:
    """Whether left-out records are predicted better by more than one standard error; with fewer numbers, at all."""
    fall = score_difference(problem, old.left_out, new.left_out)
    fewer = len(new.fitted.numbers) < len(old.fitted.numbers)
    return fall.gain > (0.0 if fewer else max(fall.error, LEAST))


def _exchanged(problem: Problem, final: Attempt, groups: Sequence[Group], always: int) -> Attempt:
    """The attempt with a candidate of no more numbers in the place of another, where that predicts better: what entered
    first was chosen before the others were known."""
    if not problem.model.is_3dof:
        return final
    for group in final.groups[always:] if len(final.groups) > always + 1 else ():
        rest = attempt(problem, tuple(g for g in final.groups if g.id != group.id), final.fitted, SHORT)
        fewer = [g for g in groups if len(g.sd) <= len(group.sd) and g.id != group.id]
        least = RIVAL * score_difference(problem, rest.left_out, final.left_out).gain
        for trial, _ in _tried(problem, rest, fewer, least):
            fall = score_difference(problem, final.left_out, trial.left_out)
            if fall.gain > max(fall.error, LEAST) and _likely(problem, rest, trial):
                final = attempt(problem, trial.groups, trial.fitted, LONG)
                break
    return final


def _steps_of(problem: Problem, base: Attempt, steps: Sequence[Step], final: Attempt) -> tuple[Step, ...]:
    """One step for each group of the final set, those that came together or by exchange last."""
    entered = {step.group.id: step for step in steps}
    found = [entered[g.id] for g in final.groups if g.id in entered]
    fall = score_difference(problem, base.left_out, final.left_out)
    return (*found, *(Step(g, final, fall) for g in final.groups if g.id not in entered))


def _needed(problem: Problem, now: Attempt) -> bool:
    """Whether a state's free runs are further from the motion than ADEQUATE; the measurement noise is no error.

    Eq. 10 of docs/mathematics/calibration.md.
    """
    square = pooled([x.free for x in now.left_out]) ** 2 - problem.noise_variance
    return bool(np.any(square[problem.state_places] > (ADEQUATE * problem.motion) ** 2))


def loses(problem: Problem, base: Attempt, trial: Attempt) -> bool:
    """Whether some state of left-out records is predicted worse than by the base."""
    old, new = (pooled([x.free for x in a.left_out])[problem.state_places] for a in (base, trial))
    return bool(np.any(new > WORSE * old))


def _likely(problem: Problem, now: Attempt, trial: Attempt) -> bool:
    """Whether no number of the new group is further from what is known of it than FARTHEST."""
    if not problem.model.is_3dof:
        return True
    pairs = list(zip(trial.fitted.values, trial.fitted.numbers, strict=True))[len(now.fitted.numbers) :]
    return all(abs(value - n.mean) <= FARTHEST * n.sd for value, n in pairs)


def _single(problem: Problem, now: Attempt, tried: Sequence[Tried]) -> list[Step]:
    """The step of the group of the largest fall per number, none where no group enters."""
    entering = [t for t in tried if enters(problem, t[1]) and _likely(problem, now, t[0])]
    if not entering:
        return []
    best, fall = max(entering, key=lambda t: _per_number(_new(now, t[0]), t[1].gain))
    new = _new(now, best)
    rivals = [_new(now, a) for a, _ in tried if a is not best and _tied(problem, best, a)]
    ties = tuple({g.of: g for g in rivals if g.of != new.of and len(g.sd) <= len(new.sd)}.values())
    return [Step(new, attempt(problem, best.groups, best.fitted, LONG), fall, ties)]


def _pair(problem: Problem, now: Attempt, tried: Sequence[Tried]) -> list[Step]:
    """The steps of two groups of a response model that enter together only, each needed beside the other: what one of
    them leaves may hide what the other takes off."""
    if problem.model.is_3dof:
        return []
    found: list[tuple[float, list[Step]]] = []
    for (one, _), (other, _) in combinations(tried, 2):
        groups = _new(now, one), _new(now, other)
        try:
            both = attempt(problem, (*one.groups, groups[1]), one.fitted, LONG)
        except np.linalg.LinAlgError:
            continue
        falls = [score_difference(problem, alone.left_out, both.left_out) for alone in (other, one)]
        whole = score_difference(problem, now.left_out, both.left_out)
        if all(enters(problem, fall) for fall in (whole, *falls)):
            found.append((whole.gain, [Step(g, both, fall) for g, fall in zip(groups, falls, strict=True)]))
    return max(found, key=lambda item: item[0])[1] if found else []


def _tried(problem: Problem, now: Attempt, groups: Sequence[Group], least: float = -np.inf) -> list[Tried]:
    """The leaders, of a predicted fall of at least `least`, refitted: attempt and fall of the score, largest first."""
    most = SHORT if problem.model.is_3dof else LONG

    def beside(lead: tuple[Group, Sequence[Tangent] | None]) -> list[Tried]:
        try:
            trial = attempt(problem, (*now.groups, lead[0]), now.fitted, most, lead[1])
        except np.linalg.LinAlgError:
            return []
        return [(trial, score_difference(problem, now.left_out, trial.left_out))]

    found = in_threads(problem.threads, beside, _leaders(problem, now, groups, least))
    return sorted(chain.from_iterable(found), key=lambda item: -item[1].gain)


def _leaders(
    problem: Problem, now: Attempt, groups: Sequence[Group], least: float
) -> list[tuple[Group, Sequence[Tangent] | None]]:
    """Candidates of the largest predicted fall of the score, with tangents to start from, all from one linearisation;
    of a response model all, without any."""
    held = {name for group in now.groups for name in group.sd}
    rest = [g for g in groups if not held & set(g.sd)]
    if not problem.model.is_3dof:
        return [(g, None) for g in rest]
    fitted, before = now.fitted, range(len(now.fitted.numbers))
    each = {n.name: n for n in numbers_of(problem, rest)}
    numbers = [*fitted.numbers, *each.values()]
    place = {n.name: j for j, n in enumerate(numbers)}
    tangents = tangents_of(problem, numbers, fitted.theta, fitted.own)
    expansions = expanded(problem, tangents)

    def picked(group: Group) -> np.ndarray:
        return np.array([*before, *(place[name] for name in group.sd)])

    def gain(group: Group) -> float:
        own = {place[n.name]: n for n in numbers_of(problem, [group])}
        chosen = [own.get(j, n) for j, n in enumerate(numbers)]
        trial = predicted(fitted, expansions, chosen, picked(group))
        return score_difference(problem, now.left_out, trial).gain

    gains = {group.id: gain(group) for group in rest}
    by_gain = sorted((g for g in rest if gains[g.id] >= least), key=lambda g: -gains[g.id])
    whole = [g for g in by_gain if len(g.sd) > 1][:REFITTED]
    alone = [g for g in by_gain if len(g.sd) == 1][:ALONE]
    return [(g, [t.of(picked(g)) for t in tangents]) for g in (*alone, *whole)]


def _per_number(group: Group, gain: float) -> float:
    return gain / len(group.sd)


def enters(problem: Problem, fall: Fall) -> bool:
    """Whether both scores fall by more than chance, and the score by enough to matter.

    Eq. 9 of docs/mathematics/calibration.md.
    """
    least = LEAST * len(problem.state_places)
    errors = max(2.0, student_quantile(0.95, max(len(problem.runs) - 1, 1)))
    return fall.gain > max(least, errors * fall.error) and fall.free_gain > errors * fall.free_error


def _tied(problem: Problem, best: Attempt, other: Attempt) -> bool:
    """Whether the other's score is within one standard error of the best's, and it would enter on its own."""
    fall = score_difference(problem, other.left_out, best.left_out)
    return fall.gain < fall.error


def _new(now: Attempt, trial: Attempt) -> Group:
    return trial.groups[len(now.groups)]


def _without_idle(problem: Problem, final: Attempt, always: int) -> Attempt:
    """The attempt without groups that the others make needless: the one of the smallest fall per number leaves, as
    long as that does not matter.

    always : number of groups, from the first, that stay.
    """
    while len(final.groups) > always + 1:
        without = partial(_without, problem, final)
        trials = in_threads(problem.threads, without, final.groups[always:])
        _, fall, trial = min(trials, key=lambda item: item[0])
        if enters(problem, fall):
            return final
        final = trial
    return final


def _without(problem: Problem, final: Attempt, group: Group) -> tuple[float, Fall, Attempt]:
    """The attempt without a group: by how much the score falls with it, for each number and as a whole."""
    trial = attempt(problem, tuple(g for g in final.groups if g.id != group.id), None, LONG)
    fall = score_difference(problem, trial.left_out, final.left_out)
    return _per_number(group, fall.gain), fall, trial
