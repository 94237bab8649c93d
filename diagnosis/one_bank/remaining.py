"""What remains is described: forces along the measured motion that no cause of the bank explains.

Forces are tried beside the base alone, in the place of names of the hull, and beside the base model's own numbers, with
a higher bar than causes.  A force that follows a motion is a term of the extended model, unless it worsens held-out
records; one in time, and a sensor that drifts, where held-out records show it too.  Section 8 of
docs/mathematics/pieces.md.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...checks.result import Size
from ...datasets.columns import POSITIONS
from ...datasets.instruments import corrected
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
    mean_squares,
    quantile,
    select,
    with_only,
)
from ...models.extend import extended
from ...models.instruments import RUDDER, combined
from ..causes.base import Cause
from ..causes.registry import causes
from ..gain.guard import CLEARLY, log_fall, training_errors
from ..gain.runs import with_runs
from ..report.bank import BY_FREE_RUNS, demoted
from ..result import RemainingForce
from .catalogue import FLOWS
from .curve import curve_of
from .diagnose import runs_of, worsens
from .events import common_spans, events
from .forces import (
    AXES,
    BODY,
    READINGS,
    STEADY,
    Force,
    Forces,
    drift_of,
    forces_along,
    reading_of,
    unit_of,
    with_force,
    with_spans,
)
from .search import FEW, Choice, half_intervals, interval_factor
from .told import extended_model

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...estimation.selection.minimiser import Fitted
    from ...estimation.selection.number import Candidate, Number
    from ...models.model import Model
    from ..free_runs.bank import Bank
    from ..free_runs.problem import FreeRuns
    from ..options import Options
    from ..prepared import Prepared
    from ..result import Diagnosis
    from .events import Event
    from .forces import Shape

RULES = Rules(least=0.02, level=0.9995, most=3, leaders=4, of_each=1)
FAINT = replace(RULES, least=0.004, most=1, evident=RULES.level)
"""Forces have a higher bar than causes: hundreds are tried, and gusts are none.  Where no errors are left that matter,
one is looked for, which the pieces have to show together: a likelihood ratio is large by slow gusts, and by what is
left of numbers that are all wrong."""
LITTLE, SHARPER = 0.02, 0.25
"""Error beyond the sensors' noise, as a share of the motion, that is no matter; and share of the errors that count as
none in a diagnosis which count as none here: what is sure decides which of two explanations holds, however little it
matters."""
FAINTEST = 1e-4
"""Share of the squared motion below which no share of what remains is told: the errors are those of the sensors."""
SURE = 0.99
"""Level from which forces in the place of names of the hull, or of all numbers, predict left-out pieces better."""
REFINED = (0.5, 0.25, 0.125)
"""Shares of a step by which the times of a force that has entered are moved in turn."""
BIASES = {"r": ("yaw_rate_bias", "yaw_rate_bias"), "v": ("sway_offset", "sway_bias")}
"""State that a drifting sensor shows -> cause and instrument of its steady error, whose place the drift takes."""
INSTEAD = "what remains is described without it"
TAKEN_OFF, MOST_OF_IT = 0.5, 0.8
"""Share of what remains of the squared error that forces have to take off: less is no description of it;
share that forces in time and events have to take off, as gusts are none, and from which events are not looked for."""


class Remainder(NamedTuple):
    """Free runs over all forces, what was selected of these, and the fit that the extended model is made of."""

    runs: FreeRuns
    forces: Forces
    selection: Selection
    fitted: Fitted


def with_remaining(diagnosis: Diagnosis, records: Prepared, held_out: Sequence[Record], options: Options) -> Diagnosis:
    """The diagnosis with forces that describe what it leaves of left-out pieces, and a model extended by them.

    records : as they were corrected.  held_out : as they were read.

    Raises
    ------
    CannotFit : the records lack what free runs need.
    FitFailed : the arithmetic fails.
    """
    of_records = {*diagnosis.model.instruments, *records.instruments}
    instruments = {name: x for name, x in diagnosis.extended.instruments.items() if name not in of_records}
    train = [corrected(record, instruments) for record in records.train]
    base, model = (replace(m, instruments={}) for m in (diagnosis.model, diagnosis.extended))
    if diagnosis.verdict not in ("named", "tied", "partly_named"):
        model = base
    flows = {f.cause for f in diagnosis.causes if f.cause in FLOWS and any(s.record for s in f.sizes)}
    wide = _moved(base, model) > FEW
    if wide:  # the numbers that took up what remains start anew
        model = base
    now = _Beside.of(model, train, options, flows)
    if is_enough(now.runs, now.plain, np.sqrt(now.runs.no_matter)):  # the sensors' noise is all that is left
        return diagnosis
    beside_base = now if model is base else _Beside.of(base, train, options, flows)
    bases = [(_without_named(diagnosis, now.runs.bank, flows), beside_base)]
    if steering := {*instruments} & {*RUDDER}:
        rest_of = {name: x for name, x in instruments.items() if name not in steering}
        bare = _Beside.of(base, [corrected(record, rest_of) for record in records.train], options, flows)
        bases = [(_without_named(diagnosis, now.runs.bank, flows, steering), bare), *bases]
    answer = diagnosis
    for rival, rest in _explanations((diagnosis, now), bases, wide):
        start = model if rival is diagnosis else base
        answer = _told(diagnosis, rival, start, rest, records, held_out, options)
        if answer is not diagnosis:
            break
    if _share_of(answer) > MOST_OF_IT:
        return answer
    of_pieces = _events(now, events(now.runs, now.plain))
    if sum(event.share or 0.0 for event in of_pieces) > MOST_OF_IT:
        return replace(diagnosis, remaining=of_pieces, hypothesis=None)
    return answer


def _moved(base: Model, model: Model) -> int:
    """How many of a model's coefficients differ from those of the base model, or are none of it."""
    known = dict(zip(base.coordinates, base.coefficients.tolist(), strict=True))
    return sum(known.get(name) != x for name, x in zip(model.coordinates, model.coefficients.tolist(), strict=True))


