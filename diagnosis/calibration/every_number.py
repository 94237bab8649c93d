"""The model that predicts best: all numbers that groups state, moved under priors whose scale left-out records choose.

Naming is sparse, predicting is not: what is wrong is told by the smallest set of numbers, and many small corrections
beside it still make other records better.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...estimation.diagnosis_only.mixed_effects.fit import expansions_of
from ...estimation.diagnosis_only.mixed_effects.left_out import predicted, score_difference
from .attempts import LONG, Attempt, Selection, attempt, common, loses, numbers_of

if TYPE_CHECKING:
    from ...estimation.diagnosis_only.mixed_effects.problem import Problem
    from ...models.coefficient_groups import Group

SHARES = (0.05, 0.1, 0.2, 0.4, 0.8)
"""Scales of the priors that are tried, as shares of those stated; the numbers that are named keep theirs."""


def every_number(problem: Problem, groups: Sequence[Group], found: Selection) -> Attempt:
    """The fit of all numbers of the groups, or the named set where that predicts left-out records better.

    Eq. 12 of docs/mathematics/calibration.md.
    """
    chosen = found.final
    named = {n.name: n.sd for n in chosen.fitted.numbers}
    scaled = [_scaled(common(found.base, groups), named, share) for share in SHARES]
    numbers = [numbers_of(problem, of) for of in scaled]
    if not numbers[0] or len(numbers[0]) <= len(named):
        return chosen
    expansions = expansions_of(problem, numbers[0], chosen.fitted.theta, chosen.fitted.own)
    places = np.arange(len(numbers[0]))
    falls = [
        score_difference(problem, chosen.left_out, predicted(chosen.fitted, expansions, each, places))
        for each in numbers
    ]
    best = max(falls, key=lambda fall: fall.gain)
    least = next(i for i, fall in enumerate(falls) if fall.gain >= best.gain - best.error)
    try:
        trial = attempt(problem, scaled[least], chosen.fitted, LONG)
    except np.linalg.LinAlgError:
        return chosen
    gained = score_difference(problem, chosen.left_out, trial.left_out).gain > 0.0
    return trial if gained and not loses(problem, found.base, trial) else chosen


def _scaled(groups: Sequence[Group], named: dict[str, float], share: float) -> list[Group]:
    """The groups with priors at a share of what they state; a number stands in the first group that holds it."""
    out, held = [], set[str]()
    for group in groups:
        sd = {name: named.get(name, share * own) for name, own in group.sd.items() if name not in held}
        held |= sd.keys()
        out += [replace(group, sd=sd)] if sd else []
    return out
