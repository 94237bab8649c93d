"""The choice: few candidates alone, or faults of input and sensors beside the model's own numbers under their priors.

A base model is exact or not.  Where it is not known to be, all its own numbers are also tried as random effects: free
under their priors in every fit.  They stay where left-out pieces are predicted clearly better with them than by the
few numbers that explain the records alone.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...estimation.selection.minimiser import minimise
from ...estimation.selection.selection import Rules, Selection, clearly_worse, mean_squares, select
from ..causes.base import Cause
from ..causes.registry import causes
from .bank import FLOWS, INPUT
from .units import REFERENCE_S

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ...estimation.selection.number import Candidate
    from ...estimation.selection.selection import Entered
    from ..options import Options
    from .bank import Bank
    from .free_runs import FreeRuns

EXACT = Rules(least=0.004, level=0.999)
"""Of a base model that is known to be exact: what is sure counts, however little it matters."""
MATTERS, BESIDE = (0.05, 0.99), (0.005, 0.999)
"""Least fall of the score for each channel, and level: of few numbers alone, and beside the model's own numbers."""
ENOUGH = 0.05
"""Error of left-out pieces, as a share of the motion, that is no matter where the base model may be inexact."""


@dataclass(frozen=True)
class Choice:
    """What was selected, and whether it is beside the model's own numbers."""

    runs: FreeRuns
    selection: Selection
    beside: bool = False

    @property
    def bank(self) -> Bank:
        """All candidates."""
        return self.runs.bank

    @property
    def explains(self) -> bool:
        """Whether left-out pieces are predicted as well as matters with what was selected."""
        return not _left_to_explain(self.runs, self.selection)


def withdrawn(choice: Choice) -> Choice | None:
    """The choice without what entered last, else without the model's own numbers; None where there is nothing left."""
    runs, selection = choice.runs, choice.selection
    if not selection.entered:
        return Choice(runs, Selection(selection.base, (), selection.base)) if choice.beside else None
    return _without(choice, selection.entered[-1])


def _without(choice: Choice, one: Entered) -> Choice:
    """The choice without a candidate, all others fitted again."""
    runs, selection = choice.runs, choice.selection
    kept = tuple(e for e in selection.entered if e is not one)
    every = [*(runs.bank.own if choice.beside else ()), *(n for one in kept for n in one.candidate.numbers)]
    numbers = tuple({n.name: replace(n, trial=None) for n in every}.values())
    point = selection.final.point
    values = {n.name: point.values.get(n.name, 0.0) for n in numbers}
    return replace(choice, selection=Selection(selection.base, kept, minimise(runs, numbers, values, point.own)))


def chosen(runs: FreeRuns, options: Options) -> Choice:
    """The choice for records, without faults of input and sensors whose sizes are below what matters."""
    choice = _chosen(runs, options)
    while small := [one for one in choice.selection.entered if not _matters(choice, one)]:
        choice = _without(choice, small[-1])
    return choice


def _matters(choice: Choice, one: Entered) -> bool:
    """Whether the size of a candidate is above the least of its cause that matters."""
    cause, runs = causes().get(choice.bank.cause_of(one.candidate)), choice.runs
    smallest = cause.smallest if isinstance(cause, Cause) and one.candidate.rank == INPUT else None
    if cause is None or smallest is None:
        return True
    unit, values = (
        cause.unit.partition(",")[0],
        np.array([choice.selection.final.value(n) for n in one.candidate.names]),
    )
    if unit in ("s", "m/s"):
        smallest *= runs.length_s / REFERENCE_S
    if unit == "s":
        smallest = max(smallest, 0.5 * runs.units[0].stretch.series.dt)
    sizes = np.hypot(*values.reshape(-1, 2).T) if cause.id in FLOWS else np.abs(values)
    return bool(np.max(sizes) > smallest)


def _chosen(runs: FreeRuns, options: Options) -> Choice:
    bank = runs.bank
    candidates = bank.candidates
    base = minimise(runs, (), {}, runs.no_own)
    if options.base_parameters == "identify":
        return _of_identified(runs, candidates)
    if options.coefficient_sd == 0.0:
        return Choice(runs, select(runs, candidates, EXACT, base))
    least, level = MATTERS
    alone = select(runs, candidates, Rules(least, level, np.maximum(ENOUGH * runs.motion, runs.floor)), base)
    if not bank.own or not _left_to_explain(runs, alone):
        return Choice(runs, alone)
    whole = minimise(runs, bank.own, {}, base.point.own)
    if len(alone.entered) < 2 and clearly_worse(runs, whole, alone.final, least):
        return Choice(runs, alone)
    inputs = [c for c in candidates if c.rank == INPUT]
    beside = select(runs, inputs, Rules(*BESIDE), whole, bank.own)
    better = clearly_worse(runs, alone.final, beside.final, least)
    return Choice(runs, replace(beside, base=base), beside=True) if better else Choice(runs, alone)


def _of_identified(runs: FreeRuns, candidates: Sequence[Candidate]) -> Choice:
    """The choice beside a model's own numbers that come from these records, and are hardly restricted."""
    names = {n.name for n in runs.bank.own}
    others = [c for c in candidates if not names & {*c.names}]
    whole = minimise(runs, runs.bank.own, {}, runs.no_own)
    return Choice(runs, select(runs, others, Rules(*BESIDE), whole, runs.bank.own), beside=True)


def _left_to_explain(runs: FreeRuns, selection: Selection) -> bool:
    """Whether errors of left-out pieces are left that matter where the base model may be inexact."""
    mean = mean_squares(runs, selection.final.left_out)
    return bool(np.any(np.sqrt(mean) > np.maximum(ENOUGH * runs.motion, runs.floor)))
