"""Whether to believe an estimate, and several side by side: outcomes with page, table, figure and files."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..estimation.estimates import assessment, comparison
from ..estimation.estimates.assessment import Assessment
from ..estimation.estimates.comparison import Comparison
from ..models.argument_types import typed
from ..models.errors import BadInput
from .admission import admit, refuse_copies, rudder_sign_doubt, warn_of
from .arguments import AUTO, as_model, as_records

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..estimation.estimates.estimate import Estimate
    from ..methods.base import Method
    from ..models.model import Model
    from .arguments import Path as FilePath


def assess(
    estimate: Estimate,
    records: Sequence[Record],
    validate: Record | FilePath | Sequence[Record | FilePath],
    found: Comparison | None,
    positive_rudder: str | None,
) -> Assessment:
    """What an estimate from these records is worth; raises as `Estimate.assess`."""
    others = as_records(validate, positive_rudder)
    refuse_copies(records, others)
    signs = (rudder_sign_doubt(record, estimate.model) for record in (*records, *others))
    doubts = [*admit(records, estimate.model), *admit(others, estimate.model), *filter(None, signs)]
    biases = None
    if estimate.predictor is None and estimate.parameters:
        from ..diagnosis.one_bank.biases import biases_of

        biases = biases_of(estimate.model, records)
    return assessment.assess(estimate, records, others, found, doubts, biases)


@typed
def compare(
    records: Record | FilePath | Sequence[Record | FilePath],
    models: Model | FilePath | Sequence[Model | FilePath],
    methods: Method | str | Sequence[Method | str],
    *,
    validate: Record | FilePath | Sequence[Record | FilePath] = (),
    positive_rudder: str | None = None,
) -> Comparison:
    """Fit models by methods, every one by every other, and compare them on records that took no part in the fit.

    With records in `validate` each is fitted once and run freely along those.  Without, each record is left out in
    turn, or blocks of time where there is only one.  A candidate that does not apply or fails stays in the table with
    its reason.

    Parameters
    ----------
    records : records, or paths of record files.
    models : one structure or several; 'auto' takes every family that needs no constants of a ship, and the vessels
        that the records name.
    methods : one method or several, or their texts (`list_methods`).
    validate : records that were held out, likewise.
    positive_rudder : 'port' or 'starboard', the side of a positive rudder in the files; overrides their sidecars.

    Warns
    -----
    PlausibilityWarning : something about a record is doubtful.

    Raises
    ------
    BadInput : a file, model or method cannot be used, a record is given twice, its numbers are in another unit than its
        columns say, or a single record is too short to be cut.
    CannotFit : no candidate can be fitted, or the runs of all of them diverge.
    """
    from ..methods.base import Method
    from ..methods.registry import make

    given = [methods] if isinstance(methods, Method | str) else list(methods)
    fitters = [(one, make(one)) if isinstance(one, str) else (one.name, one) for one in given]
    train, others = as_records(records, positive_rudder), as_records(validate, positive_rudder)
    structures = candidate_models(models, train)
    _check(train, others, structures)
    entrants = [(model, text, fitter) for model in structures for text, fitter in fitters]
    return comparison.compare(entrants, train, others)


def candidate_models(models: Model | FilePath | Sequence[Model | FilePath], records: Sequence[Record]) -> list[Model]:
    """The structures that are compared."""
    from os import PathLike

    from ..estimation.estimates.comparison import families_for
    from ..models.model import Model

    listed = [models] if isinstance(models, Model | str | PathLike) else list(models)
    found = [model for one in listed for model in (families_for(records) if one == AUTO else [as_model(one)])]
    if not found:
        raise BadInput("no model to compare", hint="give one or more, or 'auto'")
    return found


def _check(train: Sequence[Record], others: Sequence[Record], models: Sequence[Model]) -> None:
    """Refuse records that cannot be what they say; warn of those that are doubtful."""
    from ..datasets.plausibility import check_plausible

    if not train:
        raise BadInput("no record to fit", hint="give at least one")
    doubts = [*admit(train, models[0]), *admit(others, models[0])]
    doubts += [told for model in models[1:] for side in (train, others) for told in check_plausible(side, model)]
    refuse_copies(train, others)
    warn_of(list(dict.fromkeys(doubts)))
