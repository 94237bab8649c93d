"""Diagnosis and calibration of a model with records, and a model of a craft from its records alone."""

from __future__ import annotations

import sys
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar

from ..diagnosis.calibration.result import Calibration
from ..diagnosis.craft.result import CraftDiagnosis
from ..diagnosis.result import Diagnosis
from ..models.argument_types import typed
from ..models.errors import BadInput
from ..models.model import CHANNELS
from .arguments import as_model, as_records, doubts_of, faults_of, labels, require_trustworthy

if TYPE_CHECKING:
    from ..checks.result import CheckFinding
    from ..datasets.plausibility import Doubt
    from ..datasets.record import Record
    from ..models.model import Model
    from .arguments import Path as FilePath

Told = TypeVar("Told", Diagnosis, Calibration, CraftDiagnosis)
READING = "reading the model and the records"
SHORT_CHANNELS = {"heading": "psi", "yaw_rate": "r", "surge": "u", "sway": "v", "north": "x", "east": "y"}
"""Short names of channels -> states."""


@typed
def diagnose(
    model: Model | FilePath,
    train: Record | FilePath | Sequence[Record | FilePath],
    held_out: Record | FilePath | Sequence[Record | FilePath] = (),
    *,
    base_parameters: str | None = None,
    coefficient_sd: float | None = None,
    channels: Sequence[str] | None = None,
    max_effects: int = 3,
    alpha: float = 0.01,
    seed: int = 0,
    causes: Sequence[str] | None = None,
    positive_rudder: str | None = None,
    progress: bool | Callable[[str], object] = False,
) -> Diagnosis:
    """Find what a model gets wrong about records, name the cause, extend the model and measure the gain.

    Parameters
    ----------
    model : a model, or a vessel id, a family id or the path of a model.json.
    train : one record or several, or paths of record files: the causes are named and fitted with these.
    held_out : likewise; the gain is measured with these, and they take no part in naming or fitting.
    base_parameters : 'file' takes the model's coefficients as known, 'identify' estimates them with the causes; None:
        'file' where the model has coefficients.
    coefficient_sd : relative standard deviation of known coefficients; 0: they are exact; None: the family's priors
        hold, scaled by the records themselves, and causes are named beside them.
    channels : the channels to use: 'heading', 'yaw_rate', 'surge', 'sway', 'north', 'east', or names of record columns;
        None: all.
    max_effects : largest number of causes that are named together.
    alpha : family-wise error level of the whole diagnosis, between 0 and 0.5.
    seed : seed of the random numbers of bootstraps.
    causes : the only causes to test (`list_causes`); None: all.
    positive_rudder : 'port' or 'starboard', the side of a positive rudder in the files; overrides their sidecars.
    progress : show on standard error which stage the diagnosis is in; or a function that is called with every stage
        when it begins.

    Raises
    ------
    BadInput : a file, model or option cannot be used, a record is given twice or on both sides, or its numbers are in
        another unit than its columns say.
    FitFailed : the model cannot be run with the records, or the arithmetic fails.
    CannotFit : the records lack what a diagnosis needs: the rudder, and heading or yaw rate.
    """
    from ..models.cache import FIRST_USE

    with shown_stages(progress) as watch, FIRST_USE.told_to(watch):
        watch(READING)
        from ..diagnosis import diagnose as engine
        from ..diagnosis.gain.runs import with_errors_ahead
        from ..diagnosis.options import Options
        from ..models.parameter_checks import unusual_numbers

        base = as_model(model)
        only = None if causes is None else tuple(causes)
        options = Options(base_parameters, coefficient_sd, _columns(channels), max_effects, alpha, seed, only)
        options.checked(base)
        *given, doubts = both_sides(base, train, held_out, positive_rudder)
        records, others = ([record.turned(base.positive_rudder) for record in side] for side in given)
        found = with_errors_ahead(engine.diagnose(base, records, others, options, watch))
    left = [str(doubt) for doubt in doubts if not _corrected(doubt, found.checks)]
    doubts = (*unusual_numbers(base), *left, *doubts_of(found.checks, base), *found.doubts)
    return _told_of(found, train, held_out, doubts)


def _corrected(doubt: Doubt, checks: Sequence[CheckFinding]) -> bool:
    """Whether a doubt about a record is of columns that were corrected as a whole."""
    own = (f for f in checks if f.corrected and not f.blanked and doubt.record in f.records)
    return any(doubt.is_about(f.channels) for f in own)


def _told_of(
    found: Told,
    train: Record | FilePath | Sequence[Record | FilePath],
    held_out: Record | FilePath | Sequence[Record | FilePath],
    doubts: Sequence[str],
) -> Told:
    """The result with its records as they were given, and what is doubtful about them."""
    roles = [role for _, role in found.records]
    names = zip([*labels(train), *labels(held_out)], roles, strict=True)
    return replace(found, records=tuple(names), doubts=tuple(doubts))


@contextmanager
def shown_stages(
    progress: bool | Callable[[str], object], doing: str = "diagnosis:"
) -> Generator[Callable[[str], object]]:
    """A function that shows the stage of what is done on standard error, and how long it has taken, where asked."""
    if callable(progress):
        yield progress
        return
    from tqdm import tqdm

    with tqdm(disable=not progress, file=sys.stderr, leave=False, bar_format="{desc} [{elapsed}]") as bar:
        yield lambda stage: bar.set_description_str(f"{doing} {stage}")


