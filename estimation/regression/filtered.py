"""Least squares on records passed through a state-variable filter: rows, the corner frequency, standard errors.

Every channel passes through the same F(s) = omega^n/(s + omega)^n, so all channels have the same lag.  For a linear
model the filtered equation is exact at every omega; for a nonlinear one it is exact up to the curvature within
1/omega.  The filter's initial state adds n known decaying terms to the rows.  They are projected out, so a record may
begin anywhere in a manoeuvre, and its noisy first sample has no influence.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...datasets.record import Record
from ...datasets.signals import bridged
from ...models.errors import CannotFit, FitFailed
from ...models.model import Model
from ..observers.linear import derivatives, transients
from ..records.series import inputs_of, require, samples, series_of
from ..simulation.selection import free_run_cost
from .least_squares import LeastSquares, equation_factors, least_squares
from .samples import LONGEST_STEP, RegressionSamples, check_enough_rows, n_accelerations

ORDER = 4
DENSE = 0.1
"""Filtered rows are kept every DENSE/omega seconds; closer ones would add no information."""
DECAYED = 40.0
"""Time constants after which the effect of the filter's initial state is below rounding."""
EXTRA_ROWS = 4
"""Rows that a stretch needs in addition to those that its initial state takes up."""


def filtered_rows(records: Sequence[Record], model: Model, omega: float, order: int = ORDER) -> list[RegressionSamples]:
    """Rows of every record; a response model takes rows from the yaw rate and from the heading where both are measured.

    Parameters
    ----------
    omega : corner frequency of the filter, rad/s.
    order : number of its poles.

    Raises
    ------
    CannotFit : a record lacks a channel, or there are no more rows than coefficients.
    """
    found = [rows for record in records for rows in filtered_pieces(record, model, omega, order)]
    check_enough_rows(sum(rows.accelerations.size for rows in found), model)
    return found


def _sources(record: Record, model: Model) -> list[str]:
    """Symbols of the channels that the yaw rate is taken from, one after the other."""
    measured = [s for s in ("r", "psi") if (v := samples(record, s)) is not None and np.isfinite(v).sum() > 1]
    if not measured:
        require(record, "psi")
        raise CannotFit(f"record {record.name} has no usable yaw rate or heading")
    return measured[:1] if model.is_3dof else measured


class _Filter:
    """The state-variable filter for one record: its channels are put on an equal time grid and filtered on demand."""

    def __init__(self, record: Record, omega: float, order: int) -> None:
        self.record, self.omega, self.order = record, omega, order
        self.dt = record.dt
        time = record.time_s
        self.grid = time if record.uniform() else np.arange(time[0], time[-1] + 0.5 * self.dt, self.dt)
        self.stride = max(1, int(DENSE / (omega * self.dt)))
        self.time = self.grid[:: self.stride]

    def __call__(self, values: np.ndarray, highest: int, smooth: bool = True) -> np.ndarray:
        """Filtered derivatives 0 .. highest of a channel (N,) of the record, thinned: (n, highest + 1).

        `smooth` is for motions; inputs are taken as linear between samples.
        """
        time = self.record.time_s
        signal = np.interp(self.grid, time, bridged(values, time))
        if smooth:
            signal = sharpened(signal)
        return derivatives(signal, self.dt, self.omega, self.order, highest, self.stride)

    def start(self) -> np.ndarray:
        """(n, order): what the filter's initial state can add; exactly zero once it has decayed."""
        found = transients(len(self.time), self.stride * self.dt, self.omega, self.order)
        found[self.omega * self.stride * self.dt * np.arange(len(found)) > DECAYED] = 0.0
        return found


def sharpened(values: np.ndarray) -> np.ndarray:
    """Samples (N,) whose linear interpolation has the low frequencies of the smooth curve through `values` (N,).

    Linear interpolation of samples dt apart multiplies a frequency w by 1 - (w dt)^2/12.
    """
    found = values.copy()
    found[1:-1] -= np.diff(values, 2) / 12.0
    return found


def stretches(record: Record, channels: Sequence[np.ndarray]) -> list[Record]:
    """The pieces of a record between the long gaps (more than three steps) of any of the channels (N,)."""
    time = record.time_s
    outside, first = np.zeros(record.n, bool), np.zeros(record.n + 1, bool)
    for values in channels:
        known = np.flatnonzero(np.isfinite(values))
        if not known.size:
            return []
        outside[: known[0]] = outside[known[-1] + 1 :] = True
        for gap in np.flatnonzero(np.diff(time[known]) > LONGEST_STEP * record.dt):
            outside[known[gap] + 1 : known[gap + 1]] = True
            first[known[gap + 1]] = True
    edges = np.flatnonzero(first | np.diff(outside, prepend=True, append=True)).tolist()
    return [record.slice(a, b) for a, b in pairwise(edges) if not outside[a]]


