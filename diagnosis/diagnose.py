"""The steps of a diagnosis: gross faults, base parameters, causes, what is unexplained, extended model, gain."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from ..datasets.columns import INPUTS, POSITIONS
from ..datasets.instruments import corrected, gear_of
from ..datasets.yaw_response import steering_side
from ..estimation.results.fit import arithmetic_guard, blas_limited
from ..models.errors import BadInput, CannotFit, FitFailed
from ..models.model import CHANNELS
from ..models.parameter_checks import side_of
from .checked import named_first, with_checks
from .gain.guard import worsens
from .innovations.diagnose import by_innovations
from .one_bank.diagnose import by_pieces, without_one
from .one_bank.force_answer import INSTEAD
from .one_bank.remaining import with_remaining
from .one_bank.slips import usual
from .options import Options
from .prepared import Prepared, ready_records, require_room
from .report.bank import BY_CHANNELS, of_model_side, without_causes
from .result import Diagnosis

if TYPE_CHECKING:
    from ..datasets.record import Record, Side
    from ..models.model import Model

CHECKS, BASE_MODEL = "checks of sensors and files", "identification of the base model"
PIECES = "free runs of left-out pieces"
CAUSES = "causes and gain"
REST = "forces that describe the rest"
"""Stages of a diagnosis; not every diagnosis has all of them."""
UNDESCRIBED = "what remains was not described by forces"


def diagnose(
    model: Model,
    train: Sequence[Record],
    held_out: Sequence[Record] = (),
    options: Options | None = None,
    watch: Callable[[str], object] = lambda stage: None,
) -> Diagnosis:
    """Show what the model gets wrong about training records, name the cause, and measure the gain on held-out ones.

    Parameters
    ----------
    model : base model; with coefficients unless they are to be identified.
    train, held_out : records in SI units; held-out records take no part in naming or fitting.
    watch : is called with the name of each stage when it begins.

    Raises
    ------
    BadInput : for options that cannot be, or no training record.
    CannotFit : if a record lacks rudder, or heading and yaw rate.
    FitFailed : the model cannot be run with the records, or the arithmetic fails outside the fit of a single cause.
    """
    with arithmetic_guard(), blas_limited():
        return _diagnosed(model, train, held_out, (options or Options()).checked(model), watch)


def _diagnosed(
    model: Model,
    train: Sequence[Record],
    held_out: Sequence[Record],
    options: Options,
    watch: Callable[[str], object],
) -> Diagnosis:
    started = time.perf_counter(), time.process_time()
    watch(CHECKS)
    stated, model = model, turned_to_its_side(model)
    is_turned, aside = model is not stated, list[str]()
    if is_turned and (side := common_side(train)) is not None:
        is_turned, train, held_out = False, *([to_side(r, side) for r in records] for records in (train, held_out))
        aside.append(f"the records contradict their positive_rudder, too: they were read with positive_rudder: {side}")
    records, more = ready_records(model, train, held_out, options)
    require_room(model, records)
    if options.base_parameters == "identify":
        records = records.behind_sensors(options.causes())
        watch(BASE_MODEL)
        model = identified(model, records.train)
    behind = records.behind_sensors(options.causes())
    held = behind.put_back(records.recorded)
    options = through_the_water(options, records)
    diagnosis, nearly = _named(model, records, held, options, watch)
    alike = replace(records, train=[r for r in records.train if r.name not in diagnosis.apart])
    diagnosis = _described(diagnosis, alike if diagnosis.apart else records, held, options, watch)
    if diagnosis.apart:
        own = replace(records, train=[r for r in records.train if r.name in diagnosis.apart])
        diagnosis = _with_forces_apart(diagnosis, _described(replace(diagnosis, remaining=()), own, (), options, watch))
    if diagnosis.verdict == "unexplained" and options.only is None and options.coefficient_sd != 0.0:
        leave_out = partial(without_one, diagnosis, diagnosis.model, records, held, options)
        said = "records were not left out in turn"
        diagnosis = nearly or _as_far_as_possible(leave_out, diagnosis, said)
    diagnosis = with_checks(diagnosis, records.checked, (*records.train, *records.held_out))
    if is_turned:
        diagnosis = named_first(diagnosis, of_model_side(model))
        verdict = "partly_named" if diagnosis.verdict == "unexplained" else diagnosis.verdict
        diagnosis = replace(diagnosis, verdict=verdict)
    roles = [(r.name, "train") for r in train] + [(r.name, "held_out") for r in held_out]
    wall_s, cpu_s = time.perf_counter() - started[0], time.process_time() - started[1]
    names, doubts = {r.name for r in records.train}, (*aside, *more, *diagnosis.doubts)
    evaluation = tuple(held or behind.put_back([r for r in train if r.name in names]))
    return replace(diagnosis, records=tuple(roles), doubts=doubts, evaluation=evaluation, wall_s=wall_s, cpu_s=cpu_s)


def turned_to_its_side(model: Model) -> Model:
    """The model with the side to which a positive rudder angle turns it, where it states the other one: without numbers
    that hardly any ship has, as an inertia below zero turns a ship the wrong way."""
    side = side_of(usual(model)) if model.known else None
    return model if side in (None, model.positive_rudder) else replace(model, positive_rudder=side)


def common_side(records: Sequence[Record]) -> Side | None:
    """The side to which a positive rudder turns the ship in all records that tell it, where none of them says so."""
    sides = {r.name: told[0] for r in records if (told := steering_side(r)) is not None}
    if len({*sides.values()}) != 1 or any(r.meta.positive_rudder in (None, sides.get(r.name)) for r in records):
        return None
    return next(iter(sides.values()))


def to_side(record: Record, side: Side) -> Record:
    """The record with another side of a positive rudder, and its rudder as it is."""
    return replace(record, meta=replace(record.meta, positive_rudder=side))


def through_the_water(options: Options, records: Prepared) -> Options:
    """The options; where positions drift against the log, positions are not told: in a current they show the way over
    ground, and the model's runs, like the log, that through the water."""
    if options.coefficient_sd == 0.0 or records.behind_sensors(options.causes()).current is None:
        return options
    told = (c for c in options.channels or (*CHANNELS.values(), *INPUTS) if c not in POSITIONS)
    return replace(options, channels=tuple(told))


