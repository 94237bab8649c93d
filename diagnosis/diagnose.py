"""The steps of a diagnosis: gross faults, base parameters, causes, what is unexplained, extended model, gain."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..estimation.results.fit import arithmetic_guard, blas_limited
from ..models.errors import BadInput, CannotFit, FitFailed
from ..models.memory import require_memory
from .beside_numbers import behind_sensors, of_uncertain_base
from .by_free_runs import by_free_runs, refused_by_free_runs
from .by_residuals import concluded, selected
from .causes.base_coefficients import BaseCoefficients
from .checked import put_back, with_checks
from .gain.guard import log_fall, training_errors
from .gain.runs import with_runs
from .one_bank.diagnose import by_pieces
from .one_bank.remaining import with_remaining
from .options import Options
from .prepared import Prepared, corrected_records, without_doubtful
from .result import Diagnosis
from .starting import thinned

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model
    from .one_bank.diagnose import ByPieces

CHECKS, BASE_MODEL = "checks of sensors and files", "identification of the base model"
PIECES, FREE_RUNS = "free runs of left-out pieces", "free runs of left-out records"
CAUSES_BESIDE = "causes beside an uncertain base model"
CAUSES = "causes and gain"
REST = "forces that describe the rest"
"""Stages of a diagnosis; not every diagnosis has all of them."""


LONGEST, LONGEST_OF_RESPONSE = 15_000, 30_000
"""Samples that one record of a 3-DOF and of a response model may have: those of hours, in which a log does more than
manoeuvres; more could take over two minutes."""
LARGEST = 4 * 2**30
"""Memory, bytes, that the records of one diagnosis may need."""
LEFT = 0.1
"""Error, as a share of the motion, below which a diagnosis leaves nothing that another one could take off."""
CLEARLY, FAR = 0.1, 0.5
"""Mean of the logarithms of two errors' ratio from which one is clearly smaller, and so much smaller that a calibration
of all numbers is told in the place of names."""
SAMPLE_BYTES, STATE_BYTES = 16_000, 8_000
"""Memory of a sample and of each of its states, not less than measured: 57 kB a sample of six states, 31 of three."""


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
    if not train:
        raise BadInput("no training record", hint="give at least one")
    started = time.perf_counter(), time.process_time()
    watch(CHECKS)
    given, aside = without_doubtful(corrected_records(model, train, held_out, options))
    _require_room(model, given)
    if options.base_parameters == "identify":
        given = behind_sensors(given, given.sensors(options.causes()))
        watch(BASE_MODEL)
        model = identified(model, given.train)
    held = put_back(given.recorded, given.faults, model)
    found = _described(_found(model, given, held, options, watch), given, held, options, watch)
    found = with_checks(found, given.checked, (*given.train, *given.held_out))
    roles = [(r.name, "train") for r in train] + [(r.name, "held_out") for r in held_out]
    wall_s, cpu_s = time.perf_counter() - started[0], time.process_time() - started[1]
    return replace(found, records=tuple(roles), doubts=(*aside, *found.doubts), wall_s=wall_s, cpu_s=cpu_s)


def _found(
    model: Model, given: Prepared, held_out: Sequence[Record], options: Options, watch: Callable[[str], object]
) -> Diagnosis:
    """What free runs of left-out pieces say where they decide and whole free runs err little; else what the likelihood
    says, which also sees what is faint beside gusts; but again what the free runs name where that explains nothing or
    predicts worse.

    A model that is stated to be exact is judged by the likelihood alone.
    """
    pieces = None
    if options.coefficient_sd != 0.0:
        watch(PIECES)
        pieces = _by_pieces(model, given, held_out, options)
        if pieces is not None and pieces.decisive and _left(pieces.diagnosis) <= LEFT:
            return pieces.diagnosis
    likely = _by_likelihood(model, given, options, watch)
    likely = with_runs(likely, given.train, given.instruments, held_out, options.channels)
    if pieces is not None and likely.verdict == "unexplained" and pieces.diagnosis.verdict == "adequate":
        return _enough(likely, pieces.diagnosis)
    if pieces is None or not pieces.names or likely.verdict in ("inconclusive", "adequate"):
        return likely
    better = _left(likely) > LEFT and _fall(likely, pieces.diagnosis) > (CLEARLY if pieces.selects else FAR)
    return pieces.diagnosis if likely.verdict == "unexplained" or better else likely


def _enough(likely: Diagnosis, adequate: Diagnosis) -> Diagnosis:
    """What is told where the likelihood leaves an effect that it cannot explain, and free runs of left-out pieces none
    that matters: the causes that it names, where these take the free runs to an error that does not matter, else that
    the model is adequate; the likelihood's own answer where free runs of whole records err by more."""
    own = [f for f in likely.causes if f.cause != BaseCoefficients.id]
    if own and _fall(adequate, likely) > CLEARLY and _left(likely) <= LEFT:
        verdict = "tied" if any(f.tied_with for f in own) else "named"
        said = f"with what is named, free runs err by {100.0 * _left(likely):.1f} % of the motion"
        return replace(likely, verdict=verdict, reason=said, hypothesis=None)
    return adequate if _left(adequate) <= LEFT else likely