def filtered_pieces(record: Record, model: Model, omega: float, order: int = ORDER) -> Iterator[RegressionSamples]:
    """Rows, however few, of every stretch of a record that is long enough, for each source of the yaw rate.

    Raises
    ------
    CannotFit : the record lacks a channel.
    """
    for source in _sources(record, model):
        motions = [require(record, s) for s in model.regression_states if s in ("u", "v")]
        used = [require(record, source), *motions, *inputs_of(record, model).values()]
        for piece in stretches(record, used):
            stride = max(1, int(DENSE / (omega * record.dt)))
            if piece.n > (order + EXTRA_ROWS) * stride:
                yield _rows(piece, model, omega, order, source)


def _rows(record: Record, model: Model, omega: float, order: int, source: str) -> RegressionSamples:
    filtered = _Filter(record, omega, order)
    states, slopes = _yaw(record, model, filtered, source)
    for symbol in {"u", "v"} & {*model.regression_states}:
        states[symbol], slopes[symbol] = filtered(require(record, symbol), 1).T
    inputs = _inputs(record, model, filtered)
    return RegressionSamples.of(model, states, slopes, inputs, filtered.time, source=source, start=filtered.start())


def _yaw(record: Record, model: Model, filtered: _Filter, source: str) -> tuple[dict, dict]:
    """Filtered r, psi and, for second-order equations, q = r_dot; and the slopes of q or r."""
    first = 0 if source == "r" else 1
    second = "q" in model.regression_states
    ranks = filtered(require(record, source), first + (2 if second else 1))[:, first:]
    states, heading = {"r": ranks[:, 0]}, samples(record, "psi")
    if model.is_3dof and heading is not None and np.isfinite(heading).any():
        states["psi"] = filtered(heading, 0)[:, 0]
    if second:
        return states | {"q": ranks[:, 1]}, {"q": ranks[:, 2]}
    return states, {"r": ranks[:, 1]}


def _inputs(record: Record, model: Model, filtered: _Filter) -> dict[str, np.ndarray]:
    given = inputs_of(record, model)
    rudder = filtered(given["delta"], 1, smooth=False)
    found = {name: filtered(values, 0, smooth=False)[:, 0] for name, values in given.items() if name != "delta"}
    return found | {"delta": rudder[:, 0], "delta_rate": rudder[:, 1]}


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
    rows: list[RegressionSamples]
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
    return FilteredFit(omega, rows, least_squares(*equation_factors(rows, model)), np.nan)


def best_corner(records: Sequence[Record], model: Model, order: int = ORDER) -> FilteredFit:
    """`best_of_corners` at `corner_frequencies`, with a filter of `order` poles."""
    corners = corner_frequencies(records)
    return best_of_corners(corners, lambda omega: filtered_rows(records, model, omega, order), records, model)


def best_of_corners(
    corners: np.ndarray,
    rows_at: Callable[[float], list[RegressionSamples]],
    records: Sequence[Record],
    model: Model,
) -> FilteredFit:
    """The fit whose free run follows the training records best, the middle one where no free run is finite.

    Parameters
    ----------
    corners : (n,) frequencies, rad/s.
    rows_at : frequency -> rows; it may raise CannotFit.

    Raises
    ------
    CannotFit : at no frequency can be fitted.
    """
    fits, reason = [], "no corner frequency gives an estimate"
    series = [series_of(record, model) for record in records]
    for omega in corners.tolist():
        try:
            rows = rows_at(omega)
            solution = least_squares(*equation_factors(rows, model))
        except (CannotFit, FitFailed) as error:
            reason = error.reason
            continue
        cost = free_run_cost(model.with_coefficients(solution.coefficients), series)
        fits.append(FilteredFit(omega, rows, solution, cost))
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


def _block_scores(rows: RegressionSamples, fit: FilteredFit, model: Model) -> np.ndarray:
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
    block = ((rows.time_s - rows.time_s[0]) * fit.omega / BLOCK_TIME).astype(np.int64)
    total = np.zeros((block[-1] + 1 if len(block) else 1, phi.shape[2]))
    np.add.at(total, block, np.vstack(scores))
    return total
