"""Free runs of a model along records, and their sensitivities folded into triangular factors.

A run starts from an initial state and uses nothing of the record but its inputs.  The derivatives of the measured
states with respect to the coefficients and to chosen initial states come from the generated forward sensitivities.
Pieces of a long record are folded one after the other, so memory does not grow with it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ...models.model import Model
from ..numerics import factors
from ..records.series import Series

PIECE = 400_000
"""Numbers of a sensitivity array that are in memory at a time."""
STRETCH = 4096
"""Samples of a run that are in memory at a time."""


def start_state(model: Model, series: Series, state: np.ndarray) -> np.ndarray:
    """Simulated initial state (n,) from one in which q = r_dot takes the place of the hidden state w = q - c rudder."""
    from ...models.simulate import simulated_states

    return simulated_states(model, state[None], series.inputs[:1, 0])[0]


def residuals(model: Model, series: Series, state: np.ndarray) -> np.ndarray:
    """Measured minus simulated outputs (N, c); nan at gaps, not finite where the run diverges."""
    run = series.observe(_measured_states(model, series, state))
    return np.subtract(series.outputs, run, out=run)


def _measured_states(model: Model, series: Series, state: np.ndarray) -> np.ndarray:
    """The states (M + 1, c) of a free run on the grid that the series has outputs of.

    Of a long run, stretches are simulated one after the other, each of which fits in a processor's cache.
    """
    from ...models.simulate import simulate

    x, last = start_state(model, series, state), len(series.inputs) - 1
    measured = np.empty((last + 1, len(series.columns)))
    for first in range(0, max(last, 1), STRETCH):
        run = simulate(model, series.inputs[first : first + STRETCH + 1], series.dt, x)
        measured[first : first + len(run)] = run[:, series.columns]
        x = run[-1]
    return measured


def squares(model: Model, series: Series, state: np.ndarray) -> np.ndarray:
    """Sum of squared residuals (c,) of each output; inf if the run diverges."""
    return sums_of_squares(series, residuals(model, series, state))


def sums_of_squares(series: Series, error: np.ndarray) -> np.ndarray:
    """Sum of squares (c,) of residuals (N, c) of each output; inf if one is not finite where the output is known."""
    total = error if series.complete else np.where(series.known, error, 0.0)
    return np.where(np.isfinite(total).all(), (total**2).sum(axis=0), np.inf)


def _seed(model: Model, series: Series, free: Sequence[int], p: int) -> np.ndarray:
    """Derivatives (n, p + f) of the simulated initial state: coefficients, then the free initial states."""
    seed = np.zeros((len(model.states), p + len(free)))
    for column, state in enumerate(free):
        seed[state, p + column] = 1.0
    gain = model.kernels.RATE_GAIN
    if gain is not None:
        seed[0, gain] = -series.inputs[0, 0]
    return seed


def _pieces(
    model: Model, series: Series, state: np.ndarray, free: Sequence[int]
) -> Iterator[tuple[slice, np.ndarray, np.ndarray]]:
    """Consecutive stretches of the grid that share their ends, their states (M, n) and derivatives (M, n, p + f)."""
    from ...models.simulate import sensitivities

    seed, x = _seed(model, series, free, len(model.coordinates)), start_state(model, series, state)
    last = len(series.inputs) - 1
    length = max(64, PIECE // seed.size)
    for first in range(0, max(last, 1), length):
        inputs = series.inputs[first : first + length + 1]
        states, columns = sensitivities(model, inputs, series.dt, x, initial=free, seed=seed)
        x, seed = states[-1].copy(), columns[-1].copy()
        yield slice(first, first + len(inputs)), states, columns


def output_factors(
    model: Model,
    series: Series,
    state: np.ndarray,
    free: Sequence[int] = (),
    weights: np.ndarray | None = None,
) -> list[np.ndarray]:
    """For each output, the triangular factor of [derivatives | residual] over the record.

    Columns: p coefficients, then the initial states `free`; rows of gaps are left out, the others multiplied by the
    roots of `weights` (N, c).  A factor holds nan if the run diverges.
    """
    width = len(model.coordinates) + len(free)
    found = [factors.empty(width) for _ in series.columns]
    for rows in _rows(model, series, state, free, weights):
        found = [factors.fold(factor, new) for factor, new in zip(found, rows, strict=True)]
    return found


def output_rows(
    model: Model, series: Series, state: np.ndarray, free: Sequence[int], weights: np.ndarray | None
) -> list[np.ndarray]:
    """For each output, the rows [derivatives | residual] (N, p + f + 1) of which `output_factors` makes a factor."""
    return [np.vstack(rows) for rows in zip(*_rows(model, series, state, free, weights), strict=True)]


def _rows(
    model: Model, series: Series, state: np.ndarray, free: Sequence[int], weights: np.ndarray | None
) -> Iterator[list[np.ndarray]]:
    """For each piece the rows of every output."""
    last = len(series.inputs) - 1
    for index, states, columns in _pieces(model, series, state, free):
        within = _samples_in(series, index.start, index.stop if index.stop > last else index.stop - 1)
        error, slopes = _at_samples(series, index.start, states, columns, within)
        rows = np.concatenate([slopes, error[:, :, None]], axis=2)
        found = []
        for c in range(len(series.columns)):
            known = slice(None) if series.complete else series.known[within, c]
            own = rows[known, c]
            if weights is not None:
                own = own * np.sqrt(weights[within, c][known])[:, None]
            found.append(own)
        yield found


def _samples_in(series: Series, start: int, stop: int) -> slice | np.ndarray:
    """Which samples lie at the points start .. stop - 1 of the grid, or behind them by a part of a step."""
    if series.is_grid:
        return slice(start, min(stop, series.index.size))
    return (series.index >= start) & (series.index < stop)


def _at_samples(
    series: Series, first: int, states: np.ndarray, columns: np.ndarray, within: slice | np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Residuals (N, c) and derivatives (N, c, m) at the samples `within` a stretch from a point of the grid on."""
    index = series.index[within] - first
    measured = _in_a_row(series.columns)
    states, columns = states[:, measured], columns[:, measured]
    if series.on_grid:
        index = _in_a_row(index)
        return series.outputs[within] - states[index], columns[index]
    part = series.part[within]
    after = np.minimum(index + 1, len(states) - 1)
    state = (1.0 - part)[:, None] * states[index] + part[:, None] * states[after]
    column = (1.0 - part)[:, None, None] * columns[index] + part[:, None, None] * columns[after]
    return series.outputs[within] - state, column