def _columns(names: Sequence[str] | None) -> tuple[str, ...] | None:
    """Short names or names of record columns as names of record columns; None: all that the records have."""
    if names is None:
        return None
    columns = {short: CHANNELS[state] for short, state in SHORT_CHANNELS.items()}
    known = columns | {column: column for column in columns.values()}
    for name in names:
        if name not in known:
            raise BadInput(f"channels: unknown channel {name!r}", hint=f"known: {', '.join(columns)}")
    return tuple(dict.fromkeys(known[name] for name in names))


def training_and_held_out(
    model: Model,
    train: Record | FilePath | Sequence[Record | FilePath],
    held_out: Record | FilePath | Sequence[Record | FilePath],
    positive_rudder: str | None,
) -> tuple[list[Record], list[Record], tuple[str, ...]]:
    """As `both_sides`, with what checks of the files find doubtful about the records."""
    records, others, doubts = both_sides(model, train, held_out, positive_rudder)
    found = (told for side in (records, others) for told in doubts_of(faults_of(side, model), model))
    return records, others, (*map(str, doubts), *found)


def both_sides(
    model: Model,
    train: Record | FilePath | Sequence[Record | FilePath],
    held_out: Record | FilePath | Sequence[Record | FilePath],
    positive_rudder: str | None,
) -> tuple[list[Record], list[Record], tuple[Doubt, ...]]:
    """Records of both sides, read where they are paths, and what is doubtful about their numbers.

    Raises
    ------
    BadInput : a file cannot be used, a run is given twice or on both sides, its numbers are in another unit than its
        columns say, or it is of another ship or scale than the model.
    """
    from ..datasets.copies import check_no_copies
    from ..datasets.plausibility import check_plausible

    records, others = as_records(train, positive_rudder), as_records(held_out, positive_rudder)
    check_no_copies(records, others)
    return records, others, (*check_plausible(records, model), *check_plausible(others, model))


@typed
def calibrate(
    model: Model | FilePath,
    train: Record | FilePath | Sequence[Record | FilePath],
    held_out: Record | FilePath | Sequence[Record | FilePath] = (),
    *,
    positive_rudder: str | None = None,
) -> Calibration:
    """Find which numbers of a model are wrong and by how much, by free runs of pieces of records that were left out.

    The choice, its sizes and the extended model are those of `diagnose`: coefficients, constants and causes of rudder,
    sensors and weather enter one after the other, as long as they predict pieces better that took no part in the fit.

    Parameters
    ----------
    model : a 3-DOF model with coefficients, a vessel id or the path of a model.json.
    train : one record or several, or paths of record files.
    held_out : likewise; they take no part in the fit, but what worsens them is withdrawn.
    positive_rudder : 'port' or 'starboard', the side of a positive rudder in the files; overrides their sidecars.

    Raises
    ------
    BadInput : a file or model cannot be used, a record is given twice or on both sides, or its numbers are in another
        unit than its columns say.
    FitFailed : the model cannot be run with the records, or the arithmetic fails.
    CannotFit : the records lack what free runs need, or are too short to leave a part out.
    """
    from ..diagnosis.calibration.calibrate import calibrate as engine

    base = as_model(model)
    records, others, doubts = training_and_held_out(base, train, held_out, positive_rudder)
    require_trustworthy([*records, *others], base)
    found = engine(base, records, others)
    return _told_of(found, train, held_out, (*doubts, *found.doubts))


@typed
def build_model(
    train: Record | FilePath | Sequence[Record | FilePath],
    held_out: Record | FilePath | Sequence[Record | FilePath] = (),
    *,
    positive_rudder: str | None = None,
    particulars: Model | FilePath | None = None,
    progress: bool | Callable[[str], object] = False,
) -> CraftDiagnosis:
    """Build a model of a craft for which none is known, and say how far ahead it can be trusted.

    The records tell what steers the craft (a rudder in the flow, a rudder in a propeller's race, thrusters), and then
    one lack of the simpler model after the other: neutral angle, damping that grows with the yaw rate, delay, rate
    limit and lag, asymmetry, wind.  Models are fitted to short windows and judged by blocks of time that were left out.
    Measured speed, revolutions and wind are inputs.

    Parameters
    ----------
    train : one record or several, or paths of record files, with rudder or command, and heading or yaw rate.
    held_out : likewise; they take no part in the choice, but the model is not worse along them than the law alone.
    positive_rudder : 'port' or 'starboard', the side of a positive rudder in the files; overrides their sidecars.
    particulars : YAML file of the ship's particulars (docs/mathematics/craft.md), or another simulation of surge, sway
        and yaw: it is corrected by the training records and told beside the built model, `ship` of the outcome.
    progress : show on standard error which stage it is in; or a function that is called with every stage when it
        begins.

    Raises
    ------
    BadInput : a file cannot be used, a record is given twice or on both sides, or its numbers are in another unit than
        its columns say.
    CannotFit : the records hold no yaw motion, the rudder or command never moves, or all stretches are too short.
    """
    from ..models.cache import FIRST_USE

    with shown_stages(progress) as watch, FIRST_USE.told_to(watch):
        watch(READING)
        from ..diagnosis.craft.build import build
        from ..models.model import resolve

        ship = None if particulars is None else as_model(particulars)
        records, others, doubts = training_and_held_out(resolve("nomoto-1"), train, held_out, positive_rudder)
        found = build(records, others, ship, watch)
    return _told_of(found, train, held_out, doubts)
