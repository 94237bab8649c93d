"""The regression y = Phi c of records by the name of a scheme.

The model says which states, accelerations and inputs its regression takes (`models.simulate.regression`); a scheme
makes them of the channels of a record:

forward, midpoint, heading-difference
    Difference quotients (`differences`).
triple-integral, triple-integral-held, triple-integral-rest
    The equations integrated until a measured state is reached (`integrated`), with a rudder that is linear or held
    between samples; the last also takes the ship as at rest on heading zero at the first sample.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ...datasets.record import Record
from ...models.model import Model
from .differences import forward, heading_difference, midpoint
from .integrated import triple_integral, triple_integral_held, triple_integral_rest
from .samples import RegressionSamples, check_enough_rows

LOCAL: dict[str, Callable[[Record, Model], RegressionSamples]] = {
    "forward": forward,
    "midpoint": midpoint,
    "heading-difference": heading_difference,
}
"""Schemes whose rows depend on neighbouring samples only."""
INTEGRATED: dict[str, Callable[[Record, Model], RegressionSamples]] = {
    "triple-integral": triple_integral,
    "triple-integral-held": triple_integral_held,
    "triple-integral-rest": triple_integral_rest,
}
"""Schemes whose errors are correlated over the whole record."""
SCHEMES = LOCAL | INTEGRATED


def regression_samples(records: Sequence[Record], model: Model, scheme: str) -> list[RegressionSamples]:
    """Regression samples of every record, without gaps.

    Raises
    ------
    CannotFit : a record lacks a channel, the scheme does not suit the model, or all records have no more rows than
        there are coefficients.
    """
    found = [samples_of(record, model, scheme) for record in records]
    check_enough_rows(sum(part.accelerations.size for part in found), model)
    return found


def samples_of(record: Record, model: Model, scheme: str) -> RegressionSamples:
    """Regression samples of one record, however few, without gaps.

    Raises
    ------
    CannotFit : the record lacks a channel, or the scheme does not suit the model.
    """
    parts = SCHEMES[scheme](record, model)
    good = _finite(parts.states) & _finite(parts.accelerations) & _finite(parts.inputs)
    rows = np.flatnonzero(good)
    in_turn = rows.size and rows[-1] - rows[0] == rows.size - 1
    kept = slice(rows[0], rows[-1] + 1) if in_turn else rows
    return parts.at(kept)


def _finite(table: np.ndarray) -> np.ndarray:
    """(N,) rows of a table (N, m) without gaps."""
    return np.asarray(np.isfinite(table).all(axis=1))