def _explanations(
    named: tuple[Diagnosis, _Beside], bases: Sequence[tuple[Diagnosis, _Beside]], wide: bool
) -> Iterator[tuple[Diagnosis, Remainder]]:
    """What is told beside forces, and these, the preferred first: few forces beside the base alone, where they take the
    place of what is named of the hull and the rudder; forces beside the model's own numbers.

    named : the diagnosis, and free runs of the model that it has told.  bases : the base model's, the fewest names
    first.
    """
    now, ((rival, base), few) = named[1], _fewest(bases, wide)
    simple = few is not None and len(few.selection.entered) == 1 and not base.leaves(few.fitted)
    rest = None if simple else _beside_numbers(now)
    same_alone = _refitted(base, rest) if rest is not None and few is None else None
    for one in (one for one in (few, same_alone) if one is not None):
        if _takes_the_place(base, one, None if wide else now.plain) and not (rest and _preferred(rest, one)):
            yield rival, one
    if rest is not None:
        yield named[0], rest


def _fewest(
    bases: Sequence[tuple[Diagnosis, _Beside]], wide: bool
) -> tuple[tuple[Diagnosis, _Beside], Remainder | None]:
    """The free runs with the fewest names beside which forces predict left-out pieces no worse than beside more, and
    these forces."""
    alone = [_alone(base, wide) for _, base in bases]
    for side, few in zip(bases, alone, strict=True):
        others = [other for other in alone if other is not None]
        if few is not None and not any(_surely_worse(few.runs, few.fitted, o.fitted, CLEAR) for o in others):
            return side, few
    return bases[-1], alone[-1]


def _preferred(rest: Remainder, alone: Remainder) -> bool:
    """Whether forces beside the model's own numbers go before forces alone: these are worse, or are more and no
    better."""
    fewer = len(rest.selection.entered) < len(alone.selection.entered)
    if fewer and not _surely_worse(rest.runs, rest.selection.final, alone.fitted, CLEAR):
        return True
    return _surely_worse(rest.runs, alone.fitted, rest.selection.final, CLEAR)


