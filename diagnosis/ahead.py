"""Errors some time ahead of a diagnosis' models, beside the sensors' noise and two predictions without a model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from ..estimation.records.naming import named
from ..estimation.results.fit import arithmetic_guard
from ..estimation.validation.validate import validate
from ..models.errors import BadInput, FitFailed

if TYPE_CHECKING:
    from ..datasets.record import Record
    from .result import Diagnosis

EXTENDED = "extended model"


def with_errors_ahead(diagnosis: Diagnosis, records: Sequence[Record]) -> Diagnosis:
    """The diagnosis with errors ahead along records: those held out, or else those of training.

    The extended model stands first.  Without a model that can be run along the records it stays as it is.
    """
    models = {EXTENDED: diagnosis.extended} if diagnosis.extends else {}
    models |= {diagnosis.model.id: diagnosis.model}
    known = {name: model for name, model in models.items() if model.known}
    try:
        with arithmetic_guard():
            return replace(diagnosis, ahead=validate(known, named(records))) if known else diagnosis
    except (BadInput, FitFailed):
        return diagnosis