def _named(
    model: Model, records: Prepared, held_out: Sequence[Record], options: Options, watch: Callable[[str], object]
) -> tuple[Diagnosis, Diagnosis | None]:
    """What free runs of left-out pieces say, and nearly said (`ChoiceAndDiagnosis`); of a model that is stated to be
    exact, or where the records allow no pieces, what the likelihood of the innovations says, which also sees what is
    faint beside gusts.  The reason of the verdict then says why no pieces were asked."""
    why = ""
    if options.coefficient_sd != 0.0:
        watch(PIECES)
        try:
            with arithmetic_guard():
                answer = by_pieces(model, records, held_out, options)
                return answer.diagnosis, answer.nearly
        except (BadInput, CannotFit, FitFailed) as error:
            why = f"; judged by the innovations of a filter, without free runs of left-out pieces: {error}"
    watch(CAUSES)
    said = by_innovations(model, replace(records, train=behind_gear(model, records.train)), held_out, options)
    return replace(said, reason=said.reason + why), None


def _described(
    diagnosis: Diagnosis,
    records: Prepared,
    held_out: Sequence[Record],
    options: Options,
    watch: Callable[[str], object],
) -> Diagnosis:
    """The diagnosis with what describes the rest, where the records and the model allow it."""
    if diagnosis.verdict == "inconclusive" or options.only is not None:
        return diagnosis
    watch(REST)

    def rest() -> Diagnosis:
        return with_remaining(diagnosis, records.behind_sensors(options.causes()), held_out, options)

    diagnosis = _as_far_as_possible(rest, diagnosis, UNDESCRIBED)
    # a sensor that drifts looks between channels like steady errors of several
    doubtful = diagnosis.verdict == "unexplained" or worsens(diagnosis)
    if doubtful and any(f.stage == BY_CHANNELS for f in diagnosis.causes):

        def drift() -> Diagnosis:
            bare = without_causes(diagnosis, {f.cause for f in diagnosis.causes if f.stage == BY_CHANNELS}, INSTEAD)
            drifting = with_remaining(replace(bare, extended=diagnosis.model), records, held_out, options)
            return drifting if any(f.of_sensor for f in drifting.remaining) and not worsens(drifting) else diagnosis

        return _as_far_as_possible(drift, diagnosis, UNDESCRIBED)
    return diagnosis


def _with_forces_apart(diagnosis: Diagnosis, of_apart: Diagnosis) -> Diagnosis:
    """The diagnosis with forces in time that act in records which it is made without, of a diagnosis of these."""
    in_time = (force for force in of_apart.remaining if not force.extended and "time" in force.depends_on)
    forces = (f if f.span else replace(f, text=f"in {', '.join(diagnosis.apart)}, {f.text}") for f in in_time)
    return replace(diagnosis, remaining=(*diagnosis.remaining, *forces))


def _as_far_as_possible(step: Callable[[], Diagnosis], before: Diagnosis, what: str) -> Diagnosis:
    """The diagnosis after a further step; the one before it where the records or the model do not allow the step, and
    with a doubt that says what was not done and why where its arithmetic fails."""
    try:
        with arithmetic_guard():
            return step()
    except (BadInput, CannotFit):
        return before
    except FitFailed as error:
        return replace(before, doubts=(*before.doubts, f"{what}: {error}"))


def identified(model: Model, records: Sequence[Record]) -> Model:
    """The model with coefficients that an output-error fit to the records gives."""
    from ..methods.registry import make

    return make("output-error").fit(behind_gear(model, records), model.blanked()).model


def behind_gear(model: Model, records: Sequence[Record]) -> list[Record]:
    """Records behind the model's instruments, with the rudder's order behind the vessel's own gear."""
    return [corrected(record, gear_of(record, model)) for record in records]