def _in_a_row(indices: np.ndarray) -> slice | np.ndarray:
    """Indices as a slice where each is one more than the one before: views instead of copies."""
    first = indices[:1].sum()
    return slice(first, first + indices.size) if np.array_equal(indices, first + np.arange(indices.size)) else indices


def end_state(model: Model, series: Series, state: np.ndarray) -> np.ndarray:
    """State (n,) at the end of the grid, with q = r_dot in the place of the hidden w."""
    from ...models.simulate import simulate

    end = simulate(model, series.inputs, series.dt, start_state(model, series, state))[-1]
    gain = model.kernels.RATE_GAIN
    if gain is not None:
        end[0] += model.coefficients[gain] * series.inputs[-1, 0]
    return end


def end_of(model: Model, series: Series, state: np.ndarray, free: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
    """`end_state` and its derivatives (n, p + f) with respect to the coefficients and the initial states `free`."""
    *_, (_, states, slopes) = _pieces(model, series, state, free)
    end, columns = states[-1].copy(), slopes[-1].copy()
    gain = model.kernels.RATE_GAIN
    if gain is not None:
        end[0] += model.coefficients[gain] * series.inputs[-1, 0]
        columns[0, gain] += series.inputs[-1, 0]
    return end, columns


def embed(factor: np.ndarray, jacobian: np.ndarray | None, n_parameters: int, place: int, width: int) -> np.ndarray:
    """A record's factor (rows, p + f + 1) in the columns of a problem with `width` unknowns, its own f at `place`.

    The first `n_parameters` unknowns determine the p coefficients, which have the derivatives `jacobian`
    (p, n_parameters) with respect to them; None: they are the coefficients.
    """
    wide = np.zeros((len(factor), width + 1))
    p = n_parameters if jacobian is None else len(jacobian)
    wide[:, :n_parameters] = factor[:, :p] if jacobian is None else factor[:, :p] @ jacobian
    wide[:, place : place + factor.shape[1] - 1 - p] = factor[:, p:-1]
    wide[:, -1] = factor[:, -1]
    return wide
