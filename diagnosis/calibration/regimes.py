"""A number that is wrong in a part of the runs only, where records that were left out confirm it.

Free runs of pieces propose it (`one_bank.regimes`); free runs of left-out records decide between it and the set that
was chosen without a regime.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...estimation.diagnosis_only.mixed_effects.left_out import score_difference
from ...estimation.diagnosis_only.mixed_effects.problem import LocalChange, Problem, pooled
from ...models.coefficient_groups import Group
from ...models.families.extensions import OFFSET
from .attempts import LONG, Attempt, Selection, Step, attempt, whole_and_parts
from .result import StatedRegime

if TYPE_CHECKING:
    from ...models.model import Model
    from ..one_bank.regimes import InRegime
    from .result import Moved

SURE, ROUGH = 2.0, 0.2
"""Standard deviations of the fit of pieces, and share of the size, that free runs of records may move it by."""


class Proposal(NamedTuple):
    """A number in a regime as pieces name it: its size there with the standard deviation, and names of the numbers
    beside it."""

    local: InRegime
    size: float
    sd: float
    beside: tuple[str, ...]


@dataclass(frozen=True)
class Confirmation:
    """The choice with a number in a regime, and the share of the squared free-run error that it takes off left-out
    records, mean over the states."""

    local: InRegime
    problem: Problem
    group: Group
    selection: Selection
    share: float

    @property
    def size(self) -> float:
        """Change of the number inside the regime: a share of it, rad of the neutral rudder angle."""
        return float(self.selection.final.fitted.theta[-1])

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
    problem: Problem, found: Selection, groups: Sequence[Group], proposal: Proposal | None
) -> Confirmation | None:
    """The choice with the proposed number, None where left-out records are predicted worse by more than chance.

    Eq. 11 of docs/mathematics/calibration.md.
    """
    trial = None if proposal is None else _attempted(problem, groups, proposal)
    if proposal is None or trial is None:
        return None
    between = score_difference(problem, found.final.left_out, trial.left_out)
    if between.gain < -between.error:
        return None
    fall = score_difference(problem, found.base.left_out, trial.left_out)
    selection = Selection(found.base, tuple(Step(g, trial, fall) for g in trial.groups), trial)
    group, share = trial.groups[-1], _share(problem, found, trial)
    return Confirmation(proposal.local, trial.fitted.problem, group, selection, share)


def _attempted(problem: Problem, groups: Sequence[Group], proposal: Proposal) -> Attempt | None:
    """The numbers of a proposal fitted together; None where one of them cannot move."""
    alone = {name: g for g in whole_and_parts(groups).values() if len(g.sd) == 1 for name in g.sd}
    local, number = proposal.local, proposal.local.number
    name = f"{number.name} in a regime"
    if not {*number.change} <= {*problem.names} or not {*proposal.beside} <= alone.keys():
        return None
    places = tuple((problem.names.index(n), c) for n, c in number.change.items())
    change = LocalChange(name, local.regime, places, proposal.size)
    sd = max(SURE * proposal.sd, ROUGH * abs(proposal.size))
    group = Group(name, number.title, None, {name: sd}, of=number.group)
    try:
        return attempt(replace(problem, local=change), (*(alone[n] for n in proposal.beside), group), None, LONG)
    except np.linalg.LinAlgError:
        return None


def _share(problem: Problem, found: Selection, trial: Attempt) -> float:
    before, after = (pooled([x.free for x in a.left_out])[problem.state_places] ** 2 for a in (found.base, trial))
    return float(np.mean(1.0 - after / before))
