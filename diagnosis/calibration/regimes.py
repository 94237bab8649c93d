"""A number that is wrong in a part of the runs only, where records that were left out confirm it.

Free runs of pieces propose it (`one_bank.regimes`); free runs of left-out records decide between it and the set that
was chosen without a regime.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...estimation.selection.selection import mean_squares
from ...models.coefficient_groups import Group
from ...models.families.extensions import OFFSET
from ..one_bank.regimes import place_in
from .group_fits import GroupFit, GroupStep, GroupSteps, fit_groups, score_fall, whole_and_parts
from .result import StatedRegime
from .whole_records import states_of

if TYPE_CHECKING:
    from ...models.model import Model
    from ..free_runs.bank import Place
    from ..free_runs.problem import FreeRuns
    from ..one_bank.regimes import InRegime
    from .result import Moved


class Proposal(NamedTuple):
    """A number in a regime as pieces name it, and changes of the numbers beside it and of itself."""

    local: InRegime
    changes: dict[str, float]

    def places(self, model: Model) -> dict[str, Place]:
        """What the number moves in a model."""
        return {self.local.size: place_in(model, self.local.number, self.local.regime)}


@dataclass(frozen=True)
class Confirmation:
    """The choice with a number in a regime, and the share of the squared free-run error that it takes off left-out
    records, mean over the states."""

    proposal: Proposal
    group: Group
    selection: GroupSteps
    share: float

    @property
    def local(self) -> InRegime:
        """The number and where it is wrong."""
        return self.proposal.local

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


def confirmation(
    runs: FreeRuns, selection: GroupSteps, groups: Sequence[Group], proposal: Proposal | None
) -> Confirmation | None:
    """The choice with the proposed number, None where left-out records are predicted worse by more than chance.

    Eq. 5 of docs/mathematics/calibration.md.
    """
    trial = None if proposal is None else _attempted(runs, groups, proposal)
    if proposal is None or trial is None:
        return None
    between = score_fall(runs, selection.final, trial)
    if between.gain < -between.error:
        return None
    by = score_fall(runs, selection.base, trial)
    with_it = GroupSteps(selection.base, tuple(GroupStep(g, trial, by) for g in trial.groups), trial)
    return Confirmation(proposal, trial.groups[-1], with_it, _share(runs, selection, trial))


def _attempted(runs: FreeRuns, groups: Sequence[Group], proposal: Proposal) -> GroupFit | None:
    """The numbers of a proposal fitted together; None where one of them cannot move."""
    alone = {name: g for g in whole_and_parts(groups).values() if len(g.sd) == 1 for name in g.sd}
    local, number = proposal.local, proposal.local.number
    others = [name for name in proposal.changes if name != local.size]
    if not {*number.change} <= runs.bank.values.keys() or not {*others} <= alone.keys():
        return None
    group = Group(local.size, number.title, None, {local.size: number.sd}, of=number.group)
    try:
        along = runs.with_numbers(proposal.places(runs.model), {})
        return fit_groups(along, (*(alone[n] for n in others), group), None, proposal.changes)
    except np.linalg.LinAlgError:
        return None


def _share(runs: FreeRuns, selection: GroupSteps, trial: GroupFit) -> float:
    before, after = (states_of(runs, mean_squares(runs, a.blind)) for a in (selection.base, trial))
    return float(np.mean(1.0 - after / before))
