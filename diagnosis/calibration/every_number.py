"""The model that predicts best: all numbers that groups state, moved under priors whose scale left-out records choose.

Naming is sparse, predicting is not: what is wrong is told by the smallest set of numbers, and many small corrections
beside it still make other records better.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from .attempts import SHORT, Attempt, Selection, attempt, common, loses, score_fall

if TYPE_CHECKING:
    from ...models.coefficient_groups import Group
    from ..free_runs.problem import FreeRuns

SHARES = (0.05, 0.1, 0.2, 0.4, 0.8)
"""Scales of the priors that are tried, as shares of those stated; the numbers that are named keep theirs."""


def every_number(runs: FreeRuns, groups: Sequence[Group], selection: Selection) -> Attempt:
    """The fit of all numbers of the groups, or the named set where that predicts left-out records better.

    Eq. 6 of docs/mathematics/calibration.md.
    """
    chosen = selection.final
    named = {n.name: n.sd for n in chosen.fitted.numbers}
    free = common(selection.base, groups)
    if not {name for g in free for name in g.sd} - named.keys():
        return chosen
    trials = []
    with suppress(np.linalg.LinAlgError):
        for share in SHARES:
            start = trials[-1] if trials else chosen
            trials.append(attempt(runs, _scaled(free, named, share), start.fitted, steps=SHORT))
    if not trials:
        return chosen
    falls = [score_fall(runs, chosen, trial) for trial in trials]
    best = max(falls, key=lambda by: by.gain)
    least = next(i for i, by in enumerate(falls) if by.gain >= best.gain - best.error)
    try:
        trial = attempt(runs, trials[least].groups, trials[least].fitted)
    except np.linalg.LinAlgError:
        return chosen
    gained = score_fall(runs, chosen, trial).gain > 0.0
    return trial if gained and not loses(runs, selection.base, trial) else chosen


def _scaled(groups: Sequence[Group], named: dict[str, float], share: float) -> list[Group]:
    """The groups with priors at a share of what they state; a number stands in the first group that holds it."""
    out, held = [], set[str]()
    for group in groups:
        sd = {name: named.get(name, share * own) for name, own in group.sd.items() if name not in held}
        held |= sd.keys()
        out += [replace(group, sd=sd)] if sd else []
    return out
