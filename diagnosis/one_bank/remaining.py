"""What remains is described: forces along the measured motion that no cause of the bank explains.

Known causes go first: forces are tried beside what was named and beside the base model's own numbers, and with a higher
bar.  A force that follows a motion is a term of the extended model, unless it worsens held-out records; one in time is
described only.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...checks.result import Size
from ...datasets.instruments import corrected
from ...estimation.selection.minimiser import minimise
from ...estimation.selection.score import fall
from ...estimation.selection.selection import (
    Entered,
    Rules,
    Selection,
    clearly_worse,
    floor_squares,
    is_enough,
    mean_squares,
    select,
    with_only,
)
from ...models.extend import extended
from ..causes.base import Cause
from ..causes.registry import causes
from ..gain.guard import log_fall, training_errors
from ..gain.runs import with_runs
from ..report.bank import demoted
from ..result import RemainingForce
from .catalogue import FLOWS
from .curve import curve_of
from .diagnose import runs_of, worsens
from .events import events
from .forces import AXES, BODY, READINGS, UNITS, Forces, forces_along, reading_of
from .search import Choice, half_intervals, interval_factor
from .told import extended_model

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...estimation.selection.minimiser import Fitted
    from ...estimation.selection.number import Candidate, Number
    from ...models.model import Model
    from ..free_runs.problem import FreeRuns
    from ..options import Options
    from ..prepared import Prepared
    from ..result import Diagnosis
    from .events import Event

RULES = Rules(least=0.02, level=0.9995, most=3, leaders=5, of_each=2)
"""Forces have a higher bar than causes: hundreds are tried, and gusts are none."""
NOISE, LITTLE = 1.2, 0.02
"""Factor on the sensors' squared noise, which is estimated, and error beyond it, as a share of the motion, that is no
matter."""
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
    now = _Beside.of(model, train, options, flows)
    if not now.leaves(now.plain):
        return diagnosis
    hull = any(_of_hull(f.cause) for f in diagnosis.causes) and model is not base

    @cache
    def of_base() -> _Beside:
        return now if model is base else _Beside.of(base, train, options, flows)

    answer = diagnosis
    for of_model, rest in _explanations(now, of_base, hull):
        rival, start = (diagnosis, model) if of_model else (_without_hull(diagnosis), base)
        answer = _told(diagnosis, rival, start, rest, records, held_out, options)
        if answer is not diagnosis:
            break
    if _share_of(answer) > MOST_OF_IT:
        return answer
    of_pieces = _events(now, events(now.runs, now.plain))
    if sum(event.share or 0.0 for event in of_pieces) > MOST_OF_IT:
        return replace(diagnosis, remaining=of_pieces, hypothesis=None)
    return answer


def _explanations(now: _Beside, of_base: Callable[[], _Beside], hull: bool) -> Iterator[tuple[bool, Remainder]]:
    """Whether beside the model that the diagnosis has told, and forces, the preferred first: beside the base alone
    where names of the hull (hull) are needless then, beside the model, and few forces in the place of these names."""
    rest = _beside_numbers(now)
    if rest is not None:
        for alone in _alone(of_base(), rest) if hull else ():
            if alone is not None and not clearly_worse(now.runs, alone.fitted, rest.fitted, RULES.least):
                yield False, alone
        yield True, rest
    few = _instead(now, of_base())
    if few is not None:
        yield False, few


def _alone(base: _Beside, rest: Remainder) -> Iterator[Remainder | None]:
    """Forces beside the base alone: those that are selected there, and those that were beside another model."""
    yield _beside_numbers(base)
    yield _refitted(base, rest)


def _share_of(diagnosis: Diagnosis) -> float:
    """Share of the error that forces take off together; 1 where only several together do."""
    return max((1.0 if force.share is None else force.share for force in diagnosis.remaining), default=0.0)


def _of_hull(name: str) -> bool:
    entry = causes().get(name)
    return isinstance(entry, Cause) and entry.describes_hull


def _without_hull(diagnosis: Diagnosis) -> Diagnosis:
    """The diagnosis without causes of the hull, and without what the model's own numbers explain."""
    return without_causes(diagnosis, {f.cause for f in diagnosis.causes if _of_hull(f.cause)})


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
        bare = runs_of(model, records, options)
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

    def fit(self, candidates: Sequence[Candidate]) -> Fitted:
        """The fit with candidates, and without the model's own numbers."""
        numbers = {n.name: n for n in (*self.flows, *(n for c in candidates for n in c.numbers))}
        return minimise(self.runs, tuple(numbers.values()), self.plain.point.values, self.plain.point.own)

    @property
    def enough(self) -> np.ndarray:
        """Root mean square errors (C,) of left-out pieces below which none matters.

        Eq. 14 of docs/mathematics/pieces.md.
        """
        return np.sqrt((LITTLE * self.runs.motion) ** 2 + _no_matter(self.runs))

    @property
    def rules(self) -> Rules:
        """Those of the selection: no force is looked for where no errors are left that matter."""
        return replace(RULES, enough=self.enough)

    def leaves(self, fitted: Fitted) -> bool:
        """Whether a fit leaves errors that matter."""
        return not is_enough(self.runs, fitted, self.enough)


