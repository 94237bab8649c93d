"""What remains is described: forces along the measured motion that no cause of the bank explains.

Forces are tried beside the base alone, in the place of names of the hull, and beside the base model's own numbers.
Section 8 of docs/mathematics/pieces.md.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...datasets.instruments import corrected
from ...estimation.selection.selection import CLEAR, is_enough, quantile
from ...models.instruments import RUDDER
from ..causes.steering_gear import RudderOffset, own_neutral_angles
from ..report.bank import is_of_record
from .catalogue import FLOWS
from .events import events
from .force_answer import MOST_OF_IT, event_forces, of_hull, share_of, with_forces, without_instruments
from .force_search import (
    Beside,
    Remainder,
    forces_alone,
    forces_beside_numbers,
    same_forces_alone,
    same_forces_beside_numbers,
    surely_worse,
)
from .search import FEW, LARGE

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...estimation.selection.minimiser import Fitted
    from ...models.model import Model
    from ..free_runs.bank import Bank
    from ..options import Options
    from ..prepared import Prepared
    from ..result import Diagnosis

SURE = 0.99
"""Level from which forces in the place of names of the hull, or of all numbers, predict left-out pieces better."""


def with_remaining(diagnosis: Diagnosis, records: Prepared, held_out: Sequence[Record], options: Options) -> Diagnosis:
    """The diagnosis with forces that describe what it leaves of left-out pieces, and a model extended by them.

    records : as they were corrected.  held_out : as they were read.

    Raises
    ------
    CannotFit : the records lack what free runs need.
    FitFailed : the arithmetic fails.
    """
    before = {*diagnosis.model.instruments, *records.instruments}
    instruments = {name: x for name, x in diagnosis.extended.instruments.items() if name not in before}
    own = {name: {RudderOffset.id: x} for name, x in own_neutral_angles(diagnosis.causes).items()}
    base, model = (replace(m, instruments={}) for m in (diagnosis.model, diagnosis.extended))
    if diagnosis.verdict not in ("named", "tied", "partly_named"):
        model = base
    flows = {f.cause for f in diagnosis.causes if f.cause in FLOWS and any(s.record for s in f.sizes)}

    def beside(start: Model, corrections: Mapping[str, float], angles: Mapping[str, Mapping[str, float]]) -> Beside:
        train = [corrected(record, {**corrections, **angles.get(record.name, {})}) for record in records.train]
        return Beside.of(start, train, options, flows)

    wide = _moved(base, model) > FEW
    if wide:  # the numbers that took up what remains start anew
        model = base
    now = beside(model, instruments, own)
    if is_enough(now.runs, now.plain, np.sqrt(now.runs.no_matter())):  # the sensors' noise is all that is left
        return diagnosis
    little = not wide and now.runs.worst(now.plain) <= LARGE
    beside_base, bank = now if model is base else beside(base, instruments, own), now.runs.bank
    bases = [(_without_named(diagnosis, bank, flows | {RudderOffset.id} if own else flows), beside_base)]
    if own:
        bases = [(_without_named(diagnosis, bank, flows), beside(base, instruments, {})), *bases]
    fewer = None
    if steering := {*instruments} & {*RUDDER}:
        rest_of = {name: x for name, x in instruments.items() if name not in steering}
        of_base = beside(base, rest_of, {})
        bases = [(_without_named(diagnosis, bank, flows, steering), of_base), *bases]
        fewer = _without_steering(diagnosis, bank, steering), of_base
    answer = diagnosis
    sure = CLEAR if own and held_out else None
    for rival, rest in _explanations((diagnosis, now), bases, fewer, wide, little, sure):
        start = model if rival is diagnosis else base
        answer = with_forces(diagnosis, rival, start, rest, records, held_out, options)
        if answer is not diagnosis:
            break
    if share_of(answer) > MOST_OF_IT:
        return answer
    of_pieces = event_forces(now, events(now.runs, now.plain))
    if sum(event.share or 0.0 for event in of_pieces) > MOST_OF_IT:
        return replace(diagnosis, remaining=of_pieces, hypothesis=None)
    return answer


def _moved(base: Model, model: Model) -> int:
    """How many of a model's coefficients differ from those of the base model, or are none of it."""
    own = dict(zip(base.coordinates, base.coefficients.tolist(), strict=True))
    return sum(own.get(name) != x for name, x in zip(model.coordinates, model.coefficients.tolist(), strict=True))


