"""Groups of numbers that free runs of pieces name, fitted to whole records, and records predicted by fits without them.

Free runs of pieces choose (`one_bank.search`); free runs of records that were left out only judge: what entered last
is taken back as long as a state of these is predicted worse than by the base model.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...checks.statistics.tails import student_quantile
from ...estimation.diagnosis_only.mixed_effects.fit import Fitted, Number, fit
from ...estimation.diagnosis_only.mixed_effects.left_out import Fall, LeftOut, leave_one_out, score_difference
from ...estimation.diagnosis_only.mixed_effects.problem import Problem, pooled
from ...models.coefficient_groups import parts_of
from ..gain.guard import WORSE

if TYPE_CHECKING:
    from ...models.coefficient_groups import Group

SHORT, LONG = 4, 14
"""Gauss-Newton steps of a fit that only compares, and of one that is kept."""
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
    """One group that entered: the fit with it, by how much the score fell, and ids of groups that do as well."""

    group: Group
    attempt: Attempt
    fall: Fall
    tied_with: tuple[str, ...] = ()


@dataclass(frozen=True)
class Selection:
    """The base without any group, the steps in order, and the final attempt."""

    base: Attempt
    steps: tuple[Step, ...]
    final: Attempt


class NamedGroup(NamedTuple):
    """A group, or a part of one, that free runs of pieces name, and ids of the groups that do as well."""

    group: Group
    tied_with: tuple[str, ...] = ()


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
    changes: Mapping[str, float] = MappingProxyType({}),
) -> Attempt:
    """A fit of the groups from another one's values of their numbers; all others are the model's own.

    changes : number -> change from the model's own value, where the fit starts else.
    """
    numbers, theta = numbers_of(problem, groups), problem.theta.copy()
    own = None if start is None else start.own
    places = [n.place for n in numbers]
    theta[places] = theta[places] if start is None else start.theta[places]
    for n in numbers:
        if n.name in changes:
            theta[n.place] = n.mean + changes[n.name]
    fitted = fit(problem, numbers, theta, own, most)
    return Attempt(tuple(groups), fitted, leave_one_out(fitted))


def whole_and_parts(groups: Sequence[Group]) -> dict[str, Group]:
    """Id -> group, and each number of a group alone."""
    return {g.id: g for group in groups for g in (group, *parts_of(group))}


def on_whole_records(
    problem: Problem, base: Attempt, named: Sequence[NamedGroup], changes: Mapping[str, float]
) -> Selection:
    """The groups that pieces name, one after the other on whole records, where left-out records are predicted better by
    more than a standard error; those that entered last are taken back as long as a state of these is predicted worse
    than by the base, or a number is too far from what is known of it.

    base : without any group.  changes : number -> change by the fit to pieces, where the fits start: whole records have
        other minima, too.
    """
    now, steps = base, list[Step]()
    for group, tied in named:
        held = {name for g in now.groups for name in g.sd}
        if held & {*group.sd}:
            continue
        try:
            trial = attempt(problem, (*now.groups, group), now.fitted, LONG, changes)
        except np.linalg.LinAlgError:
            continue
        by = score_difference(problem, now.left_out, trial.left_out)
        if by.gain > by.error:
            steps.append(Step(group, trial, by, tied))
            now = trial
    while steps and (loses(problem, base, steps[-1].attempt) or not _likely(problem, steps[-1].attempt)):
        steps.pop()
    return Selection(base, tuple(steps), steps[-1].attempt if steps else base)


def common(base: Attempt, groups: Sequence[Group]) -> Sequence[Group]:
    """The groups without those of a trim where the records' own neutral rudder angles have no common sign beyond
    chance."""
    own = base.fitted.own[:, 0]
    spread = float(np.std(own, ddof=1)) / np.sqrt(own.size) if own.size > 1 else np.inf
    alike = abs(float(np.mean(own))) > student_quantile(COMMON, max(own.size - 1, 1)) * spread
    return groups if alike else [g for g in groups if g.extension not in TRIM]


def loses(problem: Problem, base: Attempt, trial: Attempt) -> bool:
    """Whether some state of left-out records is predicted worse than by the base."""
    old, new = (pooled([x.free for x in a.left_out])[problem.state_places] for a in (base, trial))
    return bool(np.any(new > WORSE * old))


def _likely(problem: Problem, trial: Attempt) -> bool:
    """Whether no number is further from what is known of it than FARTHEST."""
    pairs = zip(trial.fitted.values, trial.fitted.numbers, strict=True)
    return not problem.model.is_3dof or all(abs(value - n.mean) <= FARTHEST * n.sd for value, n in pairs)
