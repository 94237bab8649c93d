"""The two biases of every log, tried beside the numbers of a model that was identified without them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...datasets.instruments import corrected
from ...estimation.estimates.assessment import Biases
from ...estimation.records.naming import named
from ...estimation.results.fit import arithmetic_guard
from ...estimation.selection.minimiser import minimise
from ...estimation.selection.selection import Rules, select
from ...estimation.validation.result import FREE
from ...estimation.validation.validate import TOGETHER, validate
from ...models.errors import BadInput, CannotFit, FitFailed
from ..causes.steering_gear import RudderOffset
from ..gain.guard import log_fall
from ..options import Options
from ..prepared import prepared
from .answer import extended_model, findings
from .diagnose import runs_of
from .search import BESIDE, chosen

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model
    from .search import Choice

OPTIONS = Options(base_parameters="identify", only=("rudder_offset", "yaw_rate_bias"))
CLEARLY = 0.9
"""Ratio of the errors of whole free runs, mean over channels, above which nothing is said."""
USUAL, NEARLY_ALL = 2.0 * RudderOffset.prior.sd, 0.1
"""Neutral angles above the first, rad, are told only where the ratio is below the second: a term that the model lacks
is more likely otherwise."""
SIDE = 0.1
"""Least share of the samples with the rudder to either side from which a neutral angle is told."""


def biases_of(model: Model, records: Sequence[Record]) -> Biases | None:
    """The biases with which free runs of left-out pieces are predicted clearly better, eq. 10 of
    docs/mathematics/pieces.md; None where there are none, or the records hold too little.

    model : with the coefficients that were identified from the records.  records : as they were read.
    """
    try:
        with arithmetic_guard():
            behind_model = prepared(records, model, OPTIONS)
            choice = chosen(runs_of(model, behind_model, OPTIONS), OPTIONS)
            if not choice.selection.entered or not _needed(choice):
                return None
            with_biases = replace(extended_model(model, choice, {}), instruments={})
            behind = [corrected(record, _instruments(choice, number)) for number, record in enumerate(behind_model)]
            before, after = _errors(model, records), _errors(with_biases, behind)
    except (BadInput, CannotFit, FitFailed):
        return None
    ratio = np.exp(-log_fall(before, {c: error for c, error in after.items() if c in TOGETHER}))
    sizes = [replace(size, parameter=one.cause) for one in findings(choice, identified=True) for size in one.sizes]
    angles = [size.value for size in sizes if size.parameter == RudderOffset.id]
    usual = max(map(abs, angles), default=0.0) < USUAL
    if ratio > (CLEARLY if usual else NEARLY_ALL) or not _on_both_sides(behind_model, angles):
        return None
    if not any(size.low > 0.0 or size.high < 0.0 for size in sizes):
        return None
    return Biases(tuple(sizes), {n: float(x) for n, x in with_biases.parameters.items()}, before, after)


def _instruments(choice: Choice, record: int) -> dict[str, float]:
    """Instruments of rudder and sensors that a choice says a record has, by its number."""
    places, values = choice.bank.places, choice.selection.final.value
    names = [name for c in choice.selection.candidates for name in c.names if places[name].record in (None, record)]
    return {entry: x for name in names if (x := values(name)) for entry in places[name].entries}


def _on_both_sides(records: Sequence[Record], angles: Sequence[float]) -> bool:
    """Whether the rudder is on both sides, beyond all neutral angles: a turn to one side alone does not tell an offset
    from damping that grows with the yaw rate."""
    rudder, size = np.concatenate([record.rudder() for record in records]), max(map(abs, angles), default=0.0)
    return not angles or bool(min(np.mean(rudder > size), np.mean(rudder < -size)) > SIDE)


def _needed(choice: Choice) -> bool:
    """Whether biases enter also beside a fit without them that starts from the numbers of the fit with them, and not
    only because the first fit without them ended elsewhere."""
    runs, final = choice.runs, choice.selection.final
    values = {n.name: final.value(n.name) for n in runs.bank.own}
    without = minimise(runs, runs.bank.own, values, final.point.own)
    return bool(select(runs, runs.bank.candidates, Rules(*BESIDE), without, runs.bank.own).entered)


def _errors(model: Model, records: Sequence[Record]) -> Mapping[str, float]:
    """Channel -> root mean square error of free runs over all records, SI."""
    validation = validate({model.id: model}, named(records), ahead=False)
    return {s.channel: s.rmse for s in validation.scores if s.record is None and s.horizon == FREE and s.channel}