def _beside_numbers(now: _Beside) -> Remainder | None:
    """Forces that are needed beside the model's own numbers."""
    if not now.leaves(now.whole):
        return None
    free = [c for c in now.forces.candidates if not now.numbers or not now.forces.forces[c.id].at_once]
    selection = select(now.runs, free, now.rules, now.whole, now.numbers)
    simple = now.fit(selection.candidates)
    sure = _once([one for one in selection.entered if _is_sure(now.runs, simple, one.candidate)], now.forces)
    if not sure:
        return None
    if len(sure) < len(selection.entered):
        selection = with_only(now.runs, selection, sure, now.numbers)
        simple = now.fit(selection.candidates)
    beside = clearly_worse(now.runs, simple, selection.final, RULES.least)
    return Remainder(now.runs, now.forces, selection, selection.final if beside else simple)


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


def _instead(now: _Beside, base: _Beside) -> Remainder | None:
    """One or two forces in the place of what is named, where they predict left-out pieces clearly better than it, and
    no worse than all numbers of the base model together."""
    few = replace(base.rules, most=2)
    selection = _exchanged(base, select(base.runs, base.forces.candidates, few, base.plain, base.flows))
    worse = partial(clearly_worse, base.runs, least=RULES.least)
    if not all(_is_sure(base.runs, selection.final, one.candidate) for one in selection.entered):
        return None
    if not selection.entered or worse(selection.final, base.whole) or not worse(now.plain, selection.final):
        return None
    return Remainder(base.runs, base.forces, selection, selection.final)


def _exchanged(base: _Beside, selection: Selection) -> Selection:
    """The selection of one force with the best of all ways in which a force may depend on its variables: the screen is
    linear, and lags are far from each other."""
    if len(selection.entered) != 1:
        return selection
    one = selection.entered[0]
    fits = {c: base.fit([c]) for c in base.forces.candidates if c.of == one.candidate.of}
    between = {c: fall(selection.base.left_out, f.left_out, floor_squares(base.runs)) for c, f in fits.items()}
    best = max(between, key=lambda c: between[c].gain)
    return Selection(selection.base, (Entered(best, between[best], one.tied_with),), fits[best])


def _refitted(base: _Beside, rest: Remainder) -> Remainder | None:
    """The forces that were selected, fitted beside another model; None where its time scale, and so its periods and
    lags, are others."""
    if not {n for c in rest.selection.candidates for n in c.names} <= base.runs.places.keys():
        return None
    return Remainder(base.runs, base.forces, rest.selection, base.fit(rest.selection.candidates))


def _no_matter(runs: FreeRuns) -> np.ndarray:
    """Squared errors (C,) of the sensors' noise and of what counts as none."""
    return NOISE * runs.noise + runs.floor**2


def _relative_excess(runs: FreeRuns, fitted: Fitted) -> float:
    """Mean squared error of left-out pieces beyond noise and what counts as none, as a share of the motion squared, the
    sum over channels."""
    excess = np.maximum(mean_squares(runs, fitted.left_out) - _no_matter(runs), 0.0)
    return float(np.sum(excess / runs.motion**2))


