"""Forward selection of groups of numbers by free runs of records that were left out.

A group enters if the score of the left-out records, and that of their plain free runs, fall by more than two jackknife
standard errors over records (with few records by the 95 % point of Student's t), and the score by more than LEAST.  Of
those that enter, the one of the largest fall per number goes first, so that many numbers take only what few have left;
one that makes a state of left-out records worse than the base goes after all others.  Groups whose scores cannot be
distinguished from the best are ties.  At the end groups leave again, the one of the smallest fall per number first, as
long as that costs less, and steps after which a state is worse than by the base are taken back.  Nothing enters where
free runs are as good as needed: then a significant fall is that of a difference without importance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import chain, combinations, pairwise
from typing import TYPE_CHECKING

import numpy as np

from ...checks.statistics.tails import student_quantile
from ...estimation.mixed_effects.fit import Fitted, Number, fit, normal_equations, stepped
from ...estimation.mixed_effects.left_out import Fall, LeftOut, leave_one_out, score_difference
from ...estimation.mixed_effects.problem import Problem, pooled
from ...estimation.threads import in_threads
from ..gain.guard import WORSE

if TYPE_CHECKING:
    from ...models.coefficient_groups import Group

LEAST = 0.05
"""Fall of the score for each state below which a group does not matter: the errors fall by a twentieth."""
REFITTED, FEW = 4, 2
"""Groups of the largest predicted fall, and of the largest per number, that are refitted in each step."""
SHORT, LONG = 4, 14
"""Gauss-Newton steps of a candidate and of what is kept; a response model costs so little that both take LONG."""
MOST = 6
ADEQUATE = 0.05
"""Share of a channel's own motion below which its free-run error is no matter."""
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


@dataclass(frozen=True)
class Selection:
    """The base without any group, the steps in order, the final attempt, and what the last step refused."""

    base: Attempt
    steps: tuple[Step, ...]
    final: Attempt
    refused: tuple[tuple[Group, Fall], ...] = field(default=())


Tried = tuple[Attempt, Fall]
"""An attempt with the fall of the score."""


def numbers_of(problem: Problem, groups: Sequence[Group]) -> tuple[Number, ...]:
    """The numbers of groups with their priors about the model's own values."""
    names = [*problem.model.coordinates, *problem.model.constant_names]
    theta = problem.model.theta
    places = [(group, name, names.index(name)) for group in groups for name in group.sd]
    return tuple(
        Number(name, place, float(theta[place]), group.sd[name], group.low.get(name, -np.inf))
        for group, name, place in places
    )


def attempt(problem: Problem, groups: Sequence[Group], start: Fitted | None, most: int) -> Attempt:
    """A fit of the groups from another one's values."""
    theta = problem.model.theta if start is None else start.theta
    own = None if start is None else start.own
    fitted = fit(problem, numbers_of(problem, groups), theta, own, most)
    return Attempt(tuple(groups), fitted, leave_one_out(fitted))


def select(problem: Problem, groups: Sequence[Group], free: Group | None = None, most: int = MOST) -> Selection:
    """Groups in the order in which they enter.

    free : a group whose numbers are fitted along with every other; it counts as a step where it would enter alone.
    With it nothing has entered unless the last fit predicts better than the base does.
    """
    base = now = attempt(problem, (), None, LONG)
    if not _needed(problem, base):
        return Selection(base, (), base)
    steps: list[Step] = []
    refused: tuple[tuple[Group, Fall], ...] = ()
    if free is not None:
        now = attempt(problem, (free,), None, LONG)
        fall = score_difference(problem, base.left_out, now.left_out)
        steps += [Step(free, now, fall)] if _enters(problem, fall) else []
    while len(steps) < most and _needed(problem, now):
        tried = _tried(problem, now, groups)
        entered = _single(problem, base, now, tried) or _pair(problem, now, tried)
        if not entered:
            refused = tuple((_new(now, a), fall) for a, fall in tried)
            break
        steps += entered
        now = entered[-1].attempt
    final = _without_idle(problem, now, () if free is None else (free,))
    if _worse(problem, base, final):
        final = next((s.attempt for s in reversed(steps) if not _worse(problem, base, s.attempt)), base)
    idle = free is not None and not _enters(problem, score_difference(problem, base.left_out, final.left_out))
    if not steps or not final.groups or idle:
        return Selection(base, (), base, refused)
    kept_ids = {group.id for group in final.groups}
    return Selection(base, tuple(step for step in steps if step.group.id in kept_ids), final, refused)


def _needed(problem: Problem, now: Attempt) -> bool:
    """Whether a state's free runs are further from the motion than ADEQUATE; the measurement noise is no error."""
    square = pooled([x.free for x in now.left_out]) ** 2 - problem.noise_variance
    return bool(np.any(square[problem.state_places] > (ADEQUATE * problem.motion) ** 2))


def _worse(problem: Problem, base: Attempt, trial: Attempt) -> bool:
    """Whether some state of left-out records is predicted worse than by the base."""
    old, new = (pooled([x.free for x in a.left_out])[problem.state_places] for a in (base, trial))
    return bool(np.any(new > WORSE * old))


