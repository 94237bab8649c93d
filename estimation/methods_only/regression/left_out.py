"""The scheme of least squares whose fits predict left-out windows of the records best.

Forward differences take the ship's equations at the beginning of a step, central differences (`midpoint`: the
trapezoid, for first-order equations) in its middle, a state-variable filter after the noise is filtered away.  Which of
them errs least depends on step and noise: each is fitted to all windows but one, its free run along that window is
compared with what was measured, and the least error in all windows decides.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ....datasets.record import Record
from ....models.errors import CannotFit, FitFailed
from ....models.model import Model
from ...numerics import factors
from ...records.series import Series, series_of
from ...regression.filtered import corner_frequencies, filtered_pieces
from ...regression.least_squares import equation_factors, least_squares
from ...regression.schemes import samples_of
from ...simulation.selection import left_out_cost

WINDOWS = 6
"""Windows that all records together are cut into; a record into at least two."""
CORNERS = 5
"""Corner frequencies of the state-variable filter that are tried, from the slowest to the fastest."""
SVF = "svf"
DIFFERENCES = ("midpoint", "forward")
"""Difference schemes that are tried."""


class Scheme(NamedTuple):
    """A scheme of least squares: a difference scheme, or a state-variable filter of corner frequency omega [rad/s]."""

    name: str
    omega: float = np.nan


def schemes_of(records: Sequence[Record]) -> list[Scheme]:
    """Every scheme to choose from: the differences first, which win where they are equal to a filter."""
    corners = corner_frequencies(records, CORNERS).tolist()
    return [*map(Scheme, DIFFERENCES), *(Scheme(SVF, omega) for omega in corners)]


def best_scheme(records: Sequence[Record], model: Model, schemes: Sequence[Scheme] = ()) -> Scheme:
    """The scheme whose fits follow left-out windows best in free runs, the first one where none can be judged.

    schemes : default: `schemes_of` the records.

    Raises
    ------
    CannotFit : no window has a channel of the model, or a record lacks an input.
    """
    windows, schemes = windows_of(records, model), schemes or schemes_of(records)
    costs = [left_out_error(scheme, windows, model) for scheme in schemes]
    return schemes[int(np.argmin(costs))]


def windows_of(records: Sequence[Record], model: Model) -> list[tuple[Record, Series]]:
    """Windows of equal numbers of samples and their measured outputs, without those in which nothing is measured.

    Raises
    ------
    CannotFit : none is left.
    """
    each = max(2, round(WINDOWS / max(len(records), 1)))
    edges = [np.linspace(0, record.n, each + 1).astype(int).tolist() for record in records]
    pieces = [r.slice(a, b) for r, cuts in zip(records, edges, strict=True) for a, b in pairwise(cuts) if b - a > 1]
    found, reason = [], "the records are too short to leave windows out"
    for piece in pieces:
        try:
            found.append((piece, series_of(piece, model)))
        except CannotFit as error:
            reason = error.reason
    if not found:
        raise CannotFit(reason)
    return found


def left_out_error(scheme: Scheme, windows: Sequence[tuple[Record, Series]], model: Model) -> float:
    """Negative log likelihood of free runs along every window of the fit to all others; inf where one has none."""
    try:
        models = [model.with_coefficients(c) for c in _left_out_fits(scheme, [record for record, _ in windows], model)]
        return left_out_cost(models, [series for _, series in windows])
    except (CannotFit, FitFailed):
        return np.inf


def _left_out_fits(scheme: Scheme, records: Sequence[Record], model: Model) -> list[np.ndarray]:
    """Coefficients (p,) of least squares on all windows but one, for each of them.

    Raises
    ------
    CannotFit : as `_window_factors`, or there are no more rows than coefficients.
    FitFailed : no column is finite and non-zero.
    """
    equations, counts = _window_factors(scheme, records, model)
    p, rows = len(model.coordinates), counts.sum(axis=0) - counts
    if rows.sum(axis=1).min() <= p:
        raise CannotFit(f"{rows.sum(axis=1).min()} usable regression rows for {p} coefficients")
    pairs = zip(factors.of_all_others(equations), rows, strict=True)
    return [least_squares(others, behind).coefficients for others, behind in pairs]


def _window_factors(scheme: Scheme, records: Sequence[Record], model: Model) -> tuple[np.ndarray, np.ndarray]:
    """Triangular factors (W, e, p + 1, p + 1) of every window's e equations, and rows (W, e) behind each.

    Raises
    ------
    CannotFit : a record lacks a channel, or no window is long enough for the filter.
    """
    if scheme.name == SVF:
        rows = [list(filtered_pieces(record, model, scheme.omega)) for record in records]
        sources = sorted({part.source for own in rows for part in own})
        if not sources:
            raise CannotFit("every window is too short for the filter")
        found = [equation_factors(own, model, sources) for own in rows]
    else:
        found = [equation_factors([samples_of(record, model, scheme.name)], model) for record in records]
    return np.array([equations for equations, _ in found]), np.array([counts for _, counts in found])
