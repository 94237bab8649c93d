"""Training and held-out records, whole, with a model whose numbers move; groups of numbers fitted to them, and what is
judged by that.  The errors of free runs are the same as of every command.

Free runs of pieces choose (`one_bank.search`); free runs of records that were left out only judge: what entered last
is taken back as long as a state of these is predicted worse than by the base model.

Naming is sparse, predicting is not: what is wrong is told by the smallest set of numbers, and many small corrections
beside it still make other records better (`every_number`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...checks.tails import student_quantile
from ...estimation.run.run import run_along, squares_of
from ...estimation.run.stretch import Stretch
from ...estimation.selection.minimiser import STEPS, Fitted, minimise
from ...estimation.selection.number import distinct
from ...estimation.selection.score import Fall, fall
from ...estimation.selection.selection import floor_squares, mean_squares
from ...models.coefficient_groups import parts_of
from ...models.time_scale import time_scale_s
from ..free_runs.bank import Place, numbers_of, of_numbers
from ..free_runs.problem import FreeRuns
from ..free_runs.units import units_of, whole_unit
from ..gain.guard import WORSE

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...estimation.run.run import Run
    from ...estimation.run.stretch import FreeRun
    from ...models.coefficient_groups import Group
    from ...models.model import Model
    from ..prepared import Prepared


class WholeRecords(NamedTuple):
    """Free runs of training and held-out records."""

    train: FreeRuns
    held_out: FreeRuns | None

    def with_numbers(self, places: Mapping[str, Place]) -> WholeRecords:
        """The same with further numbers, and what these move."""
        held_out = None if self.held_out is None else self.held_out.with_numbers(places, {})
        return WholeRecords(self.train.with_numbers(places, {}), held_out)

    def with_inputs(self, change: Callable[[np.ndarray], np.ndarray]) -> WholeRecords:
        """The same with the inputs (M + 1, nu) of every run changed."""

        def changed(runs: FreeRuns) -> FreeRuns:
            stretches = [u.stretch for u in runs.units]
            series = [replace(s.series, inputs=change(s.series.inputs)) for s in stretches]
            parts = zip(runs.units, stretches, series, strict=True)
            return runs.along([replace(u, stretch=replace(s, series=own)) for u, s, own in parts])

        return WholeRecords(changed(self.train), None if self.held_out is None else changed(self.held_out))


def whole_records(model: Model, records: Prepared) -> WholeRecords:
    """The records of a calibration; those of training are cut into pieces where they are few.

    Raises
    ------
    CannotFit : a record lacks what free runs need, or the records are too short to leave a part out.
    """
    bank, length_s = of_numbers(model), time_scale_s(model)
    train = FreeRuns(bank, units_of(model, records.train, length_s, whole=True), length_s, whole=True)
    held_out = [replace(whole_unit(model, r, length_s), number=i) for i, r in enumerate(records.held_out)]
    return WholeRecords(train, FreeRuns(bank, held_out, length_s, whole=True) if held_out else None)


def blind_errors(runs: FreeRuns, values: Mapping[str, float]) -> dict[str, float]:
    """Column -> root mean square error at values of the numbers, without own effects of the records."""
    return root_mean_squares(runs, runs.squares([values] * len(runs.units), runs.no_own))


def root_mean_squares(runs: FreeRuns, squares: np.ndarray) -> dict[str, float]:
    """Column -> root mean square error from sums of squares (K, C)."""
    return dict(zip(runs.channels, np.sqrt(mean_squares(runs, squares)).tolist(), strict=True))


def states_of(runs: FreeRuns, values: np.ndarray) -> np.ndarray:
    """Of values (C,) by channel those of the states."""
    return values[: len(runs.symbols)]


def columns_of_states(runs: FreeRuns) -> Sequence[str]:
    """Columns of the states that count."""
    return runs.channels[: len(runs.symbols)]


Errors = Mapping[str, tuple[float, float | None]]
"""Column -> errors of left-out training records and of held-out records, SI."""


class HeldOut(NamedTuple):
    """Held-out records as they were read, and with the current and wind that known causes add to what they measure."""

    recorded: Sequence[Record]
    explained: Sequence[Record]


def runs_along(
    model: Model, records: Sequence[Record], by: Callable[[Stretch], FreeRun] = Stretch.free_run
) -> list[Run]:
    """Runs of a model along records; by as `run_along` has it."""
    return [run_along(model, record, by=by) for record in records]


def with_held_out(errors: Errors, runs: Sequence[Run]) -> Errors:
    """Errors with those of the runs in the place of held-out ones, in the columns that the runs have."""
    by_column = {column: sums.scores()[0] for column, sums in squares_of(runs).items()}
    return {column: (own, by_column.get(column, held)) for column, (own, held) in errors.items()}


SHORT = 4
"""Gauss-Newton steps of a fit that only compares."""
TRIM = ("asymmetry", "rudder_offset")
"""Extensions that act on a straight course, as the trim of a single record does."""
COMMON = 0.99
"""Probability of Student's t at which the records' own neutral rudder angles count as the ship's: a trim that differs
between records, as that of wind does, is no property of her."""
FARTHEST = 4.0
"""Prior standard deviations by which a number of a 3-DOF model is off at most."""


@dataclass(frozen=True)
class GroupFit:
    """Groups fitted together; the records predicted by fits that left them out, without own effects of theirs.

    blind : sums of squared errors (K, C) of such runs; those with own effects are `fitted.left_out`.
    """

    groups: tuple[Group, ...]
    fitted: Fitted
    blind: np.ndarray


@dataclass(frozen=True)
class GroupStep:
    """One group that entered: the fit with it, by how much the score fell, and ids of groups that do as well."""

    group: Group
    fit: GroupFit
    fall: Fall
    tied_with: tuple[str, ...] = ()


@dataclass(frozen=True)
class GroupSteps:
    """The base without any group, the steps in order, and the final fit."""

    base: GroupFit
    steps: tuple[GroupStep, ...]
    final: GroupFit


class NamedGroup(NamedTuple):
    """A group, or a part of one, that free runs of pieces name, and ids of the groups that do as well."""

    group: Group
    tied_with: tuple[str, ...] = ()


def fit_groups(
    runs: FreeRuns,
    groups: Sequence[Group],
    start: Fitted | None = None,
    changes: Mapping[str, float] = MappingProxyType({}),
    steps: int = STEPS,
) -> GroupFit:
    """A fit of the groups from another one's values of their numbers; all others are the model's own.

    changes : number -> change from the model's own value, where the fit starts else.
    """
    numbers = distinct(n for group in groups for n in numbers_of(group, runs.bank.values))
    values = {n.name: changes.get(n.name, 0.0 if start is None else start.value(n.name)) for n in numbers}
    own = runs.no_own if start is None else start.point.own
    fitted = minimise(runs, numbers, values, own, steps)
    return GroupFit(tuple(groups), fitted, runs.squares(fitted.without, runs.no_own))


def errors_of(on: WholeRecords, fit: GroupFit) -> dict[str, tuple[float, float | None]]:
    """Column -> errors of left-out training records and of held-out records."""
    own = root_mean_squares(on.train, fit.blind)
    held = {} if on.held_out is None else blind_errors(on.held_out, fit.fitted.point.values)
    return {column: (value, held.get(column)) for column, value in own.items()}


def score_fall(runs: FreeRuns, old: GroupFit, new: GroupFit) -> Fall:
    """By how much the mean of two scores of left-out records falls: with own effects, which keep the trim of single
    runs from hiding what a number gains, and without, as a user's simulation runs.

    Eq. 2 of docs/mathematics/calibration.md.
    """
    floor = floor_squares(runs)
    before, after = (np.concatenate([one.fitted.left_out, one.blind], axis=1) for one in (old, new))
    by = fall(before, after, np.concatenate([floor, floor], axis=1))
    return Fall(0.5 * by.gain, 0.5 * by.error)


def whole_and_parts(groups: Sequence[Group]) -> dict[str, Group]:
    """Id -> group, and each number of a group alone."""
    return {g.id: g for group in groups for g in (group, *parts_of(group))}


def on_whole_records(
    runs: FreeRuns, base: GroupFit, names: Sequence[NamedGroup], changes: Mapping[str, float]
) -> GroupSteps:
    """The groups that pieces name, one after the other on whole records, where left-out records are predicted better by
    more than a standard error; those that entered last are taken back as long as a state of these is predicted worse
    than by the base, or a number is too far from what is known of it.

    base : without any group.  changes : number -> change by the fit to pieces, where the fits start: whole records have
        other minima, too.
    """
    now, steps = base, list[GroupStep]()
    for group, tied in names:
        held = {name for g in now.groups for name in g.sd}
        if held & {*group.sd}:
            continue
        try:
            trial = fit_groups(runs, (*now.groups, group), now.fitted, changes)
        except np.linalg.LinAlgError:
            continue
        by = score_fall(runs, now, trial)
        if by.gain > by.error:
            steps.append(GroupStep(group, trial, by, tied))
            now = trial
    while steps and (loses(runs, base, steps[-1].fit) or not _likely(runs, steps[-1].fit)):
        steps.pop()
    return GroupSteps(base, tuple(steps), steps[-1].fit if steps else base)


def common(base: GroupFit, groups: Sequence[Group]) -> Sequence[Group]:
    """The groups without those of a trim where the records' own neutral rudder angles have no common sign beyond
    chance."""
    own = base.fitted.point.own[:, 0]
    spread = float(np.std(own, ddof=1)) / np.sqrt(own.size) if own.size > 1 else np.inf
    alike = abs(float(np.mean(own))) > student_quantile(COMMON, max(own.size - 1, 1)) * spread
    return groups if alike else [g for g in groups if g.extension not in TRIM]


def loses(runs: FreeRuns, base: GroupFit, trial: GroupFit) -> bool:
    """Whether some state of left-out records is predicted worse than by the base."""
    old, new = (states_of(runs, np.sqrt(mean_squares(runs, a.blind))) for a in (base, trial))
    return bool(np.any(new > WORSE * old))


def _likely(runs: FreeRuns, trial: GroupFit) -> bool:
    """Whether no number is further from what is known of it than FARTHEST, by more than a standard error."""
    fitted = trial.fitted
    near = (abs(fitted.value(n.name)) - s <= FARTHEST * n.sd for n, s in zip(fitted.numbers, fitted.sd, strict=True))
    return not runs.model.is_3dof or all(near)


SHARES = (0.05, 0.1, 0.2, 0.4, 0.8)
"""Scales of the priors that are tried, as shares of those stated; the numbers that are named keep theirs."""


def every_number(runs: FreeRuns, groups: Sequence[Group], selection: GroupSteps) -> GroupFit:
    """The fit of all numbers of the groups, or the named set where that predicts left-out records better.

    Eq. 6 of docs/mathematics/calibration.md.
    """
    chosen = selection.final
    stated = {n.name: n.sd for n in chosen.fitted.numbers}
    free = common(selection.base, groups)
    if not {name for g in free for name in g.sd} - stated.keys():
        return chosen
    trials = []
    with suppress(np.linalg.LinAlgError):
        for share in SHARES:
            start = trials[-1] if trials else chosen
            trials.append(fit_groups(runs, _scaled(free, stated, share), start.fitted, steps=SHORT))
    if not trials:
        return chosen
    falls = [score_fall(runs, chosen, trial) for trial in trials]
    best = max(falls, key=lambda by: by.gain)
    least = next(i for i, by in enumerate(falls) if by.gain >= best.gain - best.error)
    try:
        trial = fit_groups(runs, trials[least].groups, trials[least].fitted)
    except np.linalg.LinAlgError:
        return chosen
    gained = score_fall(runs, chosen, trial).gain > 0.0
    return trial if gained and not loses(runs, selection.base, trial) else chosen


def _scaled(groups: Sequence[Group], stated: dict[str, float], share: float) -> list[Group]:
    """The groups with priors at a share of what they state; a number stands in the first group that holds it."""
    out, held = [], set[str]()
    for group in groups:
        sd = {name: stated.get(name, share * own) for name, own in group.sd.items() if name not in held}
        held |= sd.keys()
        out += [replace(group, sd=sd)] if sd else []
    return out
