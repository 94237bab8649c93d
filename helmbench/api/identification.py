"""Simulation of manoeuvres with a model, and identification of a model from records, with its page and files."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from ..datasets.record import Record
from ..estimation.estimates.estimate import Estimate
from ..models.argument_types import typed
from ..models.errors import BadInput, CannotFit
from .admission import admit, refuse_copies, warn_of
from .arguments import AUTO, METHOD, as_model, as_records, check_numbers, check_seed

if TYPE_CHECKING:
    from ..estimation.estimates.comparison import Comparison
    from ..methods.base import Method
    from ..models.model import Model
    from .arguments import Path

LEAST = 0.02
"""Share by which a built model must predict better ahead than the best family."""
NORMAL_90 = 1.6448536269514722


@typed
def simulate(
    model: Model | Path,
    manoeuvre: str,
    *,
    noise: str = "none",
    disturbance: str = "none",
    seed: int = 0,
    duration_s: float | None = None,
    dt_s: float | None = None,
) -> Record:
    """Simulate a manoeuvre of a model with coefficients, and measure it.

    As `generate`, which takes its texts from a `Case`, but also for a model that was made in Python, such as
    `estimate.model`.

    Parameters
    ----------
    model : a model, or a vessel id or the path of a model.json.
    manoeuvre : for example 'zigzag:20/20' or 'turn:35:port' (`list_manoeuvres`).
    noise : 'none', 'low', 'medium', 'high', 'gross', or channels such as 'yaw_rate=0.05deg_s'.
    disturbance : 'none', or 'wind:12@40deg', 'current:...', 'waves:...', joined by '+'.
    seed : seed of all random numbers, at least 0.
    duration_s : duration, s; None: that of the vessel file.
    dt_s : sampling step, s; None: that of the vessel file.

    Returns
    -------
    The record, with the rudder in the model's sign; the same for the same arguments.

    Raises
    ------
    BadInput : an unknown vessel, a malformed text, a disturbance that the model cannot take, no duration or step, or a
        run that diverges.
    """
    from ..datasets.disturbances import parse_disturbance
    from ..datasets.generator import record_run
    from ..datasets.manoeuvres import KINDS, parse_manoeuvre
    from ..datasets.sensors import parse_noise

    check_seed(seed)
    check_numbers(duration_s=duration_s, dt_s=dt_s)
    if isinstance(model, str) and model.partition(":")[0] in KINDS:
        raise BadInput(f"{model!r} is a manoeuvre, not a model", hint="first the vessel, then the manoeuvre")
    return record_run(
        as_model(model),
        parse_manoeuvre(manoeuvre),
        parse_noise(noise),
        parse_disturbance(disturbance),
        seed=seed,
        duration_s=duration_s,
        dt_s=dt_s,
    )


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
    from ..datasets.rudder_sign import RudderSignWarning, rudder_sign_doubt
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
    refuse_copies(read, others)
    warn_of(admit(read, structure))
    given = [hull_record(record, structure) for record in read]
    estimate = published(fitter.fit(given, structure))
    for doubt in filter(None, map(rudder_sign_doubt, given)):
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
    from .assessment import compare

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
    from .craft import build_model

    found = build_model(train, others, particulars=particulars)
    if found.ship is not None and mean_ratio(found.ahead.scores, SHIP, BUILT) < 1.0 - LEAST:
        return Estimate(
            method="particulars",
            variant="corrected",
            model=found.ship,
            coefficients=found.ship.coefficients,
            covariance=None,
            parameters=dict(found.ship.parameters),
            stderr=dict.fromkeys(found.ship.parameters, float("nan")),
            message=found.notes[-1],
            wall_s=found.wall_s,
            records=tuple(train),
        )
    model, shown = found.model, {n.name: (n.high - n.value) / NORMAL_90 for n in found.numbers}
    parameters = {name: float(value) for name, value in model.parameters.items()}
    return Estimate(
        method="ladder",
        variant="windows",
        model=model,
        coefficients=model.coefficients,
        covariance=found.covariance,
        parameters=parameters,
        stderr={name: shown[name] for name in parameters},
        message=found.reason,
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


def estimate_of(comparison: Comparison, records: Sequence[Record]) -> Estimate:
    """The chosen estimate of a comparison, with its training records."""
    assert comparison.chosen.estimate is not None, "the chosen candidate has an error, so it was fitted"
    return replace(comparison.chosen.estimate, records=tuple(records), comparison=comparison)