def _share(runs: FreeRuns, before: Fitted, after: Fitted) -> float:
    """Share of the squared error of left-out pieces beyond noise that a fit takes off.

    Eq. 13 of docs/mathematics/pieces.md.
    """
    taken = np.sum(mean_squares(runs, before.left_out - after.left_out) / runs.motion**2)
    return float(np.clip(taken / max(_relative_excess(runs, before), 1e-12), 0.0, 1.0))


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
    remaining = tuple(_force(rest, one) for one in rest.selection.entered)
    diagnosis = _without_biases(diagnosis, {force.axis for force in remaining})
    model = _extended(start, rest) if any(force.extended for force in remaining) else start
    model = replace(model, instruments=diagnosis.extended.instruments)
    plain = with_runs(
        replace(diagnosis, extended=model, traces=(), remaining=remaining, hypothesis=None),
        records.train, records.instruments, held_out, options.channels,
    )  # fmt: skip
    share = _share(rest.runs, rest.selection.base, rest.selection.final)
    in_time = any("time" in force.depends_on for force in remaining)
    if share < (MOST_OF_IT if in_time else TAKEN_OFF) or _errs_more(before, plain):
        return before
    if not diagnosis.causes or diagnosis.verdict in ("unexplained", "partly_named"):
        said = f"no known cause explains what remains, but it is described: {remaining[0].text}"
        named = diagnosis.verdict == "partly_named" and diagnosis.causes
        without = plain if named else _without_hull(plain)
        return replace(without, verdict="partly_named" if named else "described", reason=said)
    return plain


def _errs_more(before: Diagnosis, after: Diagnosis) -> bool:
    """Whether the extended model predicts held-out records worse than the base model does, or than that of the
    diagnosis before, or the training ones no better.

    Along the measured motion a force can hold a simulation to it, as an observer does: only a simulation with the force
    shows whether it is one.  Forces in time are in no model.
    """
    if not any(force.extended for force in after.remaining):
        return False
    held_out = [{c: g.own_after for c, g in d.gain.items()} for d in (before, after)]
    train = [{c: error for c, (_, error) in training_errors(d).items()} for d in (before, after)]
    return worsens(after) or (bool(after.gain) and log_fall(*held_out) < 0.0) or log_fall(*train) <= 0.0


def _force(rest: Remainder, one: Entered) -> RemainingForce:
    force, runs = rest.forces.forces[one.candidate.id], rest.runs
    share = _share(runs, rest.selection.base, rest.selection.final) if len(rest.selection.entered) == 1 else None
    fits = rest.selection.base, rest.selection.final
    gain = _gain(runs, *(mean_squares(runs, f.left_out) for f in fits))
    said = force.text
    if share is not None:
        said += f"; it takes {100.0 * share:.0f} % off the squared error of left-out pieces"
    reading, following = reading_of(force)
    sizes = tuple(_sizes(rest, one))
    rivals = tuple(rest.forces.forces[c.id].text for c in one.tied_with)
    axis = BODY.get(force.axis, force.axis)
    return RemainingForce(
        axis, force.shape.depends_on, said, share, gain, sizes, bool(force.extensions), reading, following,
        rivals, curve_of(force, runs, {s.parameter: (s.value, s.high - s.value) for s in sizes}),
    )  # fmt: skip


def _gain(runs: FreeRuns, before: np.ndarray, after: np.ndarray) -> dict[str, tuple[float, float]]:
    """Channel -> root mean square errors of mean squares (C,) before and after."""
    pairs = zip(np.sqrt(before).tolist(), np.sqrt(after).tolist(), strict=True)
    return dict(zip(runs.channels, pairs, strict=True))


def _events(now: _Beside, of_pieces: Sequence[Event]) -> tuple[RemainingForce, ...]:
    """Events as forces that are in no model."""
    runs, fitted = now.runs, now.plain
    whole = _relative_excess(runs, fitted) or 1.0
    out = []
    for event in of_pieces:
        taken = np.sum(mean_squares(runs, (event.before - event.after)[None]) / runs.motion**2)
        count = np.maximum(runs.counts[event.unit], 1.0)
        gain = _gain(runs, event.before / count, event.after / count)
        half = interval_factor(runs) * event.sd
        size = Size(f"{event.axis}_event", event.size, event.size - half, event.size + half, UNITS[event.axis],
                    event.record)  # fmt: skip
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
        yield Size(name.partition("@")[0], value, value - half, value + half, force.unit(name))


def _extended(start: Model, rest: Remainder) -> Model:
    """The model with the forces that follow its motion, and with its own numbers where these moved."""
    choice = Choice(rest.runs, Selection(rest.selection.base, (), rest.fitted))
    out = extended_model(start, choice, {})
    for one in rest.selection.entered:
        force = rest.forces.forces[one.candidate.id]
        for extension, values in force.parameters({n: rest.fitted.value(n) for n in one.candidate.names}):
            out = extended(out, extension, values)
    return out