def _takes_the_place(base: _Beside, one: Remainder, named: Fitted | None) -> bool:
    """Whether forces beside the base alone predict left-out pieces better than what is named.

    Than few numbers they have to do so surely, and no worse than all numbers of the base model together; than these
    (named None: which hardly err where they were fitted) clearly, as forces are fewer.
    """
    if named is None:
        return _surely_worse(base.runs, base.whole, one.fitted, CLEAR)
    surely = _surely_worse(base.runs, named, one.fitted, quantile(base.runs, SURE))
    return surely and not _surely_worse(base.runs, one.fitted, base.whole, CLEAR)


def _surely_worse(runs: FreeRuns, one: Fitted, other: Fitted, errors: float) -> bool:
    """Whether a fit predicts left-out pieces worse than another one by so many standard errors, and by no chance."""
    between = fall_between(runs, one, other)
    return between.gain > errors * between.error and between.gain * independent(runs, other) > EVIDENT


def _share_of(diagnosis: Diagnosis) -> float:
    """Share of the error that forces take off together; 1 where only several together do."""
    return max((1.0 if force.share is None else force.share for force in diagnosis.remaining), default=0.0)


def _of_hull(diagnosis: Diagnosis) -> set[str]:
    """Causes (ids) that describe the hull, of those that are named."""
    entries = {f.cause: causes().get(f.cause) for f in diagnosis.causes}
    return {name for name, entry in entries.items() if isinstance(entry, Cause) and entry.describes_hull}


def _without_named(
    diagnosis: Diagnosis, bank: Bank, flows: Collection[str], without: Collection[str] = ()
) -> Diagnosis:
    """The diagnosis without causes of the hull, and without what free runs have named that neither instruments nor
    records' own flows hold; without : instruments, too."""
    kept = {name: x for name, x in diagnosis.extended.instruments.items() if name not in without}
    held = {bank.cause_of(c) for c in bank.candidates for n in c.names if {*bank.places[n].entries} & {*kept}}
    by_runs = {f.cause for f in diagnosis.causes if f.stage == BY_FREE_RUNS and f.cause not in flows}
    left = without_causes(diagnosis, _of_hull(diagnosis) | (by_runs - held))
    return replace(left, extended=replace(diagnosis.extended, instruments=kept))


def without_causes(diagnosis: Diagnosis, ids: Collection[str]) -> Diagnosis:
    """The diagnosis without some causes, in the bank, too."""
    kept = tuple(f for f in diagnosis.causes if f.cause not in ids)
    of = ("named", "tied", "explained_by")
    bank = (e if e.cause not in ids else demoted([e], of, "not_significant", INSTEAD)[0] for e in diagnosis.bank)
    return replace(diagnosis, causes=kept, bank=tuple(bank))


def _without_biases(diagnosis: Diagnosis, axes: Collection[str]) -> Diagnosis:
    """The diagnosis without steady errors of sensors that drift."""
    ids, names = ({pair[i] for axis, pair in BIASES.items() if axis in axes} for i in (0, 1))
    kept = {name: x for name, x in diagnosis.extended.instruments.items() if name not in names}
    return replace(without_causes(diagnosis, ids), extended=replace(diagnosis.extended, instruments=kept))


# ---- the selection
@dataclass(frozen=True)
class _Beside:
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
    def of(cls, model: Model, records: Sequence[Record], options: Options, flows: Collection[str]) -> _Beside:
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

    def with_spans(self, fitted: Fitted, always: Sequence[Number]) -> _Beside:
        """With forces over spans of time of all records that may explain most about a fit."""
        runs, forces = with_spans(self.runs, self.forces, common_spans(self.runs, fitted, always))
        return replace(self, runs=runs, forces=forces)

    def fit(self, candidates: Sequence[Candidate]) -> Fitted:
        """The fit with candidates, and without the model's own numbers."""
        numbers = {n.name: n for n in (*self.flows, *(n for c in candidates for n in c.numbers))}
        return minimise(self.runs, tuple(numbers.values()), self.plain.point.values, self.plain.point.own)

    def rules(self, fitted: Fitted, most: int) -> Rules:
        """Those of a selection from a fit; most : forces that may enter where it leaves errors that matter."""
        return replace(RULES, enough=_enough(self.runs), most=most) if self.leaves(fitted) else FAINT

    def leaves(self, fitted: Fitted) -> bool:
        """Whether a fit leaves errors that matter."""
        return not is_enough(self.runs, fitted, _enough(self.runs))


