"""Forward selection of groups of numbers by free runs of records that were left out.

A group enters if the score of the left-out records falls by more than LEAST, and by more than two jackknife standard
errors over records; groups whose scores cannot be distinguished from the best are ties.  At the end groups whose
removal costs less than that leave again.  Nothing enters where the base's own free runs are as good as needed: then a
significant fall is that of a difference without importance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import chain, combinations, pairwise
from typing import TYPE_CHECKING

import numpy as np

from ...estimation.mixed_effects.fit import Fitted, Number, fit, normal_equations, stepped
from ...estimation.mixed_effects.left_out import LeftOut, leave_one_out, score_difference
from ...estimation.mixed_effects.problem import Problem, pooled
from ...estimation.threads import in_threads

if TYPE_CHECKING:
    from ...models.coefficient_groups import Group

LEAST = 0.05
"""Fall of the score (half a log squared error, summed over channels) below which a group does not matter."""
REFITTED = 4
"""Groups of the largest predicted gain that are refitted in each step."""
SHORT, LONG = 4, 14
"""Gauss-Newton steps of a candidate and of what is kept; a response model costs so little that both take LONG."""
MOST = 6
ADEQUATE = 0.05
"""Share of a channel's own motion below which its free-run error is no matter."""


@dataclass(frozen=True)
class Attempt:
    """Groups fitted together, and the records predicted by fits that left them out."""

    groups: tuple[Group, ...]
    fitted: Fitted
    left_out: tuple[LeftOut, ...]


@dataclass(frozen=True)
class Step:
    """One group that entered: the fit with it, by how much the score fell with its standard error, and its ties."""

    group: Group
    attempt: Attempt
    gain: float
    standard_error: float
    tied_with: tuple[Group, ...] = ()


@dataclass(frozen=True)
class Selection:
    """The base without any group, the steps in order, the final attempt, and what the last step refused."""

    base: Attempt
    steps: tuple[Step, ...]
    final: Attempt
    refused: tuple[tuple[Group, float, float], ...] = field(default=())


Tried = tuple[Attempt, float, float]
"""An attempt with the fall of the score and its standard error."""


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
    refused: tuple[tuple[Group, float, float], ...] = ()
    if free is not None:
        now = attempt(problem, (free,), None, LONG)
        gain, error = score_difference(problem, base.left_out, now.left_out)
        steps += [Step(free, now, gain, error)] if _enters(gain, error) else []
    while len(steps) < most:
        tried = _tried(problem, now, groups)
        entered = _single(problem, now, tried) or _pair(problem, now, tried)
        if not entered:
            refused = tuple((_new(now, a), gain, error) for a, gain, error in tried)
            break
        steps += entered
        now = entered[-1].attempt
    final = _without_idle(problem, now, () if free is None else (free,))
    if not steps or (free is not None and not _enters(*score_difference(problem, base.left_out, final.left_out))):
        return Selection(base, (), base, refused)
    kept_ids = {group.id for group in final.groups}
    return Selection(base, tuple(step for step in steps if step.group.id in kept_ids), final, refused)


def _needed(problem: Problem, base: Attempt) -> bool:
    """Whether a state's free runs are further from the motion than ADEQUATE; the measurement noise is no error."""
    square = pooled([x.free for x in base.left_out]) ** 2 - problem.noise_variance
    return bool(np.any(square[problem.state_places] > (ADEQUATE * problem.motion) ** 2))


def _single(problem: Problem, now: Attempt, tried: Sequence[Tried]) -> list[Step]:
    """The step of the best group, none where it does not enter."""
    if not tried or not _enters(tried[0][1], tried[0][2]):
        return []
    best, gain, error = tried[0]
    ties = tuple(_new(now, a) for a, _, _ in tried[1:] if _tied(problem, best, a))
    return [Step(_new(now, best), attempt(problem, best.groups, best.fitted, LONG), gain, error, ties)]


def _pair(problem: Problem, now: Attempt, tried: Sequence[Tried]) -> list[Step]:
    """The steps of two groups of a response model that enter together only, each needed beside the other: what one of
    them leaves may hide what the other takes off."""
    if problem.model.is_3dof:
        return []
    found: list[tuple[float, list[Step]]] = []
    for (one, _, _), (other, _, _) in combinations(tried, 2):
        groups = _new(now, one), _new(now, other)
        try:
            both = attempt(problem, (*one.groups, groups[1]), one.fitted, LONG)
        except np.linalg.LinAlgError:
            continue
        gains = [score_difference(problem, alone.left_out, both.left_out) for alone in (other, one)]
        whole, error = score_difference(problem, now.left_out, both.left_out)
        if _enters(whole, error) and all(_enters(*gain) for gain in gains):
            found.append((whole, [Step(g, both, *gain) for g, gain in zip(groups, gains, strict=True)]))
    return max(found, key=lambda item: item[0])[1] if found else []


def _tried(problem: Problem, now: Attempt, groups: Sequence[Group]) -> list[Tried]:
    """The leaders refitted: attempt, gain and its standard error, the largest gain first."""
    most = SHORT if problem.model.is_3dof else LONG

    def beside(group: Group) -> list[Tried]:
        try:
            trial = attempt(problem, (*now.groups, group), now.fitted, most)
        except np.linalg.LinAlgError:
            return []
        return [(trial, *score_difference(problem, now.left_out, trial.left_out))]

    found = in_threads(problem.threads, beside, _leaders(problem, now, groups))
    return sorted(chain.from_iterable(found), key=lambda item: -item[1])


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
        return score_difference(problem, now.left_out, leave_one_out(moved))[0]

    gains = in_threads(problem.threads, gain, pairwise(edges.tolist()))
    return [rest[i] for i in np.argsort(gains)[::-1][:REFITTED]]


def _enters(gain: float, error: float) -> bool:
    return gain > max(LEAST, 2.0 * error)


def _tied(problem: Problem, best: Attempt, other: Attempt) -> bool:
    """Whether the other's score is within one standard error of the best's, and it would enter on its own."""
    difference, error = score_difference(problem, other.left_out, best.left_out)
    return difference < error


def _new(now: Attempt, trial: Attempt) -> Group:
    return trial.groups[len(now.groups)]


def _without_idle(problem: Problem, final: Attempt, always: Sequence[Group] = ()) -> Attempt:
    """The attempt without groups that the others make needless."""
    while len(final.groups) > len(always) + 1:
        trials = []
        for group in final.groups[len(always) : -1]:
            rest = tuple(g for g in final.groups if g.id != group.id)
            trial = attempt(problem, rest, None, LONG)
            gain, error = score_difference(problem, trial.left_out, final.left_out)
            trials.append((gain, error, trial))
        gain, error, trial = min(trials, key=lambda item: item[0])
        if _enters(gain, error):
            return final
        final = trial
    return final
