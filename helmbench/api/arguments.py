"""Models and records, or what stands for them, as arguments; which records are taken, and with which doubts."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Sequence
from os import PathLike, fspath
from typing import TYPE_CHECKING, Any

from ..datasets.record import Record
from ..models.argument_types import typed
from ..models.errors import BadInput
from ..models.result import FilePath as Path

if TYPE_CHECKING:
    from ..checks.result import CheckFinding
    from ..models.model import Model

AUTO = "auto"
"""Stands for every model that the records allow."""
METHOD = "output-error"
"""The method that identifies where none is named."""


def as_model(model: Model | Path) -> Model:
    """The model itself, or the one that an identifier or a path stands for; BadInput where there is none."""
    from ..models.model import Model, resolve

    return model if isinstance(model, Model) else resolve(model)


def as_records(records: Record | Path | Sequence[Record | Path], positive_rudder: str | None = None) -> list[Record]:
    """One record or several, read where they are paths; BadInput where a file cannot be used or has no rudder."""
    from ..datasets.io import read_record

    read = []
    for one in listed(records):
        record = read_record(one, positive_rudder) if isinstance(one, str | PathLike) else one
        try:
            record.rudder()
        except BadInput as error:
            file = fspath(one) if isinstance(one, str | PathLike) else record.name
            raise BadInput(error.message, file=file, column=error.column, hint=error.hint) from error
        read.append(record)
    return read


def listed(given: Any) -> list[Any]:
    """One record, model, method, text or path, or several, as a list."""
    return [given] if isinstance(given, str) or not isinstance(given, Iterable) else list(given)


def labels(records: Record | Path | Sequence[Record | Path]) -> list[str]:
    """What results call the records: paths as they were given, or the records' names."""
    return [one.name if isinstance(one, Record) else fspath(one) for one in listed(records)]


# ---- Which records are taken: refused where their numbers cannot be what they say, else with their doubts.


def admit(records: Sequence[Record], model: Model) -> tuple[str, ...]:
    """What is doubtful about records of the model's ship, one sentence each.

    Raises
    ------
    BadInput : records hold a run twice, their numbers are in another unit than their columns say, or they are of
        another ship or scale than the model.
    """
    from ..datasets.plausibility import check_plausible

    return (*map(str, check_plausible(records, model)), *doubts_of(faults_of(records, model), model))


def doubts_of(findings: Sequence[CheckFinding], model: Model) -> tuple[str, ...]:
    """What checks of the files found that makes a model of the records doubtful, one sentence each."""
    from ..checks.result import sentence_of

    return tuple(sentence_of(f) for f in findings if f.standing or _biases(f, model))


def _biases(finding: CheckFinding, model: Model) -> bool:
    """Whether a model's fit to the records as they are would be wrong by a fault: what only a correction removes, in
    columns that the model follows."""
    from ..models.model import CHANNELS

    followed = {CHANNELS[s] for s in model.states if s in CHANNELS}
    return finding.biases and (finding.cause == "time_stamps" or not followed.isdisjoint(finding.channels))


@typed
def rudder_sign_doubt(record: Record, model: Model) -> str | None:
    """A sentence if the record's yaw response contradicts its rudder sign, else None.

    The record is taken behind the model's instruments; one that does not say its sign has the model's.  A first-order
    response to the rudder is fitted by least squares, and its gain must have the sign of the rudder.
    """
    from ..datasets.instruments import hull_record
    from ..datasets.yaw_response import rudder_sign_doubt as doubt

    return doubt(hull_record(record, model))


def warn_of(doubts: Sequence[str]) -> None:
    """Issue a PlausibilityWarning for every doubt."""
    from ..datasets.plausibility import PlausibilityWarning

    for doubt in doubts:
        warnings.warn(doubt, PlausibilityWarning, stacklevel=4)


def require_trustworthy(records: Sequence[Record], model: Model) -> None:
    """Refuse records that no statement about the hull can be made from.

    Raises
    ------
    BadInput : naming the record, what is wrong with it and what to do.
    """
    for found in faults_of(records, model):
        if found.standing:
            hint = "nothing can be said of the hull while that stands: correct the record, or leave it out"
            raise BadInput(found.evidence, file=", ".join(found.records), column=found.channels[0], hint=hint)


def faults_of(records: Sequence[Record], model: Model) -> tuple[CheckFinding, ...]:
    """What is wrong with the files and matters."""
    from ..datasets.instruments import corrected
    from ..diagnosis.prepared import examined

    return examined([corrected(r.turned(model.positive_rudder), model.instruments) for r in records], model).checked