def _enough(runs: FreeRuns) -> np.ndarray:
    """Root mean square errors (C,) of left-out pieces below which no more than one force is looked for, and one in time
    of every record has to return in held-out ones.

    Eq. 14 of docs/mathematics/pieces.md.
    """
    return np.sqrt((LITTLE * runs.motion) ** 2 + runs.no_matter)


def _beside_numbers(now: _Beside) -> Remainder | None:
    """Forces that are needed beside the model's own numbers."""
    now = now.with_spans(now.whole, now.numbers)
    free = [c for c in now.forces.candidates if not now.numbers or not now.forces.forces[c.id].at_once]
    selection = select(now.runs, free, now.rules(now.whole, RULES.most), now.whole, now.numbers)
    sure = _once([one for one in selection.entered if _is_sure(now.runs, selection.final, one.candidate)], now.forces)
    if not sure:
        return None
    if len(sure) < len(selection.entered):
        selection = with_only(now.runs, selection, sure, now.numbers)
    rest = _refined(Remainder(now.runs, now.forces, selection, selection.final), now.numbers)
    if _is_steady(rest, now.numbers):
        return None
    simple = replace(now, runs=rest.runs).fit(rest.selection.candidates)
    beside = clearly_worse(rest.runs, simple, rest.fitted, RULES.least)
    return rest if beside else rest._replace(fitted=simple)


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
    return any(not _surely_worse(other.runs, other.fitted, rest.fitted, CLEAR) for other in steady)


def _once(entered: Sequence[Entered], forces: Forces) -> tuple[Entered, ...]:
    """Of forces that one extension of a model would hold, as those of two lags, the one that entered first."""
    out, known = list[Entered](), set[str]()
    for one in entered:
        own = {*forces.forces[one.candidate.id].extensions}
        out += [] if own & known else [one]
        known |= own
    return tuple(out)


def _is_sure(runs: FreeRuns, fitted: Fitted, candidate: Candidate) -> bool:
    """Whether some number of a force differs from zero by more than its 90 % interval, beside what it is at the start
    of a record: that alone is steady, and known causes are."""
    halves = half_intervals(runs, fitted)
    return any(abs(fitted.value(name)) > halves[name] for name in candidate.names if "_first" not in name)


def _alone(base: _Beside, wide: bool) -> Remainder | None:
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


def _refitted(base: _Beside, rest: Remainder) -> Remainder:
    """The forces that were selected beside another model, beside the base alone."""
    runs, forces, entered = base.runs, base.forces, list[Entered]()
    for one in rest.selection.entered:
        force = rest.forces.forces[one.candidate.id]
        if force.shape.terms:
            runs, forces, candidate = with_force(runs, forces, force)
            one = replace(one, candidate=candidate)
        entered.append(one)  # drifts of sensors are the same beside any model
    fitted = replace(base, runs=runs).fit([one.candidate for one in entered])
    whole = Remainder(runs, forces, Selection(base.plain, tuple(entered), fitted), fitted)
    return _refined(whole, base.flows)


