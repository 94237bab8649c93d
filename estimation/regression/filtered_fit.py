"""Least squares on state-variable filtered records: the corner frequency, the fit and its standard errors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...datasets.record import Record
from ...models.errors import CannotFit, FitFailed
from ...models.model import Model
from ..records.series import series_of
from ..simulation.selection import free_run_cost
from .filtered import ORDER, FilteredRows, filtered_rows, row_factors
from .least_squares import LeastSquares, least_squares
from .samples import n_accelerations

CORNERS = 11
"""Corner frequencies tried."""
FASTEST, SLOWEST = 1.0, 60.0
"""omega dt of the fastest corner tried, and time constants of the slowest one in the longest record."""
BLOCK_TIME = 20.0
"""Length, in time constants of the filter, of the blocks of rows whose errors count as independent."""
FEWEST_BLOCKS = 10
"""Blocks per coefficient below which the errors are taken as equally large in all directions."""


class FilteredFit(NamedTuple):
    """Least squares at one corner frequency omega [rad/s]; `cost` ranks it (smaller is better)."""

    omega: float
    rows: list[FilteredRows]
    solution: LeastSquares
    cost: float


def corner_frequencies(records: Sequence[Record], count: int = CORNERS, slowest: float = SLOWEST) -> np.ndarray:
    """Corner frequencies (count,), rad/s, from the slowest that the longest record allows (so many of its time
    constants) to that of the sampling."""
    dt = max(record.dt for record in records)
    length = max(record.time_s[-1] - record.time_s[0] for record in records)
    return np.geomspace(min(slowest / length, FASTEST / dt), FASTEST / dt, count)


def fit_filtered(records: Sequence[Record], model: Model, omega: float, order: int = ORDER) -> FilteredFit:
    """Least squares at a corner frequency omega [rad/s], with a filter of `order` poles; its cost is nan.

    Raises
    ------
    CannotFit : a record lacks a channel, or there are no more rows than coefficients.
    FitFailed : no column is finite and non-zero.
    """
    rows = filtered_rows(records, model, omega, order)
    return FilteredFit(omega, rows, least_squares(*row_factors(rows, model)), np.nan)


def best_corner(records: Sequence[Record], model: Model, order: int = ORDER) -> FilteredFit:
    """The fit, among those at `corner_frequencies`, whose free run follows the training records best.

    Raises
    ------
    CannotFit : no corner frequency can be fitted.
    """
    fits, reason = [], "no corner frequency gives an estimate"
    series = [series_of(record, model) for record in records]
    for omega in corner_frequencies(records).tolist():
        try:
            fit = fit_filtered(records, model, omega, order)
        except (CannotFit, FitFailed) as error:
            reason = error.reason
            continue
        fits.append(fit._replace(cost=free_run_cost(model.with_coefficients(fit.solution.coefficients), series)))
    if not fits:
        raise CannotFit(reason)
    if np.isfinite([fit.cost for fit in fits]).any():
        return min(fits, key=lambda fit: fit.cost)
    return fits[len(fits) // 2]


def coloured_covariance(fit: FilteredFit, model: Model) -> np.ndarray:
    """Covariance (p, p) of the coefficients that allows for errors coloured by the filter (block sandwich).

    The scores of the rows are summed over blocks of `BLOCK_TIME` time constants, which count as independent.
    """
    solution = fit.solution
    scores = np.vstack([_block_scores(rows, fit, model) for rows in fit.rows]) @ solution.half
    p = solution.half.shape[1]
    middle = scores.T @ scores * len(scores) / max(len(scores) - p, 1)
    if len(scores) < FEWEST_BLOCKS * p:
        middle = np.eye(p) * max(np.trace(middle) / max(p, 1), 1.0)
    covariance = solution.half @ middle @ solution.half.T
    unknown = ~np.isfinite(np.diag(solution.covariance))
    covariance[unknown, unknown] = np.inf
    return covariance


def _block_scores(rows: FilteredRows, fit: FilteredFit, model: Model) -> np.ndarray:
    """Sums (B, p) of Phi' e/sd^2 over blocks of rows."""
    k = n_accelerations(model)
    sources = sorted({r.source for r in fit.rows})
    first = sources.index(rows.source) * k
    sd = fit.solution.residual_sd[first : first + k]
    sd = np.where(np.isfinite(sd) & (sd > 0.0), sd, np.inf)
    scores = []
    for y, phi in rows.blocks(model):
        error = (y - phi @ fit.solution.coefficients) / sd**2
        scores.append(np.einsum("nkp,nk->np", phi, error))
    block = ((rows.parts.time_s - rows.parts.time_s[0]) * fit.omega / BLOCK_TIME).astype(np.int64)
    total = np.zeros((block[-1] + 1 if len(block) else 1, phi.shape[2]))
    np.add.at(total, block, np.vstack(scores))
    return total
