"""Which forces along the measured motion describe what remains: beside the base model alone, or beside its own numbers.

Forces have a higher bar than causes, and one that begins and ends has the times at which left-out pieces are predicted
best.  Section 8 of docs/mathematics/pieces.md.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...estimation.selection.minimiser import minimise
from ...estimation.selection.number import distinct
from ...estimation.selection.score import score
from ...estimation.selection.selection import (
    CLEAR,
    EVIDENT,
    Entered,
    Rules,
    Selection,
    clearly_worse,
    fall_between,
    floor_squares,
    independent,
    is_enough,
    select,
    with_only,
)
from .diagnose import runs_of
from .events import common_spans
from .forces import STEADY, Force, Forces, forces_along, with_force, with_spans
from .search import half_intervals

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...estimation.selection.minimiser import Fitted
    from ...estimation.selection.number import Candidate, Number
    from ...models.model import Model
    from ..free_runs.problem import FreeRuns
    from ..options import Options
    from .forces import Shape

RULES = Rules(least=0.02, level=0.9995, most=3, leaders=6, of_each=1)
FAINT = replace(RULES, least=0.004, most=1, evident=RULES.level)
"""Forces have a higher bar than causes: hundreds are tried, and gusts are none.  Where no errors are left that matter,
one is looked for, which the pieces have to show together: a likelihood ratio is large by slow gusts, and by what is
left of numbers that are all wrong."""
NEARER = 0.95
"""Factor on the largest error below which each force behind the first has to bring it beside the model's own
numbers."""
LITTLE, SHARPER = 0.02, 0.25
"""Error beyond the sensors' noise, as a share of the motion, that is no matter; and share of the errors that count as
none in a diagnosis which count as none here: what is sure decides which of two explanations holds, however little it
matters."""
REFINED = (0.5, 0.25, 0.125)
"""Shares of a step by which the times of a force that has entered are moved in turn."""


class Remainder(NamedTuple):
    """Free runs over all forces, what was selected of these, and the fit that the extended model is made of."""

    runs: FreeRuns
    forces: Forces
    selection: Selection
    fitted: Fitted


@dataclass(frozen=True)
class Beside:
    """Free runs of a model over all forces.

    flows : components of currents and winds that each record has of its own, free in every fit.
    plain : the fit of these alone.  exact : whether the model's own numbers are known.
    """

    runs: FreeRuns
    forces: Forces
    flows: tuple[Number, ...]
    plain: Fitted
    exact: bool

    @classmethod
    def of(cls, model: Model, records: Sequence[Record], options: Options, flows: Collection[str]) -> Beside:
        """The runs along records; flows : causes (current, wind) of which each record has its own."""
        bare = runs_of(model, records, options).sharper(SHARPER)
        forces = forces_along(bare)
        runs = bare.with_numbers(forces.places, forces.series)
        own = tuple(n for c in runs.bank.candidates if c.id in flows for n in c.numbers if ":" in n.name)
        plain = minimise(runs, own, {}, runs.no_own)
        return cls(runs, forces, own, plain, options.coefficient_sd == 0.0)

    @property
    def numbers(self) -> tuple[Number, ...]:
        """Numbers that are free beside every force: the model's own, unless it is known to be exact, and flows."""
        return (*self.flows, *(() if self.exact else self.runs.bank.own))

    @cached_property
    def whole(self) -> Fitted:
        """The fit with these numbers."""
        if len(self.numbers) == len(self.flows):
            return self.plain
        return minimise(self.runs, self.numbers, self.plain.point.values, self.plain.point.own)

    def with_spans(self, fitted: Fitted, always: Sequence[Number]) -> Beside:
        """With forces over spans of time of all records that may explain most about a fit."""
        runs, forces = with_spans(self.runs, self.forces, common_spans(self.runs, fitted, always))
        return replace(self, runs=runs, forces=forces)

    def fit(self, candidates: Sequence[Candidate]) -> Fitted:
        """The fit with candidates, and without the model's own numbers."""
        numbers = {n.name: n for n in (*self.flows, *(n for c in candidates for n in c.numbers))}
        return minimise(self.runs, tuple(numbers.values()), self.plain.point.values, self.plain.point.own)

    def rules(self, fitted: Fitted, most: int) -> Rules:
        """Those of a selection from a fit; most : forces that may enter where it leaves errors that matter."""
        return replace(RULES, enough=enough_of(self.runs), most=most) if self.leaves(fitted) else FAINT

    def leaves(self, fitted: Fitted) -> bool:
        """Whether a fit leaves errors that matter."""
        return not is_enough(self.runs, fitted, enough_of(self.runs))


def enough_of(runs: FreeRuns) -> np.ndarray:
    """Root mean square errors (C,) of left-out pieces below which no more than one force is looked for, and one in time
    of every record has to return in held-out ones.

    Eq. 14 of docs/mathematics/pieces.md.
    """
    return np.sqrt((LITTLE * runs.motion) ** 2 + runs.no_matter())


def forces_beside_numbers(now: Beside, single: bool) -> Remainder | None:
    """Forces that are needed beside the model's own numbers; single : none where there are several."""
    now = now.with_spans(now.whole, now.numbers)
    free = [c for c in now.forces.candidates if not now.numbers or not now.forces.forces[c.id].at_once]
    rules = replace(now.rules(now.whole, 2 if single else RULES.most), nearer=NEARER)
    selection = select(now.runs, free, rules, now.whole, now.numbers)
    sure = _once([one for one in selection.entered if _is_sure(now.runs, selection.final, one.candidate)], now.forces)
    if not sure or (single and len(sure) > 1):
        return None
    if len(sure) < len(selection.entered):
        selection = with_only(now.runs, selection, sure, now.numbers)
    rest = _refined(Remainder(now.runs, now.forces, selection, selection.final), now.numbers)
    if _is_steady(rest, now.numbers):
        return None
    simple = replace(now, runs=rest.runs).fit(rest.selection.candidates)
    beside = clearly_worse(rest.runs, simple, rest.fitted, RULES.least)
    return rest if beside else rest._replace(fitted=simple)


