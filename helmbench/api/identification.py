"""Identification of a model from records, whether to believe it, and several models side by side."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from ..datasets.copies import check_no_copies
from ..estimation.estimates.estimate import Estimate
from ..models.argument_types import typed
from ..models.errors import BadInput, CannotFit
from .arguments import AUTO, METHOD, admit, as_model, as_records, listed, rudder_sign_doubt, warn_of

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..estimation.estimates.assessment import Assessment
    from ..estimation.estimates.comparison import Comparison
    from ..methods.base import Method
    from ..models.model import Model
    from .arguments import Path
    from .arguments import Path as FilePath

LEAST = 0.02
"""Share by which a built model must predict better ahead than the best family."""
NORMAL_90 = 1.6448536269514722


@typed
def identify(
    records: Record | Path | Sequence[Record | Path],
    model: Model | Path,
    method: Method | str | None = None,
    *,
    validate: Record | Path | Sequence[Record | Path] = (),
    positive_rudder: str | None = None,
    particulars: Model | Path | None = None,
) -> Estimate:
    """Identify the coefficients of a model from one record or several.

    The rudder sign of the records is changed to the model's, and what the model knows of its instruments is removed
    from them.

    Parameters
    ----------
    records : records, or paths of record files.
    model : the structure: a model, or a vessel id, a family id or the path of a model.json.  'auto' builds one from the
        records (`build_model`); with a method it also tries every family that needs no constants of a ship, and the
        vessels that the records name (`compare`), and takes the best of them where it predicts as well ahead or its
        free runs follow the records better.
    method : a method, or its text: 'output-error', 'ls,scheme=midpoint', 'tuned:ridge', 'my.py:Mine' (`list_methods`).
        None: 'output-error'; with 'auto' no method beside the built model.
    validate : held-out records: 'auto' chooses by them, and the model is judged by them (`assess`); without any 'auto'
        leaves out each record, or block of time, in turn.
    positive_rudder : 'port' or 'starboard', the side of a positive rudder in the files; overrides their sidecars.
    particulars : YAML file of the ship's particulars, for 'auto': the simulation that they give, corrected by the
        records, is taken where it predicts better ahead (`build_model`).

    Warns
    -----
    RudderSignWarning : the yaw response of a record contradicts its rudder sign.
    PlausibilityWarning : something else about a record is doubtful.

    Raises
    ------
    BadInput : a file, model or method cannot be used, a record is given twice, its numbers are in another unit than
        its columns say, or it is of another ship or scale than the model.
    CannotFit : the method does not suit the model, or a record lacks what it needs.
    FitFailed : no finite estimate was found.
    """
    from ..datasets.instruments import hull_record
    from ..datasets.yaw_response import RudderSignWarning
    from ..datasets.yaw_response import rudder_sign_doubt as sign_doubt
    from ..estimation.estimates.estimate import published
    from ..methods.registry import make

    if model == AUTO:
        read, others = as_records(records, positive_rudder), as_records(validate, positive_rudder)
        found = chosen_estimate(read, () if method is None else (method,), others, particulars)
        return replace(found, held_out=tuple(others))
    if particulars is not None:
        raise BadInput("particulars beside a model", hint="they go with the model 'auto'")
    chosen = METHOD if method is None else method
    structure, fitter = as_model(model), make(chosen) if isinstance(chosen, str) else chosen
    read, others = as_records(records, positive_rudder), as_records(validate, positive_rudder)
    check_no_copies(read, others)
    warn_of(admit(read, structure))
    given = [hull_record(record, structure) for record in read]
    estimate = published(fitter.fit(given, structure))
    for doubt in filter(None, map(sign_doubt, given)):
        warnings.warn(doubt, RudderSignWarning, stacklevel=2)
    return replace(estimate, records=tuple(read), held_out=tuple(others))


def chosen_estimate(
    train: Sequence[Record],
    methods: Sequence[Method | str],
    others: Sequence[Record],
    particulars: Model | Path | None = None,
) -> Estimate:
    """The model that is built from the records or, where it predicts as well ahead, the best family of all methods.

    Raises
    ------
    CannotFit : no model can be built, and no family fitted.
    """
    if not methods:
        return _estimate_built(train, others, particulars)
    found = compare(train, AUTO, methods, validate=others)
    best = estimate_of(found, train)
    try:
        built = _estimate_built(train, others, particulars)
    except CannotFit:
        return best
    return replace(built, comparison=found) if _better_ahead(built, best, others or train) else best


def _estimate_built(train: Sequence[Record], others: Sequence[Record], particulars: Model | Path | None) -> Estimate:
    """The model of `build_model` as an estimate, or the simulation of the particulars where that predicts better."""
    from ..diagnosis.craft.result import BUILT, SHIP
    from ..estimation.validation.horizons import mean_ratio
    from .diagnosis import build_model

    found = build_model(train, others, particulars=particulars)
    method, variant, model, covariance, message = "ladder", "windows", found.model, found.covariance, found.reason
    stderr = {n.name: (n.high - n.value) / NORMAL_90 for n in found.numbers}
    if found.ship is not None and mean_ratio(found.ahead.scores, SHIP, BUILT) < 1.0 - LEAST:
        method, variant, model, covariance, message = "particulars", "corrected", found.ship, None, found.notes[-1]
        stderr = {}
    return Estimate(
        method=method,
        variant=variant,
        model=model,
        coefficients=model.coefficients,
        covariance=covariance,
        parameters={name: float(value) for name, value in model.parameters.items()},
        stderr={name: stderr.get(name, float("nan")) for name in model.parameters},
        message=message,
        wall_s=found.wall_s,
        records=tuple(train),
    )


def _better_ahead(built: Estimate, best: Estimate, judged: Sequence[Record]) -> bool:
    """Whether errors ahead of the one are smaller than those of the other by more than LEAST, and its free runs are not
    worse where those of the other follow the records: windows of a single short record overlap, and tell little."""
    from ..estimation.estimates.assessment import POOR
    from ..estimation.records.naming import named
    from ..estimation.validation.horizons import mean_ratio
    from ..estimation.validation.validate import validate

    predictors = {} if best.predictor is None else {"best": best.predictor}
    try:
        found = validate({"built": built.model, "best": best.model}, named(judged), predictors)
    except BadInput:
        return False
    own, other = (found.score(None, model=name) for name in ("built", "best"))
    follows = own is not None and other is not None and other.r2 >= POOR
    return mean_ratio(found.scores, "built", "best") < 1.0 - LEAST and not (follows and own.r2 < other.r2)


def estimate_of(compared: Comparison, records: Sequence[Record]) -> Estimate:
    """The chosen estimate of a comparison, with its training records."""
    assert compared.chosen.estimate is not None, "the chosen candidate has an error, so it was fitted"
    return replace(compared.chosen.estimate, records=tuple(records), comparison=compared)


# ---- Whether to believe an estimate, and several side by side.


def assess(
    estimate: Estimate,
    records: Sequence[Record],
    validate: Record | FilePath | Sequence[Record | FilePath],
    found: Comparison | None,
    positive_rudder: str | None,
) -> Assessment:
    """What an estimate from these records is worth; raises as `Estimate.assess`."""
    from ..estimation.estimates import assessment

    others = as_records(validate, positive_rudder)
    check_no_copies(records, others)
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
    from ..estimation.estimates import comparison
    from ..methods.registry import make

    fitters = [(one, make(one)) if isinstance(one, str) else (one.name, one) for one in listed(methods)]
    train, others = as_records(records, positive_rudder), as_records(validate, positive_rudder)
    structures = candidate_models(models, train)
    _check(train, others, structures)
    entrants = [(model, text, fitter) for model in structures for text, fitter in fitters]
    return comparison.compare(entrants, train, others)


def candidate_models(models: Model | FilePath | Sequence[Model | FilePath], records: Sequence[Record]) -> list[Model]:
    """The structures that are compared."""
    from ..estimation.estimates.comparison import families_for

    found = [model for one in listed(models) for model in (families_for(records) if one == AUTO else [as_model(one)])]
    if not found:
        raise BadInput("no model to compare", hint="give one or more, or 'auto'")
    return found


def _check(train: Sequence[Record], others: Sequence[Record], models: Sequence[Model]) -> None:
    """Refuse records that cannot be what they say; warn of those that are doubtful."""
    from ..datasets.plausibility import check_plausible

    if not train:
        raise BadInput("no record to fit", hint="give at least one")
    doubts = [*admit(train, models[0]), *admit(others, models[0])]
    doubts += [str(told) for model in models[1:] for side in (train, others) for told in check_plausible(side, model)]
    check_no_copies(train, others)
    warn_of(list(dict.fromkeys(doubts)))
