"""A diagnosis by one bank and one criterion: check, correct, linearise, select, extend, measure the gain."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from ...estimation.records.series import MEASURED
from ...estimation.results.fit import arithmetic_guard, blas_limited
from ...estimation.selection.minimiser import minimise
from ...models.errors import BadInput
from ...models.model import CHANNELS
from ..beside_numbers import behind_sensors
from ..checked import with_checks
from ..diagnose import identified as identified_model
from ..gain.guard import WORSE
from ..gain.runs import with_runs
from ..prepared import corrected_records
from ..report.outcome import diagnosis_of
from .bank import Facts, bank_of
from .free_runs import FreeRuns
from .search import chosen, withdrawn
from .told import bank_lines, extended_model, findings, verdict
from .units import length_s, units_of

if TYPE_CHECKING:
    from ...checks.result import CheckFinding
    from ...datasets.record import Record
    from ...models.model import Model
    from ..options import Options
    from ..prepared import Prepared
    from ..result import Diagnosis
    from .search import Choice


def diagnose(model: Model, train: Sequence[Record], held_out: Sequence[Record], options: Options) -> Diagnosis:
    """Say what a model gets wrong about training records by free runs of pieces of them that were left out.

    Raises
    ------
    BadInput : for options that cannot be, or no training record.
    CannotFit : the records lack what free runs need.
    FitFailed : the arithmetic fails.
    """
    if not train:
        raise BadInput("no training record", hint="give at least one")
    clock = time.perf_counter(), time.process_time()
    options = options.checked(model)
    with arithmetic_guard(), blas_limited():
        given = corrected_records(model, train, held_out, options)
        given = behind_sensors(given, given.sensors(options.causes()))
        if options.base_parameters == "identify":
            model = identified_model(model, given.train)
        checks = of_training(given.checked, train)
        doubted = {name for f in given.checked if f.standing for name in f.records}
        found = _useful(model, given, [r for r in held_out if r.name not in doubted], options)
    found = with_checks(found, checks, (*given.train, *given.held_out))
    roles = [(r.name, "train") for r in train] + [(r.name, "held_out") for r in held_out]
    wall_s, cpu_s = time.perf_counter() - clock[0], time.process_time() - clock[1]
    return replace(found, records=tuple(roles), wall_s=wall_s, cpu_s=cpu_s)


def of_training(checks: Sequence[CheckFinding], train: Sequence[Record]) -> tuple[CheckFinding, ...]:
    """What the files show; of what stands in held-out records only, nothing stands in the way of the training ones."""
    names = {r.name for r in train}
    return tuple(f if names & {*f.records} else replace(f, standing=False) for f in checks)


def _useful(model: Model, given: Prepared, held_out: Sequence[Record], options: Options) -> Diagnosis:
    """The diagnosis; what worsens held-out records is withdrawn, the last that entered first."""
    choice = chosen(runs_of(model, given.train, options), options)
    while True:
        found = with_runs(
            _concluded(model, given, choice, options), given.train, given.instruments, held_out, options.channels
        )
        rest = withdrawn(choice) if _worse(found) else None
        if rest is None:
            return found
        choice = rest


def runs_of(model: Model, records: Sequence[Record], options: Options) -> FreeRuns:
    """The free runs of pieces of records behind the model's instruments, over the whole bank."""
    length = length_s(model, records)
    measured = {s for s in MEASURED if s in model.states and any(r.has(CHANNELS[s]) for r in records)}
    commanded = not any(r.has("rudder_rad") for r in records)
    identified, exact = options.base_parameters == "identify", options.coefficient_sd == 0.0
    facts = Facts(measured, commanded, len(records), identified, exact)
    bank = bank_of(model, facts, length, options.only)
    return FreeRuns(bank, units_of(bank.model, records, length), length)


def _worse(found: Diagnosis) -> bool:
    """Whether some channel of the held-out records is predicted worse, also with each record's own trim."""
    return any(g.own_after > WORSE * g.own_before and g.rmse_after > WORSE * g.rmse_before for g in found.gain.values())


def _concluded(model: Model, given: Prepared, choice: Choice, options: Options) -> Diagnosis:
    """The diagnosis without its gain."""
    by_runs = findings(choice, options.base_parameters == "identify")
    known = {f.cause for f in given.shown.findings}
    every = [*given.shown.findings, *(f for f in by_runs if f.cause not in known)]
    extended = extended_model(model, choice, given.instruments)
    said = verdict(choice, every, options.coefficient_sd == 0.0)
    found = diagnosis_of((model, extended), options, said, every, bank_lines(choice, every), noise={})
    return replace(found, of_held_out=of_held_out(model, choice, given))


def of_held_out(model: Model, choice: Choice, given: Prepared) -> dict[str, dict[str, float]]:
    """Held-out record -> the flow of its own, estimated on its first half; none where no record has its own."""
    out: dict[str, dict[str, float]] = {}
    for candidate in choice.selection.candidates:
        flows = [n for n in candidate.names if choice.runs.bank.places[n].record is not None]
        for record in given.held_out if flows else ():
            half = record.slice(0, record.n // 2)
            runs = FreeRuns(choice.runs.bank, units_of(choice.runs.bank.model, [half], choice.runs.length_s),
                            choice.runs.length_s)  # fmt: skip
            fixed = {n: x for n, x in choice.selection.final.point.values.items() if n not in flows}
            numbers = [replace(n, name=n.name.partition(":")[0]) for n in candidate.numbers[:2]]
            fitted = minimise(runs, numbers, fixed, runs.no_own)
            out.setdefault(record.name, {}).update({n.name: fitted.value(n.name) for n in numbers})
    return out