# ---- what is told
def _told(
    before: Diagnosis,
    diagnosis: Diagnosis,
    start: Model,
    rest: Remainder,
    records: Prepared,
    held_out: Sequence[Record],
    options: Options,
) -> Diagnosis:
    """The diagnosis with forces that were selected; the one before where these worsen held-out records."""
    diagnosis = _without_biases(diagnosis, {rest.forces.forces[c.id].axis for c in rest.selection.candidates})
    share = rest.runs.share_taken(rest.selection.base, rest.selection.final)
    entered = [(c, rest.forces.forces[c.id]) for c in rest.selection.candidates]
    in_time = any("time" in force.shape.depends_on for _, force in entered)
    if share < (MOST_OF_IT if in_time else TAKEN_OFF):
        return before
    of_every_record = any(force.begins or drift_of(rest.runs.places, c) for c, force in entered)
    to_return = of_every_record and bool(held_out) and is_enough(rest.runs, rest.selection.base, _enough(rest.runs))
    for time_too in (True, False) if in_time and not to_return else (True,):
        plain = _with_forces(diagnosis, start, rest, time_too, records, held_out, options)
        if not _errs_more(before, plain, in_time and time_too):
            break
    else:
        return before
    if not any(force.extended for force in plain.remaining) and _held_out_fall(before) >= CLEARLY:
        plain = replace(before, remaining=plain.remaining, hypothesis=None)  # forces in no model leave it as it is
    remaining = plain.remaining
    if plain.causes and plain.verdict not in ("unexplained", "partly_named"):
        return plain
    said = f"no known cause explains what remains, but it is described: {remaining[0].text}"
    named = plain.verdict == "partly_named" and plain.causes
    without = plain if named else without_causes(plain, _of_hull(plain))
    return replace(without, verdict="partly_named" if named else "described", reason=said)


def _with_forces(
    diagnosis: Diagnosis,
    start: Model,
    rest: Remainder,
    time_too: bool,
    records: Prepared,
    held_out: Sequence[Record],
    options: Options,
) -> Diagnosis:
    """The diagnosis with forces, and with a model extended by them; time_too : also by forces in time."""

    def extends(one: Entered, force: Force) -> bool:
        in_model = bool(force.extensions or drift_of(rest.runs.places, one.candidate))
        return in_model and (time_too or "time" not in force.shape.depends_on)

    entered = [(one, rest.forces.forces[one.candidate.id]) for one in rest.selection.entered]
    remaining = tuple(_force(rest, one, extends(one, force)) for one, force in entered)
    own = [one for one, force in entered if extends(one, force)]
    model = _extended(start, rest, own) if own else start
    drifts = {n: x for one in own for n, x in _instruments(rest, one).items()}
    model = replace(model, instruments=combined(diagnosis.extended.instruments, drifts))
    return with_runs(
        replace(diagnosis, extended=model, traces=(), remaining=remaining, hypothesis=None),
        records.train, records.instruments, held_out, options.channels,
    )  # fmt: skip


def _errs_more(before: Diagnosis, after: Diagnosis, in_time: bool) -> bool:
    """Whether the extended model predicts held-out records worse than the base model does, or than that of the
    diagnosis before, or the training ones no better.

    Along the measured motion a force can hold a simulation to it, as an observer does: only a simulation with the force
    shows whether it is one.  in_time : a force in time is a term of the model, which it is only where it returns: where
    held-out records are predicted clearly better with it.
    """
    if not any(force.extended for force in after.remaining):
        return False
    told_gain = {c: g.own_after for c, g in before.gain.items()}
    told_train = {c: error for c, (_, error) in training_errors(before).items()}
    held_out = _motion({c: (told_gain.get(c, g.own_before), g.own_after) for c, g in after.gain.items()})
    train = _motion({c: (told_train.get(c, old), new) for c, (old, new) in training_errors(after).items()})
    if worsens(after) or log_fall(*train) <= 0.0 or log_fall(*held_out) < 0.0:
        return True
    by_force = _held_out_fall(after) if len(after.causes) < len(before.causes) else log_fall(*held_out)
    return in_time and by_force < CLEARLY


def _held_out_fall(diagnosis: Diagnosis) -> float:
    """Fall of the logarithm of the error of held-out records from the base model to the extended one, each record with
    its own trim; 0 without these."""
    return log_fall(*_motion({c: (g.own_before, g.own_after) for c, g in diagnosis.gain.items()}))


