"""The two biases of every log, tried beside the numbers of a model that was identified without them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...datasets.instruments import corrected
from ...estimation.estimates.biases import Biases
from ...estimation.records.naming import named
from ...estimation.results.fit import arithmetic_guard
from ...estimation.selection.minimiser import minimise
from ...estimation.selection.selection import Rules, select
from ...estimation.validation.result import FREE
from ...estimation.validation.validate import TOGETHER, validate
from ...models.errors import BadInput, CannotFit, FitFailed
from ..options import Options
from ..prepared import prepared
from .diagnose import runs_of
from .search import BESIDE, chosen
from .told import extended_model, findings

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model
    from .search import Choice

OPTIONS = Options(base_parameters="identify", only=("rudder_offset", "yaw_rate_bias"))
CLEARLY = 0.9
"""Ratio of the errors of whole free runs, mean over channels, above which nothing is said."""


def biases_of(model: Model, records: Sequence[Record]) -> Biases | None:
    """The biases with which free runs of left-out pieces are predicted clearly better, eq. 9 of
    docs/mathematics/pieces.md; None where there are none, or the records hold too little.

    model : with the coefficients that were identified from the records.  records : as they were read.
    """
    given = prepared(records, model, OPTIONS)
    try:
        with arithmetic_guard():
            choice = chosen(runs_of(model, given, OPTIONS), OPTIONS)
            if not choice.selection.entered or not _needed(choice):
                return None
            beside = replace(extended_model(model, choice, {}), instruments={})
            behind = [corrected(record, _instruments(choice, number)) for number, record in enumerate(given)]
            before, after = _errors(model, records), _errors(beside, behind)
    except (BadInput, CannotFit, FitFailed):
        return None
    shared = [c for c in TOGETHER if before.get(c, 0.0) > 0.0 and after.get(c, 0.0) > 0.0]
    if not shared or np.mean([np.log(after[c] / before[c]) for c in shared]) > np.log(CLEARLY):
        return None
    sizes = [replace(size, parameter=one.cause) for one in findings(choice, identified=True) for size in one.sizes]
    return Biases(tuple(sizes), {n: float(x) for n, x in beside.parameters.items()}, before, after)


def _needed(choice: Choice) -> bool:
    """Whether biases enter also beside a fit without them that starts from the numbers of the fit with them, and not
    only because the first fit without them ended elsewhere."""
    runs, final = choice.runs, choice.selection.final
    values = {n.name: final.value(n.name) for n in runs.bank.own}
    without = minimise(runs, runs.bank.own, values, final.point.own)
    return bool(select(runs, runs.bank.candidates, Rules(*BESIDE), without, runs.bank.own).entered)


def _instruments(choice: Choice, number: int) -> dict[str, float]:
    """Biases of the record of this number, as instruments."""
    names = (name for candidate in choice.selection.candidates for name in candidate.names)
    places = {name: choice.bank.places[name] for name in names}
    return {
        entry: choice.selection.final.value(name)
        for name, place in places.items()
        if place.record in (None, number)
        for entry in place.entries
    }


def _errors(model: Model, records: Sequence[Record]) -> Mapping[str, float]:
    """Channel -> root mean square error of free runs over all records, SI."""
    found = validate({model.id: model}, named(records), ahead=False)
    return {s.channel: s.rmse for s in found.scores if s.record is None and s.horizon == FREE and s.channel}
