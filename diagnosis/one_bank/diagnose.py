"""A diagnosis by one bank and one criterion: linearise, select, extend, measure the gain, withdraw what worsens."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...datasets.instruments import corrected
from ...datasets.signals import sensor_sd
from ...estimation.records.series import MEASURED
from ...estimation.records.weather import WIND, flow_of
from ...estimation.selection.minimiser import minimise
from ...estimation.selection.selection import Selection
from ...models.errors import CannotFit, FitFailed
from ...models.instruments import combined
from ...models.model import CHANNELS
from ..free_runs.problem import FreeRuns
from ..free_runs.units import length_s, units_of, whole_unit
from ..gain.guard import blind_fall, is_for_trim, misleads, training_fall, worsens
from ..gain.runs import with_calibrated, with_runs, without_instruments
from ..report.bank import is_of_record, of_fault, with_causes
from ..report.verdict import diagnosis_of, of_motion
from .answer import (
    SEVERAL,
    apart,
    bank_lines,
    doubts_of,
    errors_by_record,
    extended_model,
    findings,
    is_apart,
    model_values,
    of_some,
    verdict,
    waves_of,
)
from .catalogue import FLOWS, Facts, bank_of
from .search import (
    SMALL,
    Choice,
    alone,
    chosen,
    neutral_angle_alone,
    with_own_numbers,
    withdrawn,
    without_neutral_angle,
)
from .slips import with_findings, without_slips

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model
    from ..options import Options
    from ..prepared import Prepared
    from ..result import Diagnosis, Finding
    from .slips import Slip

TRIED, MOST = 3, 6
"""Records that are left out in turn, where no cause explains the errors in all of them, and the most that there may be:
each takes a diagnosis of its own."""
LITTLE = 0.02
"""Rise of the logarithm of held-out errors without trim from which few candidates do not stand alone for all numbers of
the model: an angle whose size is wrong, as a delay is not named, does worse than none."""
NOT_FOLLOWED = 1.0
"""Error of records that are apart, as a share of the motion, from which they are left out though the others are not
explained: they are of another ship, or a column of theirs is wrong."""
BARRED = 2
"""Candidates that are barred at most, as whole records are predicted worse with them."""


class ChoiceAndDiagnosis(NamedTuple):
    """A choice with its diagnosis, and a diagnosis that was withdrawn only as it predicts a channel a little worse,
    where the motion is predicted clearly better (`guard.worsens`)."""

    choice: Choice
    diagnosis: Diagnosis
    nearly: Diagnosis | None


class OfPieces(NamedTuple):
    """What free runs of pieces say: the choice, that with all of the model's own numbers beside it where it predicts
    left-out pieces better, the diagnosis by both, and what was nearly said (`ChoiceAndDiagnosis`)."""

    choice: Choice
    wide: Choice | None
    diagnosis: Diagnosis
    nearly: Diagnosis | None


def by_pieces(model: Model, records: Prepared, held_out: Sequence[Record], options: Options) -> OfPieces:
    """Say what a model gets wrong about training records by free runs of pieces of them that were left out; what
    worsens held-out records is withdrawn, the last that entered first.  And what was nearly said
    (`ChoiceAndDiagnosis`).

    records : as they were corrected.  held_out : as they were read.

    Raises
    ------
    CannotFit : the records lack what free runs need.
    FitFailed : the arithmetic fails.
    """
    behind = records.behind_sensors(options.causes())
    choice, diagnosis, nearly = _choice_and_diagnosis(model, behind, held_out, options)
    few, most = apart(choice)
    if few:
        choice, diagnosis = _with_apart((choice, diagnosis), (few, most), model, behind, held_out, options)
    diagnosis, wide = _with_held_out_verdict(diagnosis), with_own_numbers(choice)
    if wide is None:
        return OfPieces(choice, None, diagnosis, nearly)
    calibrated = extended_model(model, wide, behind.instruments)
    outcome = with_calibrated(diagnosis, calibrated, held_out, options.channels)
    if worsens(replace(outcome, gain=outcome.calibrated_gain, traces=()), outweighed=True):
        return OfPieces(choice, None, diagnosis, nearly)
    return OfPieces(choice, wide, outcome, nearly)


def _with_held_out_verdict(diagnosis: Diagnosis) -> Diagnosis:
    """The diagnosis; a simulation that predicts held-out records worse than their means do is not adequate."""
    turning = ("heading_rad", "yaw_rate_rad_s")
    lost = any(gain.r2_after < 0.0 for channel, gain in diagnosis.gain.items() if channel in turning)
    if diagnosis.verdict != "adequate" or not lost:
        return diagnosis
    said = f"{diagnosis.reason}; held-out records are predicted worse than by their mean"
    return replace(diagnosis, verdict="unexplained", reason=said)


def _with_apart(
    of_all: tuple[Choice, Diagnosis],
    errors: tuple[dict[str, float], float],
    model: Model,
    behind: Prepared,
    held_out: Sequence[Record],
    options: Options,
) -> tuple[Choice, Diagnosis]:
    """The choice and the diagnosis without records that are apart, where these explain the others, or the model does
    not follow those at all; else those of all records.  Both say which records are apart, and what a diagnosis of these
    alone names beside others that are explained.

    errors : of the records that are apart, and the largest one of the others (`answer.apart`).
    """
    few, most = errors
    others, own = [r for r in behind.train if r.name not in few], [r for r in behind.train if r.name in few]
    choice, diagnosis = of_all
    of_own: tuple[Finding, ...] = ()
    explains = False
    with suppress(CannotFit, FitFailed):
        rest, of_rest, _ = _choice_and_diagnosis(model, replace(behind, train=others), held_out, options)
        left = rest.runs.worst(rest.selection.final)
        explains = left <= SMALL or min(few.values()) > NOT_FOLLOWED
        if explains and not _are_apart(choice, rest, few):
            return rest, of_rest
        if explains:
            choice, diagnosis = rest, replace(of_rest, apart=tuple(few))
            if left <= SMALL:
                of_own = _of_apart(_beyond(of_rest, model, replace(behind, train=own), options), few)
            diagnosis = with_causes(diagnosis, (*diagnosis.causes, *of_own))
    each = ", ".join(f"{name} ({of_motion(error)})" for name, error in few.items())
    said = f"the model errs in {each} by far more than in the other records (at most {of_motion(most)})"
    said += ", which are diagnosed without" if explains else ""
    said += "" if of_own else ": loading, depth of water, revolutions or weather may differ there"
    said += "" if of_own else ", or the motion goes beyond theirs"
    return choice, replace(diagnosis, doubts=(*diagnosis.doubts, said))


def _of_apart(diagnosis: Diagnosis, few: Collection[str]) -> tuple[Finding, ...]:
    """What a diagnosis of the records that are apart names, as findings of these; none where it explains them only with
    all numbers of the model, or not."""
    if diagnosis.verdict not in ("named", "tied"):
        return ()
    name = None if len(few) > 1 else next(iter(few))
    own = [f for f in diagnosis.causes if not is_of_record(f) and f.sizes]
    return tuple(
        replace(f, sizes=tuple(replace(s, record=name) for s in f.sizes), details={**f.details, "records": list(few)})
        for f in own
    )


def _beyond(of_others: Diagnosis, model: Model, own: Prepared, options: Options) -> Diagnosis:
    """The diagnosis of records beyond what explains others: of the model that a diagnosis of these extends.

    own : behind the instruments of `model`.
    """
    more = {n: x for n, x in of_others.extended.instruments.items() if n not in model.instruments}
    new = {name: x for name, x in more.items() if name not in own.instruments}
    records = replace(own, train=[corrected(r, new) for r in own.train])
    return _choice_and_diagnosis(without_instruments(of_others.extended, more), records, (), options).diagnosis


def without_one(
    diagnosis: Diagnosis, model: Model, records: Prepared, held_out: Sequence[Record], options: Options
) -> Diagnosis:
    """The diagnosis without one record, where that explains the others and leaves far more in this one; else that of
    all records.  A record that is wrong by itself takes part in the fit to all, and need not err most.

    Raises
    ------
    CannotFit : the records lack what free runs need.
    """
    behind = records.behind_sensors(options.causes())
    runs = runs_of(model, behind.train, options, behind.decided)
    base = minimise(runs, (), {}, runs.no_own)
    of_all, errors = (Choice(runs, Selection(base, (), base)), diagnosis), errors_by_record(runs, base)
    for name in sorted(errors, key=lambda n: -errors[n])[:TRIED] if SEVERAL <= len(errors) <= MOST else ():
        others = [e for n, e in errors.items() if n != name]
        _, rest = _with_apart(of_all, ({name: errors[name]}, max(others)), model, behind, held_out, options)
        if rest.apart:
            return _with_held_out_verdict(rest)
    return diagnosis


def _are_apart(of_all: Choice, rest: Choice, few: Collection[str]) -> bool:
    """Whether the choice without some records leaves errors in these that it does not leave in the others."""
    runs = rest.runs.along([u for u in of_all.runs.units if u.record.name in few])
    fitted = minimise(runs, (), rest.selection.final.point.values, runs.no_own)
    most = max(errors_by_record(rest.runs, rest.selection.final).values())
    return any(is_apart(error, most) for error in errors_by_record(runs, fitted).values())


def _choice_and_diagnosis(
    model: Model, behind: Prepared, held_out: Sequence[Record], options: Options
) -> ChoiceAndDiagnosis:
    """The choice without what worsens whole records, and the diagnosis by it.

    What stands beside the model's own numbers is tried without them.  Then the candidate that entered last is barred,
    and another choice is made without it; at the end what entered last is withdrawn as long as the errors grow.  A
    neutral angle leaves which the held-out records do not have; one takes the place of several numbers where whole
    records are predicted better with it alone.

    behind : records behind their sensors.  held_out : as they were read.

    Raises
    ------
    CannotFit : the records lack what free runs need.
    FitFailed : the arithmetic fails.
    """

    def runs_with(model: Model) -> FreeRuns:
        return runs_of(model, behind.train, options, behind.decided)

    likely, slips, as_it_is = without_slips(model, runs_with)

    def diagnosed(choice: Choice) -> Diagnosis:
        if as_it_is is not None:
            choice = replace(choice, selection=replace(choice.selection, base=as_it_is))
        outcome = _concluded(model, slips, behind, choice, options)
        return with_runs(outcome, behind.train, behind.instruments, held_out, options.channels)

    runs, without_gain, nearly, before = runs_with(likely), set[str](), None, None
    choice = chosen(runs, options)
    diagnosis = diagnosed(choice)
    if choice.wide is not None and blind_fall(diagnosis) < -LITTLE:
        choice = choice.wide
        diagnosis = diagnosed(choice)
    while worsens(diagnosis):
        nearly = diagnosis if nearly is None and not worsens(diagnosis, outweighed=True) else nearly
        last = {one.candidate.of for one in choice.selection.entered[-1:]} - without_gain
        if (few := alone(choice)) is not None and few.selection is not before:  # what is withdrawn leaves it as it is
            of_few, before = diagnosed(few), few.selection
            if of_few.verdict != "unexplained" and not worsens(of_few):
                return ChoiceAndDiagnosis(few, of_few, nearly)
        if last and len(without_gain) < BARRED:
            without_gain |= last
            choice = chosen(runs.without(without_gain), options)
        elif (rest := withdrawn(choice)) is not None:
            choice = rest
        else:
            break
        diagnosis = diagnosed(choice)
    return ChoiceAndDiagnosis(*_with_right_angle(choice, diagnosis, diagnosed, bool(held_out)), nearly)


def _with_right_angle(
    choice: Choice, diagnosis: Diagnosis, diagnosed: Callable[[Choice], Diagnosis], held_out: bool
) -> tuple[Choice, Diagnosis]:
    """The choice and its diagnosis with one neutral rudder angle of all records in the place of several numbers, or
    without one, where whole records are predicted better so; held_out : whether there are such records."""
    if (angle := neutral_angle_alone(choice)) is not None:
        of_angle = diagnosed(angle)
        falls = [blind_fall] if held_out else []
        falls += [] if is_for_trim(diagnosis) else [training_fall]
        if all(fall(of_angle) > fall(diagnosis) + LITTLE for fall in falls) and not worsens(of_angle):
            choice, diagnosis = angle, of_angle
    if misleads(diagnosis) and (rest := without_neutral_angle(choice)) is not None:
        of_rest = diagnosed(rest)
        if blind_fall(of_rest) > blind_fall(diagnosis) + LITTLE and not worsens(of_rest):
            choice, diagnosis = rest, of_rest
    return choice, diagnosis


def runs_of(model: Model, records: Sequence[Record], options: Options, decided: Collection[str] = ()) -> FreeRuns:
    """The free runs of pieces of records behind the model's instruments, over the whole bank but causes that the
    sensors' channels have decided on.

    Raises
    ------
    CannotFit : the records lack what free runs need, or the ship does not turn.
    """
    length = length_s(model, records)
    measured = {s for s in MEASURED if s in model.states and any(r.has(CHANNELS[s]) for r in records)}
    commanded = not any(r.has("rudder_rad") for r in records)
    identified, exact = options.base_parameters == "identify", options.coefficient_sd == 0.0
    longest_s = max(float(r.time_s[-1]) for r in records)
    windy = any(flow_of(r, WIND) is not None for r in records)
    facts = Facts(
        measured, commanded, len(records), longest_s, identified, exact, decided, options.coefficient_sd, windy
    )
    bank = bank_of(model, facts, length, options.only)
    runs = FreeRuns(bank, units_of(bank.model, records, length), length)
    runs.require_turns()
    return runs.in_waves()


def _concluded(model: Model, slips: Sequence[Slip], records: Prepared, choice: Choice, options: Options) -> Diagnosis:
    """The diagnosis without its gain.

    choice : made with the model without its slips.
    """
    by_runs = with_findings(findings(choice, options.base_parameters == "identify"), slips, model_values(choice))
    known = {f.cause for f in records.findings}
    of_faults = [of_fault(*fault, records.few.get(fault[0], ())) for fault in records.faults.items()]
    every = [*of_faults, *records.findings, *waves_of(choice.runs), *(f for f in by_runs if f.cause not in known)]
    if records.current is not None and not {f.cause for f in every} & {*FLOWS}:
        every = [records.current, *every]
    extended = replace(model, instruments=combined(model.instruments, records.instruments))
    if by_runs:
        extended = extended_model(model, choice, records.instruments)
    said = verdict(choice, every, options.coefficient_sd == 0.0)
    lines = bank_lines(choice, every, records.tested)
    noise = noise_of(records.train, choice)
    outcome = diagnosis_of((model, extended), options, said, every, lines, noise=noise)
    doubts = () if options.base_parameters == "identify" else doubts_of(choice)
    held_out, doubts = of_held_out(model, choice, records), (*outcome.doubts, *doubts)
    return replace(outcome, of_held_out=held_out, doubts=doubts)


def noise_of(records: Sequence[Record], choice: Choice) -> dict[str, Any]:
    """Noise of the sensors by the records alone; free runs tell nothing of random forces and the rudder's sensor."""
    columns = [CHANNELS[s] for s in choice.runs.symbols]
    known = {c: [sensor_sd(r.column(c)) for r in records if r.has(c)] for c in columns}
    sensors = {c: float(np.sqrt(np.mean(np.square(sds)))) for c, sds in known.items() if sds}
    return {"sensor_sd": sensors, "force_sd": [], "correlation_time_s": None, "rudder_sd": None}


def of_held_out(model: Model, choice: Choice, records: Prepared) -> dict[str, dict[str, float]]:
    """Held-out record -> the flow of its own, estimated on its first half; none where no record has its own."""
    out: dict[str, dict[str, float]] = {}
    for candidate in choice.selection.candidates:
        places = [choice.runs.bank.places[n] for n in candidate.names]
        flows = [n for n, p in zip(candidate.names, places, strict=True) if p.kind == "flow" and p.record is not None]
        for record in records.held_out if flows and not of_some(choice, candidate) else ():
            half = record.slice(0, record.n // 2)
            runs = choice.runs.along([whole_unit(choice.bank.model, half, choice.runs.length_s)])
            fixed = {n: x for n, x in choice.selection.final.point.values.items() if n not in flows}
            numbers = [replace(n, name=n.name.partition(":")[0]) for n in candidate.numbers[:2]]
            fitted = minimise(runs, numbers, fixed, runs.no_own)
            out.setdefault(record.name, {}).update({n.name: fitted.value(n.name) for n in numbers})
    return out
