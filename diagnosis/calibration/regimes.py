"""A number that is wrong in a part of the runs only, where that predicts left-out records best.

The likelihood proposes numbers with a regime (`discrepancy.regimes`); free runs of records that were left out decide
between them, the same numbers without a regime, and the set that was chosen without.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...estimation.diagnosis_only.mixed_effects.left_out import score_difference
from ...estimation.diagnosis_only.mixed_effects.problem import LocalChange, Problem, pooled
from ...models.coefficient_groups import Group, parts_of
from ...models.extend import extended
from ...models.families.extensions import OFFSET, regime_parameters
from ...models.regimes import VARIABLES
from ..criteria.left_out import LEAST, LONG, Attempt, Selection, Step, attempt, enters
from ..selection.levels import TIE_NATS
from .result import StatedRegime

if TYPE_CHECKING:
    from ...models.model import Model
    from ..discrepancy.regimes import Local
    from .result import Moved

SURE, ROUGH = 2.0, 0.2
"""Standard deviations of the likelihood, and share of the size, that free runs may move it by: the likelihood is linear
in it."""


@dataclass(frozen=True)
class InRegime:
    """The choice with a number in a regime, and the share of the squared free-run error that it takes off left-out
    records, mean over the states."""

    local: Local
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
        number, where = self.local.number, self.local.regime.told(self.local.low, self.local.high)
        if number.name == OFFSET:
            return replace(moved, name=number.name, group=number.group, before=0.0, percent=None, where=where)
        one = next(iter(number.change.values())) if len(number.change) == 1 else 1.0
        low, high = sorted((one * (1.0 + moved.low), one * (1.0 + moved.high)))
        percent = 100.0 * moved.after
        after = one * (1.0 + moved.after)
        moved = replace(moved, name=number.name, group=number.group, where=where, percent=percent)
        return replace(moved, before=one, after=after, low=low, high=high, prior_sds=self.size / number.sd)

    def verdict(self, verdict: str, reason: str) -> tuple[str, str]:
        """The verdict and its reason with what the likelihood says: it tells a part of the runs from the others where
        free runs, which sum up all of a record, are hardly better."""
        where = self.local.regime.told(self.local.low, self.local.high)
        said = f"{reason}; what is wrong is so {where}, by the log likelihood of the innovations"
        return ("partly_named" if verdict == "unexplained" else verdict), said

    @property
    def stated(self) -> StatedRegime:
        """The regime as plain facts."""
        number, own = self.local.number, self.local.regime
        facts = number.name, number.group, own.variable, own.side, own.threshold, self.local.low, self.local.high
        return StatedRegime(*facts, VARIABLES[own.variable], self.share, self.local.lead)

    def extended(self, model: Model) -> Model:
        """The model with the number in the regime."""
        where = self.local.regime
        name = f"regime_{self.local.number.name}_{where.variable}_{where.side}"
        return extended(
            model, name, dict(zip(regime_parameters(name), (self.size, where.threshold, where.width), strict=True))
        )


def best_in_regime(
    problem: Problem, found: Selection, groups: Sequence[Group], proposed: Sequence[Local]
) -> InRegime | None:
    """The number in a regime that predicts left-out records best; None where the choice without does as well.

    Eq. 37 of docs/mathematics/default-route.md.
    """
    trials = [(local, _attempted(problem, groups, local)) for local in proposed]
    sound = [(local, trial) for local, trial in trials if trial is not None]
    if not sound:
        return None
    local, best = _smallest(problem, found, sound)
    if not _good(problem, found, best, local.alike):
        return None
    group, fall = best.groups[-1], score_difference(problem, found.base.left_out, best.left_out)
    rivals = [t.groups[-1] for other, t in sound if other.lead > local.lead - TIE_NATS and t is not best]
    ties = {g.of: g for g in rivals if g.of != group.of}
    steps = tuple(Step(g, best, fall, tuple(ties.values()) if g is group else ()) for g in best.groups)
    selection = Selection(found.base, steps, best, found.refused)
    return InRegime(local, best.fitted.problem, group, selection, _share(problem, found, best))


def _smallest(problem: Problem, found: Selection, sound: Sequence[tuple[Local, Attempt]]) -> tuple[Local, Attempt]:
    """Of those within one standard error of the best, or within LEAST of its score, the one of the fewest numbers, and
    of these the likeliest."""
    _, best = max(sound, key=lambda t: score_difference(problem, found.base.left_out, t[1].left_out).gain)
    falls = [score_difference(problem, trial.left_out, best.left_out) for _, trial in sound]
    least = LEAST * len(problem.state_places)
    alike = [t for t, fall in zip(sound, falls, strict=True) if fall.gain <= max(fall.error, least)]
    return min(alike, key=lambda t: (len(t[1].fitted.numbers), -t[0].lead))


def _attempted(problem: Problem, groups: Sequence[Group], local: Local) -> Attempt | None:
    """The numbers of a proposal fitted together; None where one of them cannot move."""
    alone = {name: g for g in (*groups, *(p for g in groups for p in parts_of(g))) if len(g.sd) == 1 for name in g.sd}
    number = local.number
    name = f"{number.name} in a regime"
    if not {*number.change} <= {*problem.names} or not {*local.beside} <= alone.keys():
        return None
    places = tuple((problem.names.index(n), c) for n, c in number.change.items())
    change = LocalChange(name, local.regime, places, local.size)
    sd = max(SURE * local.sd, ROUGH * abs(local.size))
    group = Group(name, number.title, None, {name: sd}, of=number.group)
    try:
        return attempt(replace(problem, local=change), (*(alone[n] for n in local.beside), group), None, LONG)
    except np.linalg.LinAlgError:
        return None


def _good(problem: Problem, found: Selection, trial: Attempt, sure: bool) -> bool:
    """Whether left-out records are predicted no worse than by the choice without a regime, but for chance; where the
    likelihood is not sure, since records differ, whether they are predicted better by all means."""
    fall = score_difference(problem, found.final.left_out, trial.left_out)
    return fall.gain > -fall.error if sure else enters(problem, fall)


def _share(problem: Problem, found: Selection, trial: Attempt) -> float:
    before, after = (pooled([x.free for x in a.left_out])[problem.state_places] ** 2 for a in (found.base, trial))
    return float(np.mean(1.0 - after / before))
