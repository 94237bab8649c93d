"""Whether to believe an estimate: free runs, residuals, what the records tell, and published values."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...datasets.record import Record
from ...models.errors import BadInput, CannotFit, FitFailed
from ...models.published import published_values
from ..estimates.assessment import NORMAL_95, Assessment, ParameterTold
from ..estimates.biases import Biases
from ..estimates.comparison import Comparison
from ..estimates.correlation import ChannelResiduals, channel_residuals
from ..estimates.estimate import Estimate
from ..information.identifiability import Identifiability
from ..records.naming import named, numbered
from ..validation.result import Validation
from ..validation.validate import validate

DRAWN = 6
"""Compared candidates whose free runs are drawn."""


def assess(
    estimate: Estimate,
    train: Sequence[Record],
    held_out: Sequence[Record] = (),
    comparison: Comparison | None = None,
    doubts: Sequence[str] = (),
    biases: Biases | None = None,
) -> Assessment:
    """Free runs, residuals, identifiability and published values of an estimate.

    Parameters
    ----------
    train, held_out : records as they were read.
    biases : of the training records, where some were found.

    Raises
    ------
    BadInput : no record suits the model.
    """
    told, not_told = _identifiability(estimate, train)
    return Assessment(
        estimate=estimate,
        train=_validation(estimate, train, ahead=not held_out),
        held_out=_validation(estimate, held_out, ahead=True) if held_out else None,
        train_residuals=channel_residuals(estimate, train),
        held_out_residuals=_held_out_residuals(estimate, held_out),
        parameters=_parameters(estimate, told),
        identifiability=told,
        not_told=not_told,
        doubts=tuple(doubts),
        comparison=comparison,
        compared=None if comparison is None else _compared(comparison, held_out or train),
        biases=biases,
    )


def _validation(estimate: Estimate, records: Sequence[Record], ahead: bool) -> Validation:
    name = f"{estimate.model.family} by {estimate.method}"
    predictors = {} if estimate.predictor is None else {name: estimate.predictor}
    return validate({name: estimate.model}, named(records), predictors, ahead)


def _compared(comparison: Comparison, records: Sequence[Record]) -> Validation:
    """Free runs of the candidates that have an error, the chosen one first, then by error."""
    tested = [one for one in comparison.candidates if np.isfinite(one.error)]
    best = sorted(tested, key=lambda one: (one is not comparison.chosen, one.error))[:DRAWN]
    models = len({one.model.id for one in best}) > 1
    names = numbered([f"{one.model.id} by {one.method}" if models else one.method for one in best])
    fitted = {name: one.estimate for name, one in zip(names, best, strict=True) if one.estimate is not None}
    predictors = {name: one.predictor for name, one in fitted.items() if one.predictor is not None}
    return validate({name: one.model for name, one in fitted.items()}, named(records), predictors, ahead=False)


def _held_out_residuals(estimate: Estimate, records: Sequence[Record]) -> tuple[ChannelResiduals, ...]:
    """Residuals of the held-out records that suit the model; the validation tells of the others."""
    suited: list[Record] = []
    for record in records:
        try:
            channel_residuals(estimate, [record])
        except CannotFit:
            continue
        suited.append(record)
    return channel_residuals(estimate, suited) if suited else ()


def _identifiability(estimate: Estimate, records: Sequence[Record]) -> tuple[Identifiability | None, str]:
    """What the records tell of the parameters, or why that is not known."""
    if not estimate.parameters:
        return None, "a black box has no parameters"
    try:
        return estimate.identifiability(records), ""
    except BadInput as error:
        return None, error.message
    except (CannotFit, FitFailed) as error:
        return None, error.reason


def _parameters(estimate: Estimate, told: Identifiability | None) -> tuple[ParameterTold, ...]:
    model, profiles = estimate.model, estimate.extra.get("profile", {})
    units = dict(zip(model.parameter_names, model.parameter_units, strict=True))
    bounds = {} if told is None else {one.name: one.relative for one in told.parameters}
    published = published_values(model)
    out = []
    for name, value in estimate.parameters.items():
        error = estimate.stderr.get(name, np.nan)
        profile = profiles.get(name)
        half = NORMAL_95 * error
        low, high = (value - half, value + half) if profile is None else (profile["low"], profile["high"])
        bound = bounds.get(name, np.nan)
        out.append(ParameterTold(name, units[name], value, error, low, high, bound, published.get(name, {})))
    return tuple(out)