def forces_alone(base: Beside, wide: bool) -> Remainder | None:
    """Forces beside the base alone: one or two, one where all of its numbers may be wrong."""
    base = base.with_spans(base.plain, base.flows)
    rules = base.rules(base.plain, 1 if wide else 2)
    selection = select(base.runs, base.forces.candidates, rules, base.plain, base.flows)
    entered = _once(selection.entered, base.forces)
    if not entered:
        return None
    if len(entered) < len(selection.entered):
        selection = with_only(base.runs, selection, entered, base.flows)
    rest = _refined(Remainder(base.runs, base.forces, selection, selection.final), base.flows)
    sure = all(_is_sure(rest.runs, rest.fitted, one.candidate) for one in rest.selection.entered)
    return rest if sure and not _is_steady(rest, base.flows) else None


def same_forces_alone(base: Beside, rest: Remainder) -> Remainder:
    """The forces that were selected beside another model, beside the base alone."""
    runs, forces, entered = _over(base, rest)
    fitted = replace(base, runs=runs).fit([one.candidate for one in entered])
    whole = Remainder(runs, forces, Selection(base.plain, entered, fitted), fitted)
    return _refined(whole, base.flows)


def same_forces_beside_numbers(base: Beside, rest: Remainder) -> Remainder:
    """The forces that were selected beside another model, beside the base model's own numbers."""
    runs, forces, entered = _over(base, rest)
    numbers = distinct((*base.numbers, *(n for one in entered for n in one.candidate.numbers)))
    fitted = minimise(runs, numbers, base.whole.point.values, base.whole.point.own)
    return Remainder(runs, forces, Selection(base.whole, entered, fitted), fitted)


def _over(base: Beside, rest: Remainder) -> tuple[FreeRuns, Forces, tuple[Entered, ...]]:
    """The free runs of a base over forces that were selected beside another model, and these there."""
    runs, forces, entered = base.runs, base.forces, list[Entered]()
    for one in rest.selection.entered:
        force = rest.forces.forces[one.candidate.id]
        if force.shape.terms:
            runs, forces, candidate = with_force(runs, forces, force)
            one = replace(one, candidate=candidate)
        entered.append(one)  # drifts of sensors are the same beside any model
    return runs, forces, tuple(entered)


def _refined(rest: Remainder, always: Sequence[Number]) -> Remainder:
    """The forces with times at which left-out pieces are predicted best, near those that were screened."""
    for place, share in itertools.product(range(len(rest.selection.entered)), REFINED):
        force = rest.forces.forces[rest.selection.entered[place].candidate.id]
        trials = [_with_shape(rest, place, shape, always) for shape in force.shape.neighbours(share)]
        rest = min([rest, *trials], key=lambda one: score(one.fitted.left_out + floor_squares(one.runs)))
    return rest


def _with_shape(rest: Remainder, place: int, shape: Shape, always: Sequence[Number]) -> Remainder:
    """The remainder with another shape of one force, fitted again; from its sizes, where it is the same at other
    times."""
    entered, final = list(rest.selection.entered), rest.fitted
    old = rest.forces.forces[entered[place].candidate.id]
    runs, forces, candidate = with_force(rest.runs, rest.forces, Force(old.axis, shape))
    names = dict(zip(candidate.names, entered[place].candidate.names, strict=True)) if shape.near else {}
    entered[place] = replace(entered[place], candidate=candidate)
    numbers = distinct((*always, *(n for one in entered for n in one.candidate.numbers)))
    values = {n.name: final.value(names.get(n.name, n.name)) for n in numbers}
    fitted = minimise(runs, numbers, values, final.point.own, weight=final.point.weight)
    return Remainder(runs, forces, Selection(rest.selection.base, tuple(entered), fitted), fitted)


def _is_steady(rest: Remainder, always: Sequence[Number]) -> bool:
    """Whether a steady force in the place of one in time predicts left-out pieces no worse."""
    shapes = [rest.forces.forces[one.candidate.id].shape for one in rest.selection.entered]
    places = [i for i, shape in enumerate(shapes) if "time" in shape.depends_on and shape.terms]
    steady = (_with_shape(rest, i, STEADY, always) for i in places)
    return any(not surely_worse(other.runs, other.fitted, rest.fitted, CLEAR) for other in steady)


def _once(entered: Sequence[Entered], forces: Forces) -> tuple[Entered, ...]:
    """Of forces that one extension of a model would hold, as those of two lags, the one that entered first."""
    out, extensions = list[Entered](), set[str]()
    for one in entered:
        own = {*forces.forces[one.candidate.id].extensions}
        out += [] if own & extensions else [one]
        extensions |= own
    return tuple(out)


def _is_sure(runs: FreeRuns, fitted: Fitted, candidate: Candidate) -> bool:
    """Whether some number of a force differs from zero by more than its 90 % interval, beside what it is at the start
    of a record: that alone is steady, and known causes are."""
    halves = half_intervals(runs, fitted)
    return any(abs(fitted.value(name)) > halves[name] for name in candidate.names if "_first" not in name)


def surely_worse(runs: FreeRuns, one: Fitted, other: Fitted, errors: float) -> bool:
    """Whether a fit predicts left-out pieces worse than another one by so many standard errors, and by no chance."""
    between = fall_between(runs, one, other)
    return between.gain > errors * between.error and between.gain * independent(runs, other) > EVIDENT
