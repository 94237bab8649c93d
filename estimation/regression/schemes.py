"""The regression y = Phi c of records by the name of a scheme.

The model says which states, accelerations and inputs its regression takes (`models.simulate.regression`); a scheme
makes them of the channels of a record:

forward
    x_dot[k] = (x[k+1] - x[k])/dt with state and input at k.  This is the difference equation of explicit Euler, so
    records made by explicit Euler are recovered to rounding; for others it is a first-order approximation.
midpoint
    Central differences.  First-order equations: over one step, states and inputs as the mean of both ends.
    Second-order equations: over two steps, states and inputs weighted by the hat function of those steps; exact for a
    rudder that is linear between samples.
heading-difference
    Paper 000, eq 7-11: backward differences of the heading alone, rows multiplied by dt^3 as in its eq 9, the ship
    at rest before the first sample.  Second-order response models only.
triple-integral, triple-integral-held, triple-integral-rest
    The equations integrated until a measured state is reached (`integrated`), with a rudder that is linear or held
    between samples; the last also takes the ship as at rest on heading zero at the first sample.

Differences take a missing yaw rate from the heading.  Their steps need not be equal; a gap, or a step more than three
times the median, removes only the rows that use it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from ...datasets.record import Record
from ...models.errors import CannotFit
from ...models.model import Model
from ..records.series import inputs_of, require, samples, steps
from .integrated import triple_integral
from .samples import LONGEST_STEP, Columns, RegressionSamples, check_enough_rows, n_accelerations


def forward(record: Record, model: Model) -> RegressionSamples:
    """Forward differences of one record, nan at gaps."""
    dt = _usable_steps(record)
    states, inputs = _states(record, model, dt, _forward_slope), inputs_of(record, model)
    if _second_order(model):
        states["q"] = _forward_slope(states["r"], dt)
        inputs["delta_rate"] = _forward_slope(inputs["delta"], dt)
    slopes = {symbol: _forward_slope(states[symbol], dt) for symbol in _moving(model, states)}
    return RegressionSamples.of(model, states, slopes, inputs, record.time_s)


def midpoint(record: Record, model: Model) -> RegressionSamples:
    """Central differences of one record, nan at gaps."""
    dt = _usable_steps(record)
    states, inputs = _states(record, model, dt, _central_slope), inputs_of(record, model)
    if _second_order(model):
        return _hat(record, model, dt, states, inputs)
    slopes = {symbol: np.diff(states[symbol]) / dt for symbol in _moving(model, states)}
    means = [{s: (z[1:] + z[:-1]) / 2.0 for s, z in columns.items()} for columns in (states, inputs)]
    time = (record.time_s[1:] + record.time_s[:-1]) / 2.0
    return RegressionSamples.of(model, means[0], slopes, means[1], time)


def heading_difference(record: Record, model: Model) -> RegressionSamples:
    """Paper 000, eq 7-11: y(k) = psi(k) - psi(k-1), with y(0) = y(-1) = 0.

    Raises
    ------
    CannotFit : the model is no second-order response model, or the time steps are not equal.
    """
    if not _second_order(model):
        raise CannotFit(f"the heading-difference scheme needs a second-order response model, not {model.family}")
    if not record.uniform():
        raise CannotFit(f"record {record.name}: the heading-difference scheme needs equal time steps")
    h = float(steps(record)[0])
    psi, delta = require(record, "psi"), inputs_of(record, model)["delta"]
    y = np.concatenate([[0.0, 0.0], np.diff(psi)])
    y0, y1, y2 = y[2:], y[1:-1], y[:-2]
    columns = {"q": (y0 - y1) / h**2, "r": y0 / h, "psi": psi[1:]}
    inputs = {"delta": delta[1:], "delta_rate": np.diff(delta) / h}
    slopes = {"q": (y0 - 2.0 * y1 + y2) / h**3}
    return RegressionSamples.of(model, columns, slopes, inputs, record.time_s[1:], scale=h**3)


def _second_order(model: Model) -> bool:
    return "delta_rate" in model.regression_inputs


def _usable_steps(record: Record) -> np.ndarray:
    """Time steps (N - 1,), s; nan for those that count as gaps."""
    dt = steps(record)
    if record.uniform():
        return dt
    return np.where(dt > LONGEST_STEP * np.median(dt), np.nan, dt)


def _forward_slope(values: np.ndarray, dt: np.ndarray) -> np.ndarray:
    """Forward difference quotient (N,) of values (N,); the last is nan."""
    return np.append(np.diff(values) / dt, np.nan)


def _central_slope(values: np.ndarray, dt: np.ndarray) -> np.ndarray:
    """Central difference quotient (N,) of values (N,); the ends are nan."""
    inner = (values[2:] - values[:-2]) / (dt[1:] + dt[:-1])
    return np.concatenate([[np.nan], inner, [np.nan]])


def _moving(model: Model, states: Columns) -> list[str]:
    """Those of the states that have an acceleration."""
    return [symbol for symbol in model.regression_states[: n_accelerations(model)] if symbol in states]


def _states(
    record: Record, model: Model, dt: np.ndarray, slope: Callable[[np.ndarray, np.ndarray], np.ndarray]
) -> dict[str, np.ndarray]:
    """Samples (N,) of the measured states by symbol."""
    rate, heading = samples(record, "r"), samples(record, "psi")
    columns = {"r": slope(require(record, "psi"), dt) if rate is None else rate}
    columns |= {} if heading is None else {"psi": heading}
    return columns | {symbol: require(record, symbol) for symbol in model.regression_states if symbol in ("u", "v")}


def _hat(
    record: Record, model: Model, dt: np.ndarray, states: dict[str, np.ndarray], inputs: dict[str, np.ndarray]
) -> RegressionSamples:
    """Second-order equations integrated with the hat function over two steps, divided by its area."""
    before, after = dt[:-1], dt[1:]
    both = before + after

    def mean(z: np.ndarray) -> np.ndarray:
        return (before * (z[:-2] + 2.0 * z[1:-1]) + after * (z[2:] + 2.0 * z[1:-1])) / (3.0 * both)

    def slope(z: np.ndarray) -> np.ndarray:
        return (z[2:] - z[:-2]) / both

    r = states["r"]
    bend = 2.0 * (np.diff(r)[1:] / after - np.diff(r)[:-1] / before) / both
    columns = {name: mean(values) for name, values in states.items()} | {"q": slope(r)}
    u = {name: mean(values) for name, values in inputs.items()} | {"delta_rate": slope(inputs["delta"])}
    return RegressionSamples.of(model, columns, {"q": bend}, u, record.time_s[1:-1])


LOCAL: dict[str, Callable[[Record, Model], RegressionSamples]] = {
    "forward": forward,
    "midpoint": midpoint,
    "heading-difference": heading_difference,
}
"""Schemes whose rows depend on neighbouring samples only."""
INTEGRATED: dict[str, Callable[[Record, Model], RegressionSamples]] = {
    "triple-integral": triple_integral,
    "triple-integral-held": partial(triple_integral, held=True),
    "triple-integral-rest": partial(triple_integral, held=True, rest=True),
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