def _likely(problem: Problem, now: Attempt, trial: Attempt) -> bool:
    """Whether no number of the new group is further from what is known of it than FARTHEST."""
    if not problem.model.is_3dof:
        return True
    pairs = list(zip(trial.fitted.values, trial.fitted.numbers, strict=True))[len(now.fitted.numbers) :]
    return all(abs(value - n.mean) <= FARTHEST * n.sd for value, n in pairs)


def _single(problem: Problem, base: Attempt, now: Attempt, tried: Sequence[Tried]) -> list[Step]:
    """The step of the group of the largest fall per number, none where no group enters."""
    entering = [t for t in tried if _enters(problem, t[1]) and _likely(problem, now, t[0])]
    if not entering:
        return []
    harmless = [t for t in entering if not _worse(problem, base, t[0])]
    best, fall = max(harmless or entering, key=lambda t: _per_number(_new(now, t[0]), t[1].gain))
    ties = tuple(_new(now, a) for a, _ in tried if a is not best and _tied(problem, best, a))
    return [Step(_new(now, best), attempt(problem, best.groups, best.fitted, LONG), fall, ties)]


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
        if all(_enters(problem, fall) for fall in (whole, *falls)):
            found.append((whole.gain, [Step(g, both, fall) for g, fall in zip(groups, falls, strict=True)]))
    return max(found, key=lambda item: item[0])[1] if found else []


def _tried(problem: Problem, now: Attempt, groups: Sequence[Group]) -> list[Tried]:
    """The leaders refitted: attempt and fall of the score, the largest first."""
    most = SHORT if problem.model.is_3dof else LONG

    def beside(group: Group) -> list[Tried]:
        try:
            trial = attempt(problem, (*now.groups, group), now.fitted, most)
        except np.linalg.LinAlgError:
            return []
        return [(trial, score_difference(problem, now.left_out, trial.left_out))]

    found = in_threads(problem.threads, beside, _leaders(problem, now, groups))
    return sorted(chain.from_iterable(found), key=lambda item: -item[1].gain)


def _leaders(problem: Problem, now: Attempt, groups: Sequence[Group]) -> list[Group]:
    """Groups of the largest fall of the score after one Gauss-Newton step, all from one linearisation; of a response
    model all groups."""
    rest = [g for g in groups if g.id not in {used.id for used in now.groups}]
    if not problem.model.is_3dof:
        return rest
    numbers = numbers_of(problem, [*now.groups, *rest])
    fitted = now.fitted
    normal, slope, blocks = normal_equations(problem, numbers, fitted.theta, fitted.own, fitted.sd)
    held = len(fitted.numbers)
    edges = held + np.cumsum([0, *(len(group.sd) for group in rest)])

    def gain(ends: tuple[int, int]) -> float:
        pick = np.array([*range(held), *range(*ends)])
        moved = stepped(fitted, [numbers[i] for i in pick], pick, (normal, slope, blocks))
        return score_difference(problem, now.left_out, leave_one_out(moved)).gain

    gains = in_threads(problem.threads, gain, pairwise(edges.tolist()))
    single = [_per_number(group, fall) for group, fall in zip(rest, gains, strict=True)]
    first = [*np.argsort(gains)[::-1][:REFITTED].tolist(), *np.argsort(single)[::-1][:FEW].tolist()]
    return [rest[i] for i in dict.fromkeys(first)]


def _per_number(group: Group, gain: float) -> float:
    return gain / len(group.sd)


def _enters(problem: Problem, fall: Fall) -> bool:
    least = LEAST * len(problem.state_places)
    errors = max(2.0, student_quantile(0.95, max(len(problem.runs) - 1, 1)))
    return fall.gain > max(least, errors * fall.error) and fall.free_gain > errors * fall.free_error


def _tied(problem: Problem, best: Attempt, other: Attempt) -> bool:
    """Whether the other's score is within one standard error of the best's, and it would enter on its own."""
    fall = score_difference(problem, other.left_out, best.left_out)
    return fall.gain < fall.error


def _new(now: Attempt, trial: Attempt) -> Group:
    return trial.groups[len(now.groups)]


def _without_idle(problem: Problem, final: Attempt, always: Sequence[Group] = ()) -> Attempt:
    """The attempt without groups that the others make needless: the one of the smallest fall per number leaves, as
    long as that does not matter."""
    while len(final.groups) > len(always) + 1:
        without = partial(_without, problem, final)
        trials = in_threads(problem.threads, without, final.groups[len(always) :])
        _, fall, trial = min(trials, key=lambda item: item[0])
        if _enters(problem, fall):
            return final
        final = trial
    return final


def _without(problem: Problem, final: Attempt, group: Group) -> tuple[float, Fall, Attempt]:
    """The attempt without a group: by how much the score falls with it, for each number and as a whole."""
    trial = attempt(problem, tuple(g for g in final.groups if g.id != group.id), None, LONG)
    fall = score_difference(problem, trial.left_out, final.left_out)
    return _per_number(group, fall.gain), fall, trial