def _described(
    found: Diagnosis, given: Prepared, held_out: Sequence[Record], options: Options, watch: Callable[[str], object]
) -> Diagnosis:
    """The diagnosis with what describes the rest, where the records and the model allow it."""
    if found.verdict == "inconclusive" or not found.model.is_3dof or options.only is not None:
        return found
    watch(REST)
    try:
        with arithmetic_guard():
            cleaned = behind_sensors(given, given.sensors(options.causes()))
            return with_remaining(found, cleaned, held_out, options)
    except (BadInput, CannotFit, FitFailed):
        return found


def _left(diagnosis: Diagnosis) -> float:
    """Error of the extended model's free runs as a share of the motion, mean over channels: of held-out records, else
    of training ones."""
    if diagnosis.gain:
        shares = [np.sqrt(max(1.0 - g.r2_after, 0.0)) for g in diagnosis.gain.values()]
    else:
        shares = [error / motion for error, motion in training_errors(diagnosis).values() if motion > 0.0]
    known = [share for share in shares if np.isfinite(share)]
    return float(np.mean(known)) if known else 0.0


def _fall(old: Diagnosis, new: Diagnosis) -> float:
    """By how much the logarithm of the error falls, in the mean over channels, from the extended model of one diagnosis
    to that of another one: of held-out records, each with its own neutral angle and start, and 0 at most where blind
    runs err by more; else of training ones.

    Eq. 11 of docs/mathematics/pieces.md.
    """
    if not new.gain:
        return log_fall(*({c: error for c, (error, _) in training_errors(d).items()} for d in (old, new)))
    own, blind = (
        log_fall(*({c: getattr(g, name) for c, g in d.gain.items()} for d in (old, new)))
        for name in ("own_after", "rmse_after")
    )
    return own if blind > 0.0 else min(own, 0.0)


def _by_pieces(model: Model, given: Prepared, held_out: Sequence[Record], options: Options) -> ByPieces | None:
    """What free runs of pieces say; None where the records or the model allow none, or their arithmetic fails."""
    try:
        with arithmetic_guard():
            return by_pieces(model, given, held_out, options)
    except (BadInput, CannotFit, FitFailed):
        return None


def _by_likelihood(model: Model, given: Prepared, options: Options, watch: Callable[[str], object]) -> Diagnosis:
    """The diagnosis with the base model's numbers uncertain, or as they are where that gains nothing or is asked.

    Where the model as it is leaves effects unexplained, its residuals do not decide on sensors that the channels have
    decided on without it.
    """
    if options.base_parameters == "file" and options.coefficient_sd is None:
        watch(CAUSES_BESIDE)
        beside, cleaned, felt, subsets, regimes = of_uncertain_base(model, given, options)
        if beside is None:
            watch(CAUSES)
            beside = concluded(model, given, options, selected(model, given, options))
            if beside.verdict != "unexplained":
                return beside
            if cleaned.decided:
                beside = concluded(model, cleaned, options, selected(model, cleaned, options))
        watch(FREE_RUNS)
        told = by_free_runs(beside, cleaned, felt, subsets, regimes())
        if told.verdict != "unexplained" or model.is_3dof:
            return told
        return by_free_runs(told, cleaned, felt, identified=True)
    watch(CAUSES)
    shown = selected(model, given, options)
    found = concluded(model, given, options, shown)
    if options.base_parameters != "identify" or found.verdict != "unexplained" or model.is_3dof:
        return found
    watch(FREE_RUNS)
    told = by_free_runs(found, given, given, identified=True)
    refused = refused_by_free_runs(told)
    if told.verdict != "unexplained" or not refused & {f.cause for f in found.causes}:
        return told
    return replace(concluded(model, given, options, shown, refused), calibration=told.calibration)


def _require_room(model: Model, given: Prepared) -> None:
    """Refuse records that are too long before anything of size is computed.

    Raises
    ------
    BadInput : a record has more samples than one may, or their filter needs more memory than is free, or than LARGEST.
    """
    records = thinned([*given.train, *given.held_out], model)
    longest, limit = max(records, key=lambda record: record.n), LONGEST if model.is_3dof else LONGEST_OF_RESPONSE
    if longest.n > limit:
        hint = f"cut out the manoeuvres, or take a longer step: at most {limit} samples a record"
        raise BadInput(f"{longest.name}: {longest.n} samples are too many for one record of a diagnosis", hint=hint)
    samples = sum(record.n for record in records)
    of_sample = SAMPLE_BYTES + STATE_BYTES * len(model.states)
    what = f"{samples} samples of {len(records)} record{'s' if len(records) > 1 else ''}"
    require_memory(samples * of_sample, what)
    most = LARGEST // of_sample
    if samples > most:
        hint = f"cut out the manoeuvres, or take a longer step: at most {most} samples of this model"
        raise BadInput(f"{what} are too many for one diagnosis", hint=hint)


def identified(model: Model, records: Sequence[Record]) -> Model:
    """The model with coefficients that an output-error fit to the records gives."""
    from ..methods.registry import make

    return make("output-error").fit(records, model.blanked()).model