def _explanations(
    own: tuple[Diagnosis, Beside],
    bases: Sequence[tuple[Diagnosis, Beside]],
    fewer: tuple[Diagnosis, Beside] | None,
    wide: bool,
    little: bool,
    sure: float | None,
) -> Iterator[tuple[Diagnosis, Remainder]]:
    """What is told beside forces, and these, the preferred first: few forces beside the base alone, where they take the
    place of what is named of the hull and the rudder; forces beside the model's own numbers.

    own : the diagnosis, and free runs of its extended model.  bases : the base model's, the fewest names first.
    fewer : the diagnosis without faults of the rudder, which forces go before, and the base model's runs without these.
    little : whether the errors that are left are small: then several forces beside numbers are not told.
    sure : standard errors by which forces have to be better than what is named; None: those of SURE.
    """
    now, ((rival, base), few) = own[1], _fewest(bases, wide)
    simple = few is not None and len(few.selection.entered) == 1 and not base.leaves(few.fitted)
    rest = None if simple else forces_beside_numbers(now, single=little)
    same_alone = same_forces_alone(base, rest) if rest is not None and few is None else None
    for one in (one for one in (few, same_alone) if one is not None):
        if _takes_the_place(base, one, None if wide else now.plain, sure) and not (rest and _preferred(rest, one)):
            yield rival, one
    if rest is not None and fewer is not None:
        same = same_forces_beside_numbers(fewer[1], rest)
        if not surely_worse(same.runs, same.fitted, rest.selection.final, CLEAR):
            yield fewer[0], same
    if rest is not None:
        yield own[0], rest


def _fewest(bases: Sequence[tuple[Diagnosis, Beside]], wide: bool) -> tuple[tuple[Diagnosis, Beside], Remainder | None]:
    """The free runs with the fewest names beside which forces predict left-out pieces no worse than beside more, and
    these forces."""
    alone = [forces_alone(base, wide) for _, base in bases]
    for side, few in zip(bases, alone, strict=True):
        others = [other for other in alone if other is not None]
        if few is not None and not any(surely_worse(few.runs, few.fitted, o.fitted, CLEAR) for o in others):
            return side, few
    return bases[-1], alone[-1]


def _preferred(rest: Remainder, alone: Remainder) -> bool:
    """Whether forces beside the model's own numbers go before forces alone: these are worse, or are more and no
    better."""
    fewer = len(rest.selection.entered) < len(alone.selection.entered)
    if fewer and not surely_worse(rest.runs, rest.selection.final, alone.fitted, CLEAR):
        return True
    return surely_worse(rest.runs, alone.fitted, rest.selection.final, CLEAR)


def _takes_the_place(base: Beside, one: Remainder, by_names: Fitted | None, sure: float | None) -> bool:
    """Whether forces beside the base alone predict left-out pieces better than what is named.

    Than few numbers they have to do so surely (clearly, than neutral angles of single records: these tell nothing of a
    further one, and held-out records decide), and no worse than all numbers of the base model together; than these
    (by_names None: which hardly err where they were fitted) clearly, as forces are fewer.
    """
    if by_names is None:
        return surely_worse(base.runs, base.whole, one.fitted, CLEAR)
    surely = surely_worse(base.runs, by_names, one.fitted, sure or quantile(base.runs, SURE))
    return surely and not surely_worse(base.runs, one.fitted, base.whole, CLEAR)


def _without_steering(diagnosis: Diagnosis, bank: Bank, steering: Collection[str]) -> Diagnosis:
    """The diagnosis without faults of the rudder, by their instruments."""
    return without_instruments(diagnosis, _causes_by(bank, steering), steering)


def _without_named(
    diagnosis: Diagnosis, bank: Bank, flows: Collection[str], without: Collection[str] = ()
) -> Diagnosis:
    """The diagnosis without causes of the hull, and without what free runs have named that neither instruments nor
    records' own flows hold; without : instruments, too."""
    of_instruments = _causes_by(bank, {*diagnosis.extended.instruments} - {*without})
    by_runs = {f.cause for f in diagnosis.causes if not is_of_record(f) and f.cause not in flows}
    return without_instruments(diagnosis, of_hull(diagnosis) | (by_runs - of_instruments), without)


def _causes_by(bank: Bank, instruments: Collection[str]) -> set[str]:
    """Causes whose numbers are some instruments."""
    return {bank.cause_of(c) for c in bank.candidates for n in c.names if {*bank.places[n].entries} & {*instruments}}