def _motion(errors: Mapping[str, tuple[float, float]]) -> list[dict[str, float]]:
    """Errors before and after of channels but positions, which repeat what the others show."""
    return [{c: pair[i] for c, pair in errors.items() if c not in POSITIONS} for i in (0, 1)]


def _instruments(rest: Remainder, one: Entered) -> dict[str, float]:
    """Error and drift of a sensor that all records have, as instruments of a model; none of a force."""
    names = drift_of(rest.runs.places, one.candidate)
    return {instrument: rest.fitted.value(name) for name, instrument in names.items()}


def _force(rest: Remainder, one: Entered, extends: bool) -> RemainingForce:
    force, runs = rest.forces.forces[one.candidate.id], rest.runs
    share = runs.share_taken(rest.selection.base, rest.selection.final) if len(rest.selection.entered) == 1 else None
    fits = rest.selection.base, rest.selection.final
    gain = _gain(runs, *(mean_squares(runs, f.left_out) for f in fits))
    said = force.text
    if share is not None and np.sum(runs.excess(rest.selection.base)) > FAINTEST:
        said += f"; it takes {100.0 * share:.0f} % off the squared error of left-out pieces"
    reading, following = reading_of(force)
    sizes = tuple(_sizes(rest, one))
    rivals = tuple(rest.forces.forces[c.id].text for c in one.tied_with)
    axis = BODY.get(force.axis, force.axis)
    return RemainingForce(
        axis, force.shape.depends_on, said, share, gain, sizes, extends, reading, following,
        rivals, curve_of(force, runs, {s.parameter: (s.value, s.high - s.value) for s in sizes}),
    )  # fmt: skip


def _gain(runs: FreeRuns, before: np.ndarray, after: np.ndarray) -> dict[str, tuple[float, float]]:
    """Channel -> root mean square errors of mean squares (C,) before and after."""
    pairs = zip(np.sqrt(before).tolist(), np.sqrt(after).tolist(), strict=True)
    return dict(zip(runs.channels, pairs, strict=True))


def _events(now: _Beside, of_pieces: Sequence[Event]) -> tuple[RemainingForce, ...]:
    """Events as forces that are in no model."""
    runs, fitted = now.runs, now.plain
    whole = float(np.sum(runs.excess(fitted))) or 1.0
    out = []
    for event in of_pieces:
        taken = np.sum(mean_squares(runs, (event.before - event.after)[None]) / runs.motion**2)
        count = np.maximum(runs.counts[event.unit], 1.0)
        gain = _gain(runs, event.before / count, event.after / count)
        half = interval_factor(runs) * event.sd
        size = Size(f"{event.axis}_event", event.size, event.size - half, event.size + half,
                    unit_of(event.axis, runs.model), event.record)  # fmt: skip
        said = f"a {AXES[event.axis]} that acts for a time: {event.record}, {event.begin_s:.0f} to {event.end_s:.0f} s"
        axis, share = BODY.get(event.axis, event.axis), float(np.clip(taken / whole, 0.0, 1.0))
        out.append(RemainingForce(axis, ("time",), said, share, gain, (size,), False, *READINGS["event"]))
    return tuple(out)


def _sizes(rest: Remainder, one: Entered) -> Iterator[Size]:
    """Sizes of a force's numbers with 90 % intervals."""
    halves = half_intervals(rest.runs, rest.fitted)
    force = rest.forces.forces[one.candidate.id]
    for name in one.candidate.names:
        value, half = rest.fitted.value(name), halves[name]
        yield Size(name.partition("@")[0], value, value - half, value + half, force.unit(name, rest.runs.model))


def _extended(start: Model, rest: Remainder, entered: Sequence[Entered]) -> Model:
    """The model with the forces that follow its motion, and with its own numbers where these moved."""
    choice = Choice(rest.runs, Selection(rest.selection.base, (), rest.fitted))
    out = extended_model(start, choice, {})
    for one in entered:
        force = rest.forces.forces[one.candidate.id]
        for extension, values in force.parameters({n: rest.fitted.value(n) for n in one.candidate.names}):
            out = extended(out, extension, values)
    return out
