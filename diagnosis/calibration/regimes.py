"""A number that is wrong in a part of the runs only, where records that were left out confirm it.

Free runs of pieces propose it (`one_bank.regimes`); free runs of left-out records decide between it and the set that
was chosen without a regime.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...estimation.selection.selection import mean_squares
from ...models.coefficient_groups import Group
from ...models.families.extensions import OFFSET
from ..one_bank.regimes import place_in
from .group_fits import GroupFit, GroupStep, GroupSteps, fit_groups, score_fall, states_of, whole_and_parts
from .result import StatedRegime

if TYPE_CHECKING:
    from ...models.model import Model
    from ..free_runs.bank import Place
    from ..free_runs.problem import FreeRuns
    from ..one_bank.regimes import InRegime
    from ..one_bank.search import Choice
    from .result import Moved


@dataclass(frozen=True)
class Confirmation:
    """The choice with a number in a regime, the number and where it is wrong, and the share of the squared free-run
    error that it takes off left-out records, mean over the states."""

    local: InRegime
    group: Group
    selection: GroupSteps
    share: float

    @property
    def size(self) -> float:
        """Change of the number inside the regime: a share of it, rad of the neutral rudder angle."""
        return self.selection.final.fitted.value(self.local.size)

    def told(self, moved: Moved) -> Moved:
        """The number of the group as it is inside the regime."""
        number, where = self.local.number, self.local.words
        if number.name == OFFSET:
            return replace(moved, name=number.name, group=number.group, before=0.0, percent=None, where=where)
        one = next(iter(number.change.values())) if len(number.change) == 1 else 1.0
        low, high = sorted((one * (1.0 + moved.low), one * (1.0 + moved.high)))
        percent = 100.0 * moved.after
        after = one * (1.0 + moved.after)
        moved = replace(moved, name=number.name, group=number.group, where=where, percent=percent)
        return replace(moved, before=one, after=after, low=low, high=high, prior_sds=self.size / number.sd)

    @property
    def stated(self) -> StatedRegime:
        """The regime as plain facts."""
        return StatedRegime(**self.local.facts, share_of_error=self.share)

    def extended(self, model: Model) -> Model:
        """The model with the number in the regime."""
        return self.local.extended(model, self.size)


def confirmation(runs: FreeRuns, selection: GroupSteps, groups: Sequence[Group], choice: Choice) -> Confirmation | None:
    """The choice with the number in a regime that pieces name, None where they name none, or left-out records are
    predicted worse with it by more than chance.

    Eq. 5 of docs/mathematics/calibration.md.
    """
    local = None if choice.beside else choice.local
    trial = None if local is None else _attempted(runs, groups, choice, local)
    if local is None or trial is None:
        return None
    between = score_fall(runs, selection.final, trial)
    if between.gain < -between.error:
        return None
    by = score_fall(runs, selection.base, trial)
    with_it = GroupSteps(selection.base, tuple(GroupStep(g, trial, by) for g in trial.groups), trial)
    return Confirmation(local, trial.groups[-1], with_it, _share(runs, selection, trial))


def places_of(local: InRegime, model: Model) -> dict[str, Place]:
    """What a number in a regime moves in a model."""
    return {local.size: place_in(model, local.number, local.regime)}


def _attempted(runs: FreeRuns, groups: Sequence[Group], choice: Choice, local: InRegime) -> GroupFit | None:
    """The number in a regime fitted with the numbers of the model beside it; None where one of them cannot move."""
    alone = {name: g for g in whole_and_parts(groups).values() if len(g.sd) == 1 for name in g.sd}
    names = [n for c in choice.selection.candidates for n in c.names if choice.bank.places[n].kind == "model"]
    number, others = local.number, dict.fromkeys(name for name in names if name != local.size)
    if not {*number.change} <= runs.bank.values.keys() or not others.keys() <= alone.keys():
        return None
    group = Group(local.size, number.title, None, {local.size: number.sd}, of=number.group)
    changes = {name: choice.selection.final.value(name) for name in (*others, local.size)}
    try:
        along = runs.with_numbers(places_of(local, runs.model), {})
        return fit_groups(along, (*(alone[n] for n in others), group), None, changes)
    except np.linalg.LinAlgError:
        return None


def _share(runs: FreeRuns, selection: GroupSteps, trial: GroupFit) -> float:
    before, after = (states_of(runs, mean_squares(runs, a.blind)) for a in (selection.base, trial))
    return float(np.mean(1.0 - after / before))
